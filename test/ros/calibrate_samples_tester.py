#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Calibrators in the cell of calibrate_samples.test: nothing that was taken is lost, whatever fails later; samples
are listed, left out and added to; and a calibration is held against what the camera sees now."""
import hashlib
import os
import shutil
import subprocess
import sys
import time

import roslib.packages
import rospkg
import rospy
import rostest
import yaml
from planar_bin_picking.srv import MoveRobot, MoveRobotRequest, RemoveSample
from tf2_msgs.msg import TFMessage

from calibration_fixture import Calibrator, ENDS, InCell, PICTURE_PASSES, until

FOLDER = os.path.join(rospkg.get_ros_home(), "calibrate_kept")
CHILD = "hung_on_camera"  # of test/ros/calibration/hand_eye.yaml


def read(name):
    with open(os.path.join(FOLDER, name)) as f:
        return yaml.safe_load(f)


def contents():
    """What is in the folder, to the byte."""
    found = {}
    for at, _, names in os.walk(FOLDER):
        for name in names:
            with open(os.path.join(at, name), "rb") as f:
                found[os.path.join(at, name)] = hashlib.sha256(f.read()).hexdigest()
    return found


class CalibrateSamples(InCell):
    def remove(self, number):
        return rospy.ServiceProxy("/calibrator/remove_sample", RemoveSample)(number=number)

    def check_call(self, calibrator, what, *words, success=True):
        answer = calibrator.call(what)
        self.assertEqual(answer.success, success, answer.message)
        for word in words:
            self.assertIn(word, answer.message)
        return answer.message

    def move_to(self, target):
        request = MoveRobotRequest(target=target, speed_scale=1.0)
        self.assertTrue(rospy.ServiceProxy("/move_robot", MoveRobot)(request).success)
        time.sleep(0.1)

    def fail_late(self, pictures):
        """A run whose robot breaks off once there are so many pictures."""
        self.begin("")
        text = f", {pictures} pictures so far"
        self.assertTrue(until(lambda: text in self.calibrator.said[-1] or self.calibrator.has_ended(), 60.0))
        self.cell.behave("protective")
        self.check_end("FAILED: ", "light curtain", " samples are kept: ~finish solves them")
        self.cell.behave("")

    def test_late_failure(self):
        shutil.rmtree(FOLDER, ignore_errors=True)
        heir = Calibrator("/heir")
        self.check_call(heir, "load_samples", "corners.yaml", success=False)
        self.check_call(self.calibrator, "verify", "hand_eye.yaml", success=False)
        self.fail_late(9)
        count = len(read("samples.yaml"))
        self.assertGreaterEqual(count, 9)
        self.assertFalse(os.path.exists(FOLDER + "/hand_eye.yaml"))
        self.assertIn(f"{count} samples\n1: samples/picture_001.png from [", self.check_call(self.calibrator, "list_samples"))

        # Off line.
        tool = roslib.packages.find_node("planar_bin_picking", "calibrate_samples")[0]
        done = subprocess.run([tool, "--board", "9x6", "--square", "0.02", "--mode", "eye_in_hand",
                               "--samples", FOLDER + "/samples.yaml", "--output", FOLDER + "_offline"], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

        # By another process, as after a restart; without the pictures, from the corners alone.
        self.check_call(heir, "finish", "there are no samples", success=False)
        self.check_call(Calibrator("/other_board"), "load_samples", "another board", success=False)
        self.check_call(heir, "load_samples", f"loaded {count} samples")
        self.check_call(heir, "load_samples", "there are samples already", success=False)
        self.check_call(heir, "finish", "GOOD: ")
        with open(FOLDER + "_offline/hand_eye.yaml") as f:
            offline = yaml.safe_load(f)["position"]
        for a, b in zip(read("hand_eye.yaml")["position"], offline):
            self.assertAlmostEqual(a, b, 4)
        self.check_call(heir, "finish", "there are no samples", success=False)

        # With a wanted error that is out of reach: POOR takes no GOOD one's place.
        self.check_call(self.calibrator, "finish", "POOR: ", "calibrate_kept/poor/report.html")
        self.assertEqual([read(name)["verdict"] for name in ("hand_eye.yaml", "poor/hand_eye.yaml")], ["GOOD", "POOR"])
        self.check_call(self.calibrator, "load_samples", f"loaded {count} samples")

        self.check_samples_are_left_out_and_added(count)
        self.check_verify()
        self.check_refused_leaves_nothing_valid()

    def check_samples_are_left_out_and_added(self, count):
        answer = self.remove(count + 1)
        self.assertFalse(answer.success)
        self.assertIn(f"no sample {count + 1} of {count}", answer.message)
        answer = self.remove(2)
        self.assertTrue(answer.success, answer.message)
        self.assertIn(f"left are {count - 1} samples", answer.message)
        self.assertNotIn("picture_002", answer.message)
        self.assertFalse(os.path.exists(FOLDER + "/samples/picture_002.png"))
        self.assertEqual(len(read("samples.yaml")), count - 1)
        heir = Calibrator("/heir")
        self.go_to_start()
        heir.said.clear()
        self.assertTrue(heir.call("add_views").success)  # to those in the folder
        end = self.check_end("GOOD: ", calibrator=heir, seconds=90.0)
        self.assertNotIn("are kept", end)
        self.assertGreaterEqual(len(read("samples.yaml")), count - 1 + 3)
        self.assertIn("samples/picture_003.png", [s["image"] for s in read("samples.yaml")])
        self.assertFalse(os.path.exists(FOLDER + "/earlier_samples"))
        self.assertTrue(self.remove(0).success)  # of /calibrator
        self.assertIn("0 samples", self.check_call(self.calibrator, "list_samples"))
        self.assertEqual(len(read("earlier_samples/samples.yaml")), len(read("earlier_samples/corners.yaml")["samples"]))

    def check_verify(self):
        """What moved, and by how much; the files stay as they are."""
        heir = Calibrator("/heir")
        self.go_to_start()
        before, asked = contents(), len(self.cell.targets)
        self.check_call(heir, "verify", "the calibration holds: ", " would be expected")
        rospy.set_param("/calibration_cell/bump_mm", 4.0)
        try:
            self.go_to_start()  # where the board is in view
            time.sleep(PICTURE_PASSES)
            calibrator = self.calibrator  # it has seen nothing of before
            self.check_call(calibrator, "verify", "camera or board has moved by ", "a further view", success=False)
            self.assertEqual(contents(), before)
            for target in self.cell.targets[2:4]:
                self.move_to(target)
                answer = calibrator.call("verify")
            self.assertFalse(answer.success)
            self.assertIn("has moved", answer.message)
        finally:
            rospy.set_param("/calibration_cell/bump_mm", 0.0)
        self.assertEqual(contents(), before)
        self.assertGreaterEqual(len(self.cell.targets), asked + 3)  # the tester's own alone
        self.assertEqual(len(self.cell.targets), asked + 3)

    def check_refused_leaves_nothing_valid(self):
        self.go_to_start()
        self.assertTrue(os.path.exists(FOLDER + "/hand_eye.yaml"))
        self.check_call(self.calibrator, "add_sample", "taken; there are 1 samples")
        self.check_call(self.calibrator, "finish", "REFUSED: too few views", success=False)
        self.assertEqual(read("calibration.yaml")["verdict"], "REFUSED")
        for name in ("hand_eye.yaml", "camera_info.yaml", "hand_eye.xacro", "static_transform.launch"):
            self.assertFalse(os.path.exists(f"{FOLDER}/{name}"), name)
            self.assertTrue(os.path.exists(f"{FOLDER}/{name}.before"), name)

    def launch_hand_eye(self, *arguments):
        """@return  what the launch said once it has ended by itself; None where it publishes the camera's place."""
        published = []
        tf_static = rospy.Subscriber("/tf_static", TFMessage, lambda m: published.extend(t.child_frame_id for t in m.transforms))
        launch = subprocess.Popen(["roslaunch", "--wait", "planar_bin_picking", "hand_eye.launch", *arguments],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            self.assertTrue(until(lambda: CHILD in published or launch.poll() is not None), published)
            return None if launch.poll() is None else launch.communicate()[0]
        finally:
            tf_static.unregister()
            launch.terminate()
            launch.wait(20)

    def test_poor_and_expired(self):
        """A cell does not start with them, unless it is told to."""
        folder = os.path.join(rospkg.get_ros_home(), "calibrate_poor")
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        own = os.path.join(rospkg.RosPack().get_path("planar_bin_picking"), "test/ros/calibration/hand_eye.yaml")
        shutil.copy(own, folder)
        file = f"file:={folder}/hand_eye.yaml"
        with open(folder + "/calibration.yaml", "w") as f:
            f.write("verdict: POOR\n")
        said = self.launch_hand_eye(file)
        self.assertIsNotNone(said, "a POOR calibration is used")
        self.assertIn("the calibration is POOR", said)
        self.assertIsNone(self.launch_hand_eye(file, "accept_poor_calibration:=true"))
        with open(folder + "/calibration.yaml", "w") as f:
            f.write("verdict: GOOD\ndate: 2020-01-31T12:00:00Z\n")
        said = self.launch_hand_eye(file)
        self.assertIsNotNone(said, "an old calibration is used")
        self.assertIn("days old, allowed are 365", said)
        self.assertIsNone(self.launch_hand_eye(file, "calibration_max_age_days:=0"))

    def test_full_disk(self):
        full = Calibrator("/full")
        asked = len(self.cell.targets)
        full.start()
        self.check_end("FAILED: ", "picture_001.png", "cannot be written", "make room", calibrator=full)
        self.assertEqual(len(self.cell.targets), asked)

    def test_folder_goes_bad(self):
        """In the middle of a run: the robot is told to stop, and what is in memory stays."""
        blocked, folder = Calibrator("/blocked"), os.path.join(rospkg.get_ros_home(), "calibrate_blocked")
        shutil.rmtree(folder, ignore_errors=True)
        self.begin("slow_ways", blocked)
        shutil.rmtree(folder + "/samples")
        with open(folder + "/samples", "w"):
            pass
        end = self.check_end("FAILED: ", "/samples/picture_00", "told to stop, and confirmed it",
                             "are kept: ~finish solves them", calibrator=blocked)
        self.assertTrue(end.startswith(ENDS))
        self.check_still()
        os.remove(folder + "/samples")
        message = self.check_call(blocked, "finish", "REFUSED: too few views", success=False)
        self.assertIn("needed are 8", message)
        self.check_call(blocked, "list_samples", "2 samples")


if __name__ == "__main__":
    rospy.init_node("calibrate_samples_tester")
    rostest.rosrun("planar_bin_picking", "calibrate_samples", CalibrateSamples, sys.argv)
