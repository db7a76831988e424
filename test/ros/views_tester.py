#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""More than one look, through the services: RefinePart, NextView, a policy that demands a second view, and
two fixed cameras, on drawn plates whose place is known."""
import os
import sys
import time
import unittest

import numpy
import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import PoseStamped
from planar_bin_picking.msg import LocatedParts, PartLook, RefusedPart
from planar_bin_picking.srv import (LocatePart, LocatePartResponse, NextView, NextViewResponse, RefinePart,
                                    RefinePartResponse, ReportPick, ReportPickResponse)
from visualization_msgs.msg import MarkerArray

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
from bin_cases import BinCases, HOME, matrix
from drawn_cell import DrawnCell, rotation, shift

UP = 60.0  # s, for the nodes to come up
PLATES = [shift(0.05, 0.02, 0.0) @ rotation("x", 4), shift(-0.07, -0.04, 0.0) @ rotation("z", 70) @ rotation("y", 5)]


def orbit(degrees, axis="y", about=(0.0, 0.0, 0.0)):
    """The home camera carried about a point."""
    return shift(*about) @ rotation(axis, degrees) @ shift(*numpy.negative(about)) @ HOME


def place(located):
    return matrix(located.pose.pose)[:3, 3]


def off(located, plates=PLATES):
    """Metres to the nearest of the plates."""
    return min(numpy.linalg.norm(place(located) - T[:3, 3]) for T in plates)


def depth_sigma(pose):
    return numpy.sqrt(pose.covariance[14])


class Views(BinCases, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cell = DrawnCell(orbit(-30))
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)
        for name in ("locator", "demanding", "level", "two_cameras", "misled", "binned"):
            for service in ("locate_part", "refine_part", "next_view"):
                rospy.wait_for_service(f"{name}/{service}", UP)
        end = time.monotonic() + UP  # until each of them hears tf; this one listens, too
        while cls.cell.tf.pub_tf.get_num_connections() < 7 and time.monotonic() < end:
            time.sleep(0.02)

    def locate(self, locator="locator", status=LocatePartResponse.OK, plates=PLATES, **second):
        self.cell.show(HOME, plates, **second)
        answer = rospy.ServiceProxy(locator + "/locate_part", LocatePart)(part="plate")
        self.assertEqual(answer.status, status, answer.message)
        return answer

    def refine(self, stamp, child_frame, locator="locator", **fields):
        return rospy.ServiceProxy(locator + "/refine_part", RefinePart)(
            stamp=stamp, child_frame=child_frame, **fields)

    def next_view(self, part, locator="locator"):
        return rospy.ServiceProxy(locator + "/next_view", NextView)(stamp=part.header.stamp,
                                                                    child_frame=part.child_frame)

    def report(self, part, success, locator="locator"):
        return rospy.ServiceProxy(locator + "/report_pick", ReportPick)(
            stamp=part.header.stamp, child_frame=part.child_frame, success=success)

    def stands(self, frame, expected, seconds=3.0):
        end = time.monotonic() + seconds
        while self.buffer.can_transform("base", frame, rospy.Time(0)) != expected:
            if time.monotonic() > end:
                return not expected
            time.sleep(0.02)
        return expected

    def test_each_look_adds_up(self):
        part, other = self.locate().parts
        self.assertEqual(part.views, 1)
        for views in (2, 3):
            proposed = self.next_view(part)
            self.assertEqual(proposed.status, NextViewResponse.OK, proposed.message)
            self.assertEqual(proposed.camera.header.frame_id, "base")
            scene = rospy.wait_for_message("locator/scene", MarkerArray, UP).markers
            shown = [marker for marker in scene if marker.ns == "next_view"]
            self.assertEqual(shown[0].pose, proposed.camera.pose)
            self.cell.show(matrix(proposed.camera.pose), PLATES)
            answer = self.refine(part.header.stamp, part.child_frame)
            self.assertEqual(answer.status, RefinePartResponse.OK, answer.message)
            look, before, part = answer.looks[0], part, answer.parts[0]
            self.assertEqual(look.look, PartLook.CONFIRMED, look.text)
            self.assertEqual([look.child_frame, part.child_frame], [before.child_frame] * 2)
            self.assertLess(look.moved, 0.003)
            self.assertLess(look.moved_angle, 0.1)
            self.assertGreater(look.seen, 0.7)
            self.assertIn("views agree", look.text)
            self.assertEqual(look.located.views, views)
            self.assertEqual(part.views, views)
            self.assertGreater(part.header.stamp, before.header.stamp)
            self.assertLess(off(part), 0.0006)
            self.assertLess(depth_sigma(part.pose), 0.9 * depth_sigma(before.pose))
            # What was expected of the look, and what it gave.
            self.assertLess(abs(numpy.log(depth_sigma(proposed.expected) / depth_sigma(part.pose))), 0.7)
            self.assertEqual([t.stage for t in answer.times], ["wait", "convert", "look", "publish"])
        tf = self.buffer.lookup_transform("base", part.child_frame, part.header.stamp, rospy.Duration(3.0))
        self.assertLess(abs(tf.transform.translation.z - part.pose.pose.position.z), 1e-9)
        latest = rospy.wait_for_message("locator/located_parts", LocatedParts, 5.0)
        # The other part stays as it was.
        self.assertEqual([p.views for p in latest.parts], [3, 1])
        self.assertEqual(latest.parts[1].header.stamp, other.header.stamp)
        self.assertTrue(self.stands(other.child_frame, True))
        self.assertEqual(part.picks[0].name, "suction")

    def test_several_parts_in_one_look(self):
        first = self.locate()
        self.assertEqual(len(first.parts), 2)
        self.cell.show(orbit(30), PLATES)
        answer = self.refine(first.parts[0].header.stamp, "", count=5)
        self.assertEqual([p.views for p in answer.parts], [2, 2], answer.message)
        self.assertEqual([l.child_frame for l in answer.looks], [p.child_frame for p in first.parts])
        self.assertLess(max(off(p) for p in answer.parts), 0.0006)
        self.assertEqual(answer.refused, [])
        self.cell.show(orbit(30), PLATES)
        again = self.refine(first.parts[0].header.stamp, first.parts[1].child_frame, count=1)
        self.assertEqual(again.looks[0].child_frame, first.parts[1].child_frame)

    def test_a_wrong_depth_is_corrected(self):
        first = self.locate("misled")
        self.assertGreater(off(first.parts[0]), 0.005)
        self.cell.show(orbit(30), PLATES)
        answer = self.refine(first.parts[0].header.stamp, first.parts[0].child_frame, "misled")
        self.assertEqual(answer.looks[0].look, PartLook.CORRECTED, answer.message)
        self.assertGreater(answer.looks[0].moved, 0.005)
        self.assertLess(off(answer.parts[0]), 0.0008)
        self.assertEqual(self.next_view(answer.parts[0], "misled").status, NextViewResponse.NO_VIEW)
        # What it replaces is offered no more, and the next in rank is what it was before the look.
        self.assertEqual(self.report(first.parts[0], False, "misled").status, ReportPickResponse.UNKNOWN_PART)
        following = self.report(answer.parts[0], False, "misled")
        self.assertEqual(following.status, ReportPickResponse.NEXT, following.message)
        self.assertEqual(following.next, first.parts[1])

    def test_what_moved_or_went_is_not_offered(self):
        part = self.locate().parts[0]
        moved = [T @ shift(0.0, 0.003, 0.0) for T in PLATES]
        self.cell.show(orbit(30), moved)
        answer = self.refine(part.header.stamp, part.child_frame)
        self.assertEqual(answer.status, RefinePartResponse.NOT_OFFERED)
        self.assertEqual(answer.looks[0].look, PartLook.MOVED, answer.message)
        self.assertAlmostEqual(answer.looks[0].moved, 0.003, delta=0.0015)
        # One view alone says little of its depth, and enough of where it went.
        self.assertLess(off(answer.looks[0].located, moved), off(answer.looks[0].located))
        self.assertEqual(answer.looks[0].located.views, 1)
        self.assertEqual(answer.parts, [])
        self.assertFalse(self.stands(part.child_frame, False))
        first = part
        part, other = self.locate().parts
        # What was not borne out comes last, or a program would look at it for ever.
        self.assertLess(numpy.linalg.norm(place(other) - place(first)), 0.001)
        self.assertTrue(self.stands(part.child_frame, True))
        self.cell.show(orbit(30), [])
        answer = self.refine(part.header.stamp, part.child_frame)
        self.assertEqual(answer.status, RefinePartResponse.NOT_OFFERED)
        self.assertEqual(answer.looks[0].look, PartLook.CONTRADICTED, answer.message)
        self.assertFalse(self.stands(part.child_frame, False))
        # Nobody looked at the other one, which can still be picked.
        self.assertTrue(self.stands(other.child_frame, True))
        latest = rospy.wait_for_message("locator/located_parts", LocatedParts, 5.0)
        self.assertEqual([p.child_frame for p in latest.parts], [other.child_frame])
        self.assertEqual(self.report(part, True).status, ReportPickResponse.UNKNOWN_PART)
        self.assertEqual(self.report(other, True).status, ReportPickResponse.LOCATE)

    def test_what_is_not_seen_stays_as_it_was(self):
        part = self.locate().parts[0]
        self.cell.show(shift(0.4, 0.0, 0.0) @ HOME, PLATES)
        answer = self.refine(part.header.stamp, part.child_frame)
        self.assertEqual(answer.status, RefinePartResponse.NOT_OFFERED)
        self.assertEqual(answer.looks[0].look, PartLook.NOT_SEEN, answer.message)
        self.assertTrue(self.stands(part.child_frame, True))
        self.cell.show(orbit(30), PLATES)
        self.assertEqual(self.refine(part.header.stamp, part.child_frame).status, RefinePartResponse.OK)

    def test_why_nobody_looked(self):
        part = self.locate().parts[0]
        cases = [(RefinePartResponse.NO_IMAGE, {"silent": True}, {"timeout": rospy.Duration(0.3)}),
                 (RefinePartResponse.NO_TRANSFORM, {"frame_id": "nowhere"}, {}),
                 (RefinePartResponse.BAD_CAMERA_INFO, {"K": [0.0] * 9}, {}),
                 (RefinePartResponse.BAD_IMAGE, {"encoding": "none"}, {}),
                 (RefinePartResponse.BAD_REQUEST, {}, {"timeout": rospy.Duration(-1.0)})]
        for status, faults, fields in cases:
            self.cell.show(orbit(30), PLATES, **faults)
            answer = self.refine(part.header.stamp, part.child_frame, **fields)
            self.assertEqual(answer.status, status, answer.message)
            self.assertEqual((answer.parts, answer.looks), ([], []))
        self.cell.show(orbit(30), PLATES)
        late = self.refine(part.header.stamp, part.child_frame, timeout=rospy.Duration(0.3),
                           not_before=rospy.Time.now() + rospy.Duration(60))
        self.assertEqual(late.status, RefinePartResponse.NO_IMAGE, late.message)
        for stamp, frame in ((part.header.stamp, "plate_9"), (rospy.Time(1), part.child_frame)):
            answer = self.refine(stamp, frame)
            self.assertEqual(answer.status, RefinePartResponse.UNKNOWN_PART)
            self.assertIn("locate again", answer.message)
        part.child_frame = "plate_9"
        self.assertEqual(self.next_view(part).status, NextViewResponse.UNKNOWN_PART)
        self.assertEqual(self.next_view(part, "two_cameras").status, NextViewResponse.NOT_SET)

    def test_a_policy_that_demands_a_second_view(self):
        first = self.locate("demanding", LocatePartResponse.DEADLOCK)
        self.assertEqual({r.reason for r in first.refused}, {RefusedPart.NEEDS_VIEW})
        self.assertIn("depth", first.refused[0].text)
        self.assertIn("refine_part", first.message)
        refused = first.refused[0].located
        proposed = self.next_view(refused, "demanding")
        self.assertEqual(proposed.status, NextViewResponse.OK, proposed.message)
        z_home, z = HOME[:3, 2], matrix(proposed.camera.pose)[:3, 2]
        self.assertLess(numpy.degrees(numpy.arccos(z_home @ z)), 12.1)  # its own cone
        self.cell.show(orbit(8), PLATES)  # too little to be sure
        still = self.refine(refused.header.stamp, "", "demanding")
        self.assertEqual(still.status, RefinePartResponse.NOT_OFFERED, still.message)
        self.assertEqual([r.reason for r in still.refused], [RefusedPart.NEEDS_VIEW])
        self.cell.show(orbit(35), PLATES)
        answer = self.refine(still.refused[0].located.header.stamp, "", "demanding")
        self.assertEqual(answer.status, RefinePartResponse.OK, answer.message)
        self.assertEqual(answer.parts[0].views, 3)

    def test_a_policy_that_demands_a_sure_tilt(self):
        first = self.locate("level", LocatePartResponse.DEADLOCK)
        self.assertEqual({r.reason for r in first.refused}, {RefusedPart.NEEDS_VIEW})
        self.assertIn("tilt", first.refused[0].text)

    def test_two_fixed_cameras(self):
        answer = self.locate("two_cameras")
        self.assertEqual([p.views for p in answer.parts], [2, 2])
        self.assertLess(max(off(p) for p in answer.parts), 0.001)
        self.assertIn("second camera", [t.stage for t in answer.times])
        there = self.locate("two_cameras", plates_second=PLATES[:1])
        self.assertEqual([p.views for p in there.parts], [2])
        self.assertEqual([r.reason for r in there.refused], [RefusedPart.CONTRADICTED])


if __name__ == "__main__":
    rospy.init_node("views_tester")
    rostest.rosrun("planar_bin_picking", "views", Views, sys.argv)
