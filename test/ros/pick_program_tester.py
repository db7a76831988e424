#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The example robot program goes on, or ends, as it says, whatever robot, gripper and locator do."""
import os
import sys
import unittest

import rospy
import rostest
import tf2_ros
from geometry_msgs.msg import TransformStamped
from planar_bin_picking.msg import LocatedPart, LocatedPick
from planar_bin_picking.srv import (LocatePart, LocatePartResponse, MoveRobot, MoveRobotResponse, ReportPick,
                                    ReportPickResponse)
from std_srvs.srv import SetBool, SetBoolResponse, Trigger, TriggerResponse

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../sim"))
import pick_program
from pick_program import Result

Status = LocatePartResponse
TOOL = 0.12  # m, in front of the flange


def located(name, *places):
    """A part that leans: each of its pick poses is turned by half a right angle about x, z down."""
    part = LocatedPart(part="plate", child_frame=name, views=1)
    part.header.stamp = rospy.Time(1)
    for i, x in enumerate(places):
        pick = LocatedPick(name=f"pick{i}")
        pick.pose.position.x, pick.pose.position.z = x, 0.1
        pick.pose.orientation.x, pick.pose.orientation.w = 0.9238795, 0.3826834  # 135 degrees about x
        part.picks.append(pick)
    return part


class FakeCell:
    """Does as it is told by the lists of what comes next; the last entry stays."""

    def __init__(self):
        self.well()
        self.broadcaster = tf2_ros.StaticTransformBroadcaster()
        self.broadcaster.sendTransform([self.transform("base", "flange", 1.0), self.transform("flange", "tool", TOOL)])
        self.services = [
            rospy.Service("move_robot", MoveRobot, self.move), rospy.Service("gripper/suction", SetBool, self.suck),
            rospy.Service("gripper/holds", Trigger, lambda _: TriggerResponse(success=self.next(self.holds))),
            rospy.Service("locator/locate_part", LocatePart, self.locate),
            rospy.Service("locator/report_pick", ReportPick, self.report)]

    def well(self):
        self.answers = [(Status.OK, [located("plate_1", 0.3), located("plate_2", 0.5)])]
        self.unreachable = []  # x of flange poses, m
        self.breaks_off = False
        self.vacuum, self.holds = [True], [True]
        self.moves, self.reports, self.suctions = [], [], []
        self.offered = []

    @staticmethod
    def next(values):
        return values.pop(0) if len(values) > 1 else values[0]

    @staticmethod
    def transform(parent, child, z):
        message = TransformStamped(child_frame_id=child)
        message.header.frame_id = parent
        message.transform.translation.z, message.transform.rotation.w = z, 1.0
        return message

    def move(self, request):
        p = request.target.pose.position
        if any(abs(p.x - x) < 1e-6 for x in self.unreachable):
            return MoveRobotResponse(message="no way there")
        if self.breaks_off:
            return MoveRobotResponse(reachable=True, message="protective stop")
        self.moves.append((p.x, p.y, p.z))
        return MoveRobotResponse(success=True, reachable=True)

    def suck(self, request):
        self.suctions.append(request.data)
        return SetBoolResponse(success=self.next(self.vacuum) if request.data else True)

    def locate(self, _):
        answer = self.next(self.answers)
        if answer is None:
            raise RuntimeError("the locator has died")
        status, parts = answer
        self.offered = list(parts)
        return LocatePartResponse(status=status, message=f"status {status}", parts=parts)

    def report(self, request):
        self.reports.append((request.child_frame, request.success))
        self.offered = [part for part in self.offered if part.child_frame != request.child_frame]
        if request.success or not self.offered:
            return ReportPickResponse(status=ReportPickResponse.LOCATE)
        return ReportPickResponse(status=ReportPickResponse.NEXT, next=self.offered[0])


class PickProgram(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        pick_program.PAUSE = 0.05
        cls.cell = FakeCell()
        cls.robot = pick_program.Robot()
        cls.locator = pick_program.Locator("plate")

    def setUp(self):
        self.cell.well()

    def cycle(self, *results):
        """One cycle with these results of its attempts, in order."""
        cycle = pick_program.run_cycle(self.robot, self.locator)
        self.assertEqual([attempt.outcome.result for attempt in cycle.attempts], list(results))
        if cycle.attempts:
            self.assertEqual(self.cell.suctions[-1:], [False] if True in self.cell.suctions else [])
        return cycle

    def test_goes_along_the_tool_and_leaves_straight_up(self):
        self.cycle(Result.PICKED)
        before, pick, after, home = self.cell.moves
        lean = 0.5 ** 0.5  # the tool leans by 45 degrees; the flange stands behind its tip
        held, ahead = TOOL + pick_program.SEEK, pick_program.ABOVE - pick_program.SEEK
        self.assertAlmostEqual(abs(pick[1]), held * lean, places=5)
        self.assertAlmostEqual(pick[2], 0.1 + held * lean, places=5)
        self.assertAlmostEqual(before[2] - pick[2], ahead * lean, places=5)
        self.assertAlmostEqual(abs(before[1] - pick[1]), ahead * lean, places=5)
        for got, expected in zip(after, (pick[0], pick[1], pick[2] + pick_program.ABOVE)):
            self.assertAlmostEqual(got, expected, places=5)
        self.assertAlmostEqual(home[2], 1.0)
        self.assertEqual(self.cell.reports, [("plate_1", True)])

    def test_seeks_the_part_along_the_tool(self):
        self.cell.vacuum = [False, False, True]
        self.cycle(Result.PICKED)
        _, *tried, after, _ = self.cell.moves
        lean = 0.5 ** 0.5
        for flange, ahead in zip(tried, (pick_program.SEEK, 0.0, -pick_program.SEEK)):
            self.assertAlmostEqual(abs(flange[1]), (TOOL + ahead) * lean, places=5)
            self.assertAlmostEqual(flange[2], 0.1 + (TOOL + ahead) * lean, places=5)
        self.assertEqual(len(tried), 3)
        self.assertAlmostEqual(after[2] - tried[-1][2], pick_program.ABOVE, places=5)
        self.assertEqual(self.cell.reports, [("plate_1", True)])

    def test_passes_over_what_it_cannot_reach(self):
        self.cell.answers = [(Status.OK, [located("plate_1", 0.3, 0.4), located("plate_2", 0.5)])]
        self.cell.unreachable = [0.3]
        self.assertEqual(self.cycle(Result.PICKED).picked().pick.name, "pick1")
        self.cell.well()
        self.cell.unreachable = [0.3]
        self.cycle(Result.NOT_REACHED, Result.PICKED)
        self.assertEqual(self.cell.reports, [("plate_1", False), ("plate_2", True)])
        self.cell.well()
        self.cell.unreachable = [0.3, 0.5]
        self.assertIsNone(self.cycle(*[Result.NOT_REACHED] * 2 * pick_program.IMAGES).picked())
        self.assertEqual(self.cell.suctions, [])

    def test_goes_on_where_nothing_is_held_or_a_part_is_lost(self):
        self.cell.vacuum = [False, False, False, True]
        self.cycle(Result.NOTHING_HELD, Result.PICKED)
        self.assertEqual(self.cell.reports, [("plate_1", False), ("plate_2", True)])
        self.cell.well()
        self.cell.holds = [False, True]
        self.cycle(Result.LOST, Result.PICKED)
        # What was lost has left its place: both are picked out of an image of their own.
        self.assertEqual(self.cell.reports, [("plate_1", True), ("plate_1", True)])

    def test_passes_over_parts_without_pick_poses(self):
        self.cell.answers = [(Status.OK, [located("plate_1"), located("plate_2", 0.5)])]
        cycle = self.cycle(Result.NOT_REACHED, Result.PICKED)
        self.assertIn("names no pick poses", cycle.attempts[0].outcome.message)

    def test_asks_again_while_there_is_no_image_or_no_locator(self):
        good = self.cell.answers[0]
        self.cell.answers = [(Status.NO_IMAGE, []), (Status.NO_TRANSFORM, []), good]
        self.cycle(Result.PICKED)
        self.cell.answers = [None, good]
        self.cycle(Result.PICKED)
        self.cell.answers = [None]
        with self.assertRaisesRegex(RuntimeError, "locate_part does not answer"):
            self.cycle()

    def test_ends_the_cycle_where_nothing_can_be_picked(self):
        self.cell.answers = [(Status.EMPTY, [])]
        self.assertEqual(len(self.cycle().answers), 1)
        self.cell.answers = [(Status.NO_PART_FOUND, [])]
        self.assertEqual(len(self.cycle().answers), pick_program.IMAGES)

    def test_ends_where_somebody_has_to_look(self):
        self.cell.answers = [(Status.BAD_CAMERA_INFO, [])]
        with self.assertRaisesRegex(RuntimeError, f"locator: status {Status.BAD_CAMERA_INFO}"):
            self.cycle()
        self.cell.well()
        self.cell.breaks_off = True
        with self.assertRaisesRegex(RuntimeError, "robot: protective stop"):
            self.cycle()


if __name__ == "__main__":
    rospy.init_node("pick_program_tester")
    rostest.rosrun("planar_bin_picking", "pick_program", PickProgram, sys.argv)
