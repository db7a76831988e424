#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Calibrators in the cell of calibrate_faults.test: what they do when the robot, the camera, tf or people do what they
should not, and that nothing moves after a stop."""
import os
import signal
import sys
import threading
import time

import rospkg
import rospy
import rostest
import yaml

from calibration_fixture import Calibrator, Cell, InCell, PICTURE_PASSES, UNCONFIRMED, until


class CalibrateFaults(InCell):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.keys_cell, cls.keys = Cell("/keys"), Calibrator("/keys/calibrator")

    # --- stops ---

    def test_abort_after_last_move(self):
        for wait in (0.15, 0.3):  # while it looks, computes, and is about to go back
            self.go_to_start()
            first = self.cell.moves
            self.calibrator.start()
            self.assertTrue(until(lambda: self.cell.moves >= first + 4))
            time.sleep(wait)
            answer = self.calibrator.call("abort")
            self.assertEqual((answer.success, answer.message), (True, "stopped"))
            self.check_still()
            self.check_end("ABORTED")

    def test_abort_during_move(self):
        self.begin("slow")
        time.sleep(0.3)
        plan = self.calibrator.call("plan")
        self.assertTrue(plan.success and ", 1 planned" in plan.message, plan.message)
        for what in ("start", "add_sample", "finish"):
            answer = self.calibrator.call(what)
            self.assertFalse(answer.success)
            self.assertIn("a calibration is under way; ~abort ends it", answer.message)
        start = time.monotonic()
        answer = self.calibrator.call("abort")
        self.assertLess(time.monotonic() - start, 1.0)
        self.assertEqual((answer.success, answer.message), (True, "stopped"))
        self.check_still()
        self.check_end("ABORTED: ", "no calibration was saved")

    def test_abort_overtakes_move(self):
        self.begin("late")
        self.assertTrue(self.calibrator.call("abort").success)
        self.check_still()
        self.check_end("ABORTED")

    def test_abort_while_waiting_for_image(self):
        self.cell.behave("blind")
        time.sleep(PICTURE_PASSES)
        self.calibrator.start()
        time.sleep(0.3)
        start = time.monotonic()
        self.assertTrue(self.calibrator.call("abort").success)
        self.check_end("ABORTED", seconds=0.5)
        self.assertLess(time.monotonic() - start, 0.2)
        # The camera's pictures are awaited again afterwards.
        self.cell.behave("")
        answer = self.calibrator.call("plan")
        self.assertTrue(answer.success, answer.message)

    def test_abort_without_run(self):
        answer = self.calibrator.call("abort")
        self.assertEqual((answer.success, answer.message), (False, "no calibration is under way"))

    def test_robot_that_does_not_stop(self):
        self.begin("runs_on")
        start = time.monotonic()
        answer = self.calibrator.call("abort")
        self.assertLess(time.monotonic() - start, 2.0)  # stop_timeout is 1 s
        self.assertFalse(answer.success)
        self.assertIn(UNCONFIRMED, answer.message)
        self.check_end("FAILED: " + UNCONFIRMED)
        asked = len(self.cell.targets)
        time.sleep(0.5)
        self.assertEqual(len(self.cell.targets), asked)

    def test_robot_that_is_dead(self):
        self.begin("dead")
        start = time.monotonic()
        answer = self.calibrator.call("abort")
        self.assertLess(time.monotonic() - start, 2.5)
        self.assertIn(UNCONFIRMED, answer.message)
        self.check_end("FAILED: " + UNCONFIRMED)

    def check_signal(self, name, end):
        calibrator = Calibrator(name)
        self.begin("slow", calibrator)
        api, pid = calibrator.process()
        stops = self.cell.stops
        time.sleep(0.3)
        end(api, pid)
        self.assertTrue(until(lambda: self.cell.stops > stops, 1.0), "no stop was sent")
        self.assertTrue(until(lambda: not os.path.exists(f"/proc/{pid}/cmdline")
                              or open(f"/proc/{pid}/stat").read().split()[2] == "Z", 5.0), "it runs on")
        self.check_end("ABORTED", calibrator=calibrator)
        self.check_still()

    def test_interrupt(self):
        self.check_signal("/interrupted", lambda _, pid: os.kill(pid, signal.SIGINT))

    def test_terminate(self):
        self.check_signal("/terminated", lambda _, pid: os.kill(pid, signal.SIGTERM))

    def test_rosnode_kill(self):
        self.check_signal("/killed", lambda api, _: api.shutdown("/tester", "test"))

    # --- motions that go wrong ---

    def test_protective_stop(self):
        stops = self.check_fault("protective", "the light curtain was broken", "confirmed it")
        self.assertTrue(until(lambda: self.cell.stops > stops, 1.0))

    def test_move_that_hangs(self):
        start = time.monotonic()
        self.check_fault("hangs", "did not answer within move_timeout", "not confirmed")
        self.assertGreater(time.monotonic() - start, 3.0)
        self.assertLess(time.monotonic() - start, 7.0)

    def test_robot_that_dies(self):
        self.check_fault("dies", "/move_robot broke off")
        self.cell.behave("")
        until(lambda: self.calibrator.call("plan").success)  # it is started again

    def test_goes_elsewhere(self):
        self.check_fault("elsewhere", "the robot says that it stands 5", "from where it was sent")
        self.check_fault("lies", "tf is stale", "the flange 5")

    def test_reached_limits(self):
        strict, lenient = Calibrator("/strict"), Calibrator("/lenient")
        self.check_fault("elsewhere", "and 1 deg", "allowed are 20 mm", "0.5 deg", calibrator=strict)
        self.go_to_start()
        first = self.cell.moves
        self.begin("elsewhere", lenient)
        self.assertTrue(until(lambda: self.cell.moves > first + 1), lenient.said)
        lenient.call("abort")
        self.check_end("ABORTED", calibrator=lenient)

    def test_does_not_move(self):
        self.check_fault("still", "the robot says that it stands", "from where it was sent", "confirmed it")

    def test_says_nonsense(self):
        self.check_fault("nan", "nan mm")
        self.check_fault("frame", 'in frame "flange"', "must be base")

    # --- pictures, tf, files ---

    def check_refused(self, calibrator, *words):
        asked = len(self.cell.targets)
        calibrator.start()
        self.check_end("FAILED: ", *words, calibrator=calibrator)
        self.assertEqual(len(self.cell.targets), asked)

    def test_no_image(self):
        self.cell.behave("blind")
        time.sleep(PICTURE_PASSES)
        start = time.monotonic()
        self.check_refused(self.calibrator, "image")
        self.assertGreater(time.monotonic() - start, 1.9)  # image_timeout
        self.assertLess(time.monotonic() - start, 4.0)

    def check_lost(self, manner, *words):
        """Something is lost in the middle of a run: the robot is told to stop."""
        self.begin("slow_ways")
        stops = self.cell.stops
        self.cell.behave(manner)
        self.check_end("FAILED: ", *words, "told to stop, and confirmed it")
        self.assertTrue(until(lambda: self.cell.stops > stops, 1.0))
        self.check_still()

    def test_image_lost_in_run(self):
        self.check_lost("blind", "image")

    def test_tf_lost_in_run(self):
        self.check_lost("no_tf", "tf has no way")

    def test_frames(self):
        self.check_refused(Calibrator("/strange"), "from base to nowhere")
        answer = Calibrator("/other").call("plan")
        self.assertFalse(answer.success)
        self.assertIn("from nowhere to flange", answer.message)

    def test_folder(self):
        self.check_refused(Calibrator("/other"), "/dev/null", "folder")

    def test_blurred(self):
        self.check_refused(Calibrator("/sharp"), "blurred")

    def test_tf_timeout(self):
        self.cell.behave("late_tf")
        time.sleep(1.5)
        hasty, sharp = Calibrator("/hasty"), Calibrator("/sharp")
        answer = hasty.call("plan")
        self.assertFalse(answer.success)
        self.assertIn("tf has no way", answer.message)
        answer = sharp.call("plan")
        self.assertTrue(answer.success, answer.message)

    # --- calls that overlap ---

    def test_overlap(self):
        self.cell.behave("blind")
        time.sleep(PICTURE_PASSES)
        answers = {}
        thread = threading.Thread(target=lambda: answers.update(sample=self.calibrator.call("add_sample")))
        thread.start()
        time.sleep(0.5)
        for what in ("start", "plan", "finish", "add_sample"):
            answer = self.calibrator.call(what)
            self.assertFalse(answer.success)
            self.assertIn("~add_sample is under way; call again", answer.message)
        self.assertFalse(self.calibrator.call("abort").success)
        thread.join()
        self.assertIn("image", answers["sample"].message)

    def test_many_calls(self):
        answers, lock = [], threading.Lock()

        def call(what):
            for _ in range(6):
                answer = self.calibrator.call(what)
                with lock:
                    answers.append((what, answer))

        self.cell.behave("slow")
        threads = [threading.Thread(target=call, args=(what,))
                   for what in ("plan", "add_sample", "finish", "start", "abort")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.calibrator.call("abort")
        self.assertEqual(len(answers), 30)
        refusals = [a.message for _, a in answers if "under way" in a.message and not a.success]
        self.assertTrue(refusals)
        self.cell.behave("")
        until(lambda: self.calibrator.call("plan").success)
        self.assertTrue(self.calibrator.call("plan").success)
        self.check_still()

    def test_samples(self):
        answer = self.calibrator.call("add_sample")
        self.assertTrue(answer.success, answer.message)
        self.assertIn("taken; there are ", answer.message)
        answer = self.calibrator.call("finish")
        self.assertFalse(answer.success)
        self.assertTrue(answer.message.startswith("REFUSED: "), answer.message)

    # --- what is asked for, and what comes of it ---

    def test_request(self):
        self.begin("slow")
        target = self.cell.targets[-1]
        self.assertEqual(target.header.frame_id, "base")
        self.assertLess(abs((rospy.Time.now() - target.header.stamp).to_sec()), 5.0)
        self.assertTrue(until(lambda: self.cell.speeds[-1] == 0.2), self.cell.speeds)  # it comes after the target
        at, place = target.pose.position, self.start.translation
        self.assertLess(abs(at.x - place.x) + abs(at.y - place.y) + abs(at.z - place.z), 0.2)
        q = target.pose.orientation
        self.assertAlmostEqual(q.x ** 2 + q.y ** 2 + q.z ** 2 + q.w ** 2, 1.0, 6)
        self.assertTrue(self.calibrator.call("abort").success)

    def test_keys(self):
        self.keys.start()
        self.check_end("GOOD: ", "calibrate_keys/report.html", calibrator=self.keys, seconds=60.0)
        self.assertEqual(set(self.keys_cell.speeds), {0.5})
        self.assertEqual({t.header.frame_id for t in self.keys_cell.targets}, {"robot_base"})
        times = self.keys_cell.move_times
        # Before each picture but the first: a move, and settle.
        self.assertGreaterEqual(sum(after - before > 0.5 for before, after in zip(times, times[1:])), 6)
        folder = os.path.join(rospkg.get_ros_home(), "calibrate_keys")
        with open(folder + "/hand_eye.yaml") as f:
            hand_eye = yaml.safe_load(f)
        self.assertEqual((hand_eye["parent_frame"], hand_eye["child_frame"]), ("tool0", "eye"))
        with open(folder + "/camera_info.yaml") as f:
            info = yaml.safe_load(f)
        self.assertEqual(info["camera_name"], "palm")
        # fixed_camera: these are the numbers of camera_info, to the last digit
        self.assertEqual([info["camera_matrix"]["data"][i] for i in (0, 2, 4, 5)], [1100.0, 404.0, 1098.5, 316.0])
        with open(folder + "/calibration.yaml") as f:
            self.assertLessEqual(len(yaml.safe_load(f)["views"]), 8)
        self.assertTrue(os.path.getsize(folder + "/report.html") > 1000)


if __name__ == "__main__":
    rospy.init_node("calibrate_faults_tester")
    rostest.rosrun("planar_bin_picking", "calibrate_faults", CalibrateFaults, sys.argv)
