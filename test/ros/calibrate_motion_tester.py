#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Calibrators in the cell of calibrate_motion.test: what they ask the robot for, how far, and when."""
import math
import sys
import time

import rospy
import rostest

from calibration_fixture import Calibrator, InCell, until


def step_between(a, b):
    """Metres and degrees between two poses."""
    p, q = a.position, b.position
    metres = math.dist((p.x, p.y, p.z), (q.x, q.y, q.z))
    r, s = a.orientation, b.orientation
    cosine = abs(r.x * s.x + r.y * s.y + r.z * s.z + r.w * s.w)
    return metres, math.degrees(2 * math.acos(min(1.0, cosine)))


class CalibrateMotion(InCell):
    def await_question(self, calibrator):
        self.assertTrue(until(lambda: calibrator.said and calibrator.said[-1].startswith(("waiting", "FAILED"))),
                        calibrator.said[-1:])
        self.assertIn("waiting: ", calibrator.said[-1])
        self.assertIn("call ~next to go, or ~abort", calibrator.said[-1])

    def next(self, calibrator):
        calibrator.said.clear()
        answer = calibrator.call("next")
        self.assertEqual((answer.success, answer.message), (True, "the robot goes"))

    def test_whole_run(self):
        """Small steps; the first large move is asked for; a return that fails costs nothing."""
        asking = Calibrator("/asking")
        answer = asking.call("next")
        self.assertEqual((answer.success, answer.message), (False, "no move waits for ~next"))
        first = len(self.cell.targets)
        self.begin("no_return", asking)
        self.await_question(asking)
        small = len(self.cell.targets)
        self.assertGreater(small, first + 3)
        time.sleep(1.0)
        self.assertEqual(len(self.cell.targets), small)
        plan = asking.call("plan")
        self.assertTrue(plan.success, plan.message)
        self.assertIn(", 1 planned; the next way leads to [", plan.message)
        self.next(asking)
        end = self.check_end("the robot did not return to the start: ", "light curtain", calibrator=asking, seconds=90.0)
        self.assertTrue(end.startswith(("GOOD", "POOR")), end)
        poses = [t.pose for t in self.cell.targets[first:]]
        steps = [step_between(a, b) for a, b in zip(poses, poses[1:])]
        self.assertLessEqual(max(metres for metres, _ in steps), 0.08 + 1e-6)
        self.assertLessEqual(max(degrees for _, degrees in steps), 10.0 + 1e-3)
        self.assertGreater(len(poses), 9 + 3)  # there are poses in between
        self.assertGreater(max(step_between(poses[0], p)[1] for p in poses), 12.0)  # and large moves

    def test_step_by_step(self):
        stepping = Calibrator("/stepping")
        asked = len(self.cell.targets)
        stepping.start()
        for i in range(3):
            self.await_question(stepping)
            time.sleep(0.3)
            self.assertEqual(len(self.cell.targets), asked + i)
            self.next(stepping)
            self.assertTrue(until(lambda: len(self.cell.targets) == asked + i + 1))
        self.await_question(stepping)
        start = time.monotonic()
        answer = stepping.call("abort")
        self.assertTrue(answer.success, answer.message)
        self.check_end("ABORTED", calibrator=stepping)
        self.assertLess(time.monotonic() - start, 1.0)
        self.assertFalse(stepping.call("next").success)
        self.check_still()

    def test_refusals(self):
        """Slower from one to the next, and only so many."""
        asked = len(self.cell.targets)
        self.cell.target_times.clear()
        self.begin("refuses")
        self.check_end("REFUSED: ", "the robot refused refusals_max poses one after the other")
        self.assertEqual(len(self.cell.targets), asked + 4)
        times = self.cell.target_times
        pauses = [b - a for a, b in zip(times, times[1:])]
        for pause, least in zip(pauses, (0.5, 1.0, 1.5)):
            self.assertGreater(pause, least - 0.05)
            self.assertLess(pause, least + 0.8)

    def test_plan(self):
        """The first poses, the next one and the way to it, and nothing moves."""
        asked = len(self.cell.targets)
        answer = self.calibrator.call("plan")
        self.assertTrue(answer.success, answer.message)
        self.assertRegex(answer.message, r"^on ~plan_markers are the first 6 poses: .*; the next way leads to \[.* m: "
                                         r".* deg in 1 move; later ones follow from what is seen$")
        self.assertEqual(len(self.cell.targets), asked)

    def test_limits_at_the_start(self):
        for name, words in (("/narrow", "lies outside the workspace"), ("/walled", "lies beyond plane 1")):
            answer = Calibrator(name).call("plan")
            self.assertFalse(answer.success)
            self.assertIn("the robot must not start here", answer.message)
            self.assertIn(words, answer.message)


if __name__ == "__main__":
    rospy.init_node("calibrate_motion_tester")
    rostest.rosrun("planar_bin_picking", "calibrate_motion", CalibrateMotion, sys.argv)
