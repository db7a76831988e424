#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Two cells in one graph keep out of each other's way: topics, services, frames, reports, robot servers."""
import os
import signal
import sys
import threading
import time
import unittest
from xmlrpc.client import ServerProxy

import rosgraph
import rospy
import rostest
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from planar_bin_picking.msg import LocatedParts
from planar_bin_picking.srv import LocatePart, LocatePartResponse, ReportPick, ReportPickResponse

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "robot_clients"))
import robot_client

UP = 60.0  # s, for the nodes to come up; machines may be busy
LEFT, RIGHT = "/left/locator", "/right"
BASE = {LEFT: "left/base", RIGHT: "base"}
PREFIX = {LEFT: "left/locator/", RIGHT: "right/"}
PORT = {LEFT: 15721, RIGHT: 15722}


class TwoCells(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        for locator in BASE:
            rospy.wait_for_service(locator + "/locate_part", UP)

    def locate(self, locator):
        """As soon as tf, which a cell needs for its first answer, has come in."""
        end = time.monotonic() + UP
        while True:
            answer = rospy.ServiceProxy(locator + "/locate_part", LocatePart)(part="bracket", timeout=rospy.Duration(20.0))
            if answer.status != LocatePartResponse.NO_TRANSFORM or time.monotonic() > end:
                self.assertEqual(answer.status, LocatePartResponse.OK, answer.message)
                return answer

    def locate_in_both(self):
        """{locator: answer} of calls at the same time."""
        answers = {}
        callers = [threading.Thread(target=lambda name=name: answers.update({name: self.locate(name)})) for name in BASE]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join()
        self.assertEqual(set(answers), set(BASE))
        return answers

    def test_frames_and_topics_are_apart(self):
        answers = self.locate_in_both()
        for locator, answer in answers.items():
            first = answer.parts[0]
            self.assertEqual(first.header.frame_id, BASE[locator])
            self.assertEqual(first.child_frame, PREFIX[locator] + "bracket_1")
            # Both at the time of its own image, and still now.
            for stamp in (first.header.stamp, rospy.Time(0)):
                there = self.tf.lookup_transform(BASE[locator], first.child_frame, stamp, rospy.Duration(10.0)).transform
                self.assertAlmostEqual(there.translation.x, first.pose.pose.position.x, places=6)
            latest = rospy.wait_for_message(locator + "/located_parts", LocatedParts, UP)
            self.assertEqual([part.child_frame for part in latest.parts], [part.child_frame for part in answer.parts])
        # Each has the same picture before it: only their names can be wrong.
        self.assertEqual(len(answers[LEFT].parts), len(answers[RIGHT].parts))
        self.assertEqual([pick.name for pick in answers[RIGHT].parts[0].picks], [])  # of another folder of parts
        self.assertNotEqual([pick.name for pick in answers[LEFT].parts[0].picks], [])
        with self.assertRaises(tf2_ros.TransformException):
            self.tf.lookup_transform("base", "left/base", rospy.Time(0))
        published = {name: nodes for name, nodes in rosgraph.Master("/two_cells").getSystemState()[0]}
        for topic, nodes in published.items():
            if topic.startswith((LEFT + "/", RIGHT + "/")):
                self.assertEqual(len(nodes), 1, topic)

    def test_a_report_concerns_its_own_cell(self):
        answers = self.locate_in_both()
        part = answers[LEFT].parts[0]
        report = {name: rospy.ServiceProxy(name + "/report_pick", ReportPick) for name in BASE}
        strange = report[RIGHT](stamp=part.header.stamp, child_frame=part.child_frame, success=True)
        self.assertEqual(strange.status, ReportPickResponse.UNKNOWN_PART, strange.message)
        done = report[LEFT](stamp=part.header.stamp, child_frame=part.child_frame, success=True)
        self.assertEqual(done.status, ReportPickResponse.LOCATE, done.message)
        # A pick on the left has not changed the scene on the right.
        other = answers[RIGHT].parts[0]
        failed = report[RIGHT](stamp=other.header.stamp, child_frame=other.child_frame, success=False)
        self.assertEqual(failed.status, ReportPickResponse.NEXT, failed.message)
        self.assertTrue(failed.next.child_frame.startswith(PREFIX[RIGHT]))

    def test_each_has_its_diagnostics(self):
        seen = set()
        end = time.monotonic() + UP
        while not {"left/locator", "right"} <= seen:
            self.assertLess(time.monotonic(), end, seen)
            message = rospy.wait_for_message("/diagnostics", DiagnosticArray, UP)
            seen |= {status.name.split(":")[0] for status in message.status}

    def test_the_locator_comes_back_with_its_manager(self):
        before = rosgraph.Master("/two_cells").lookupNode("/right_manager")
        os.kill(ServerProxy(before).getPid("/two_cells")[2], signal.SIGKILL)
        end = time.monotonic() + UP
        while True:
            self.assertLess(time.monotonic(), end, "it does not come back")
            try:
                if rosgraph.Master("/two_cells").lookupNode("/right_manager") != before:
                    self.locate(RIGHT)
                    break
            except (rosgraph.MasterException, rospy.ServiceException):
                pass  # nobody is there yet
            time.sleep(0.2)
        self.locate(LEFT)  # which has not noticed

    def test_each_has_its_robot(self):
        self.locate_in_both()
        for locator, port in PORT.items():
            client = robot_client.RobotClient(port=port)
            code, answer = client.locate("bracket")
            client.close()
            # Only the left one's part file has a pick pose.
            expected = robot_client.POSE if locator == LEFT else robot_client.SET_UP
            self.assertEqual(code, expected, answer)


if __name__ == "__main__":
    rospy.init_node("two_cells_tester")
    rostest.rosrun("planar_bin_picking", "two_cells", TwoCells, sys.argv)
