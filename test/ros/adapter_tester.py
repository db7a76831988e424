#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The example adapter with an arm of this file in place of MoveIt: what it answers, and that a stop is served beside a
move."""
import sys
import threading
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import Point, Quaternion
from planar_bin_picking.srv import MoveRobot, MoveRobotRequest

import moveit_adapter


class Arm:
    """Goes 0.1 m/s along x."""

    def __init__(self):
        self.x, self.cancelled, self.obeys, self.fault = 0.0, False, True, ""
        self.frames, self.scales, self.plans_for = [], [], 0.0

    def follow(self, target, speed_scale, begin):
        self.frames.append(target.header.frame_id)
        self.scales.append(speed_scale)
        if target.pose.position.x > 1.0:
            raise moveit_adapter.Unreachable("only 10% of the way can be gone")
        time.sleep(self.plans_for)

        def send():
            self.cancelled = False
        if not begin(send):
            return moveit_adapter.STOPPED
        while self.x < target.pose.position.x:
            if self.fault or (self.cancelled and self.obeys):
                return self.fault or "cancelled"
            time.sleep(0.01)
            self.x += 0.001
        return ""

    def cancel(self):
        self.cancelled = True

    def pose(self, _):
        return Point(self.x, 0, 0), Quaternion(0, 0, 0, 1)


class AdapterTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.adapter = moveit_adapter.Adapter(Arm())

    def setUp(self):
        self.arm = self.adapter.arm = Arm()

    def call(self, x, speed_scale=0.5):
        request = MoveRobotRequest(speed_scale=speed_scale)
        request.target.header.frame_id = "base"
        request.target.pose.position.x = x
        request.target.pose.orientation.w = 1.0
        return rospy.ServiceProxy("move_robot", MoveRobot)(request)

    def begin(self, x):
        answers = []
        thread = threading.Thread(target=lambda: answers.append(self.call(x)))
        thread.start()
        return thread, answers

    def test_move(self):
        answer = self.call(0.05)
        self.assertTrue(answer.success and answer.reachable, answer.message)
        self.assertEqual(answer.reached.header.frame_id, "base")
        self.assertAlmostEqual(answer.reached.pose.position.x, 0.05, 2)
        self.assertEqual((self.arm.frames, self.arm.scales), (["base"], [0.5]))

    def test_unreachable(self):
        answer = self.call(2.0)
        self.assertEqual((answer.success, answer.reachable), (False, False))
        self.assertIn("10%", answer.message)

    def test_a_stop_while_it_plans(self):
        self.arm.plans_for = 0.6  # longer than a robot that stands needs to prove it
        thread, answers = self.begin(0.9)
        time.sleep(0.1)
        self.assertTrue(self.call(0.0, 0.0).success)
        thread.join(5.0)
        self.assertEqual((answers[0].success, answers[0].reachable, answers[0].message), (False, True, "stopped"))
        self.assertEqual(self.arm.x, 0.0)
        self.assertTrue(self.call(0.05).success)

    def test_broken_off(self):
        thread, answers = self.begin(0.9)
        time.sleep(0.3)
        self.arm.fault = "light curtain"
        thread.join()
        self.assertEqual((answers[0].success, answers[0].reachable, answers[0].message), (False, True, "light curtain"))

    def test_stop_beside_a_move(self):
        thread, answers = self.begin(0.9)
        time.sleep(0.3)
        start = time.monotonic()
        self.assertTrue(self.call(0.0, speed_scale=0.0).success)
        self.assertLess(time.monotonic() - start, 1.0)
        thread.join()
        self.assertEqual((answers[0].success, answers[0].reachable), (False, True))
        x = self.arm.x
        self.assertLess(x, 0.2)
        time.sleep(0.3)
        self.assertEqual(self.arm.x, x)
        self.assertTrue(self.call(x + 0.01).success)  # and goes on when asked to

    def test_stop_of_a_move_that_waits(self):
        first, _ = self.begin(0.9)
        time.sleep(0.2)
        second, answers = self.begin(0.95)
        time.sleep(0.2)
        self.assertTrue(self.call(0.0, speed_scale=0.0).success)
        first.join()
        second.join()
        self.assertEqual((answers[0].success, answers[0].reachable, answers[0].message), (False, True, "stopped"))
        self.assertEqual(len(self.arm.frames), 1)

    def test_arm_that_does_not_stop(self):
        self.arm.obeys = False
        thread, _ = self.begin(0.6)
        time.sleep(0.2)
        answer = self.call(0.0, speed_scale=0.0)
        self.assertFalse(answer.success)
        self.assertIn("still moves", answer.message)
        thread.join()


if __name__ == "__main__":
    rospy.init_node("adapter_tester")
    rostest.rosrun("planar_bin_picking", "adapter", AdapterTest, sys.argv)
