#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What holds when a locator ends, dies, comes again, or lives through a clock that is set back."""
import os
import signal
import subprocess
import sys
import time
import unittest

import roslib.packages
import rospkg
import rospy
import rostest
import tf2_ros
from planar_bin_picking.srv import LocatePart, LocatePartResponse
from rosgraph_msgs.msg import Clock

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
from driven_cell import DrivenCell

UP = 60.0  # s, for the node to come up; machines may be busy


class Restart(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rospkg.RosPack().get_path("planar_bin_picking")
        cls.program = roslib.packages.find_node("planar_bin_picking", "locator")[0]
        cls.cell = DrivenCell(os.path.join(cls.folder, "test/data/bin_bracket_00"))
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)

    def setUp(self):
        self.cell.good()
        self.process = None

    def tearDown(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def start(self, name):
        rospy.set_param(name + "/cell", dict(
            target_frame="base", distance_min=0.78, distance_max=0.98,
            parts_folder=os.path.join(self.folder, "config/parts")))
        self.process = subprocess.Popen([self.program, "__name:=" + name])
        rospy.wait_for_service(name + "/locate_part", UP)

    def end(self, how):
        self.process.send_signal(how)
        self.process.wait(UP)
        self.process = None

    def call(self, name, **fields):
        fields.setdefault("timeout", rospy.Duration(30.0))
        return rospy.ServiceProxy(name + "/locate_part", LocatePart)(part="bracket", **fields)

    def stands(self, frame, expected, seconds=10.0):
        end = time.monotonic() + seconds
        while self.buffer.can_transform("base", frame, rospy.Time(0)) != expected:
            if time.monotonic() > end:
                return not expected
            time.sleep(0.02)
        return expected

    def locate(self, name):
        answer = self.call(name)
        self.assertEqual(answer.status, LocatePartResponse.OK, answer.message)
        self.assertTrue(self.stands(answer.parts[0].child_frame, True))
        return answer

    def test_frames_go_with_their_node(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            self.start("reborn")
            frame = self.locate("reborn").parts[0].child_frame
            self.assertEqual(frame, "reborn/bracket_1")
            self.end(how)
            self.assertFalse(self.stands(frame, False))

    def test_frames_of_a_dead_process_are_withdrawn_by_the_next(self):
        self.start("reborn")
        answer = self.locate("reborn")
        last = answer.parts[-1].child_frame
        self.assertTrue(self.stands(last, True))
        self.end(signal.SIGKILL)
        self.assertTrue(self.stands(last, True))  # nobody was left to withdraw it
        self.assertFalse(self.buffer.can_transform("base", last, rospy.Time.now()))
        self.start("reborn")
        self.assertFalse(self.stands(last, False))
        self.assertFalse(self.stands("reborn/bracket_1", False))
        self.locate("reborn")

    def start_in_simulated_time(self):
        """@return  runs the clock for some seconds, so much behind the real one"""
        clock = rospy.Publisher("/clock", Clock, queue_size=1)
        rospy.set_param("/use_sim_time", True)
        try:
            self.start("simulated")
        finally:
            rospy.set_param("/use_sim_time", False)

        def run_clock(behind, seconds):
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                clock.publish(Clock(rospy.Time.now() - rospy.Duration(behind)))
                time.sleep(0.01)
        return run_clock

    def test_an_image_from_before_the_clock_was_set_back_is_not_used(self):
        run_clock = self.start_in_simulated_time()
        run_clock(0.0, 2.0)
        before = rospy.Time.now() - rospy.Duration(1.0)
        stored = self.call("simulated", not_before=before)
        self.assertEqual(stored.status, LocatePartResponse.OK, stored.message)
        self.cell.change(has_images=False)
        run_clock(0.0, 0.5)
        run_clock(100.0, 0.5)
        # Its stamp is 100 s later than what is asked for, and yet it is from before.
        again = self.call("simulated", not_before=before - rospy.Duration(99.0),
                          timeout=rospy.Duration(0.5))
        self.assertEqual(again.status, LocatePartResponse.NO_IMAGE, again.message)

    def test_images_without_camera_info_do_not_block_those_after_the_clock_was_set_back(self):
        run_clock = self.start_in_simulated_time()
        self.cell.change(has_info=False)
        run_clock(0.0, 4.0)  # 20 images that wait
        self.cell.change(has_info=True, image_lead=-100.0)
        run_clock(100.0, 1.0)
        answer = self.call("simulated", timeout=rospy.Duration(5.0))
        # tf has not gone back, so the call may end there; but the image has come.
        self.assertNotEqual(answer.status, LocatePartResponse.NO_IMAGE, answer.message)


if __name__ == "__main__":
    rospy.init_node("restart_tester")
    rostest.rosrun("planar_bin_picking", "restart", Restart, sys.argv)
