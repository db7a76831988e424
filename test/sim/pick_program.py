#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The loop of a robot program: locate, go there, suck, report, next. Copy it and go on from here; what
your cell has in place of move_robot and gripper/suction goes into the class Robot.

    rosrun planar_bin_picking pick_program.py [_part:=bracket] [_cycles:=20] [_views:=2]

With views:=2 it looks at each part once more before it goes there, from where the locator proposes.
"""
import copy
import sys

import numpy
import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped
from planar_bin_picking.msg import PartLook
from planar_bin_picking.srv import (LocatePart, LocatePartResponse, MoveRobot, NextView,
                                    NextViewResponse, RefinePart, RefinePartResponse, ReportPick,
                                    ReportPickResponse)
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import Marker

WAIT = 60.0  # s, for the nodes to come up
ABOVE = 0.15  # m, over the part before and after the pick, along the tool's stroke
IMAGES = 3  # in a row without a part that could be picked: then the bin needs somebody
# With any other status the cell is not set up as it should be, and somebody has to mend it first.
MAY_HELP_TO_ASK_AGAIN = (LocatePartResponse.OK, LocatePartResponse.NO_PART_FOUND,
                         LocatePartResponse.EMPTY, LocatePartResponse.DEADLOCK, LocatePartResponse.NO_IMAGE,
                         LocatePartResponse.BAD_IMAGE, LocatePartResponse.NO_TRANSFORM)


def matrix(pose):
    """4 x 4, of a pose or a transform."""
    p = getattr(pose, "position", None) or pose.translation
    q = getattr(pose, "orientation", None) or pose.rotation
    x, y, z, w = q.x, q.y, q.z, q.w
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), p.x],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), p.y],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), p.z],
        [0.0, 0.0, 0.0, 1.0]])


def quaternion(R):
    """x, y, z, w: the axis of a rotation matrix is where it turns nothing."""
    K = numpy.array([
        [R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
        [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
        [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]]])
    return numpy.linalg.eigh(K / 3.0)[1][:, -1]


class Outcome:
    def __init__(self, success, message, reached):
        self.success = success
        self.message = message  # of the gripper
        self.reached = reached  # the tool got to the part


class Robot:
    """Moves the tool's tip; knows where the tool sits on the flange."""

    def __init__(self):
        for name in ("move_robot", "gripper/suction"):
            rospy.wait_for_service(name, WAIT)
        self.move_robot = rospy.ServiceProxy("move_robot", MoveRobot)
        self.suction = rospy.ServiceProxy("gripper/suction", SetBool)
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        self.T_flange_tool = self.lookup("flange", "tool")
        self.T_base_home = self.lookup("base", "flange")

    def lookup(self, target, source):
        return matrix(self.tf.lookup_transform(target, source, rospy.Time(0),
                                               rospy.Duration(WAIT)).transform)

    def move_flange(self, T_base_flange):
        target = PoseStamped()
        target.header.frame_id = "base"
        p, q = target.pose.position, target.pose.orientation
        p.x, p.y, p.z = T_base_flange[:3, 3]
        q.x, q.y, q.z, q.w = quaternion(T_base_flange[:3, :3])
        response = self.move_robot(target=target, speed_scale=1.0)
        if not response.success:
            raise RuntimeError("robot: " + response.message)

    def move_camera(self, T_base_camera):
        """Of a camera on the arm."""
        T_flange_camera = self.lookup("flange", "camera")
        self.move_flange(T_base_camera @ numpy.linalg.inv(T_flange_camera))

    def move_tool(self, T_base_tool):
        self.move_flange(T_base_tool @ numpy.linalg.inv(self.T_flange_tool))

    def pick(self, T_base_pick):
        """Down, suck, up, back home: what came of it."""
        T_base_above = T_base_pick.copy()
        T_base_above[:3, 3] -= ABOVE * T_base_pick[:3, 2]
        self.move_tool(T_base_above)
        self.move_tool(T_base_pick)
        response = self.suction(True)
        self.move_tool(T_base_above)
        self.move_flange(self.T_base_home)  # out of the camera's sight
        self.suction(False)  # a real program puts the part down before
        # Stopped by the wall, the tool has moved nothing; a real robot's planner says so beforehand.
        return Outcome(response.success, response.message, "touches" not in response.message)


class Locator:
    def __init__(self, part, views=1):
        self.part = part
        self.views = views  # pictures of a part before the robot goes to it
        for name in ("locator/locate_part", "locator/report_pick", "locator/refine_part",
                     "locator/next_view"):
            rospy.wait_for_service(name, WAIT)
        self.refine_part = rospy.ServiceProxy("locator/refine_part", RefinePart)
        self.next_view = rospy.ServiceProxy("locator/next_view", NextView)
        self.locate_part = rospy.ServiceProxy("locator/locate_part", LocatePart)
        self.report_pick = rospy.ServiceProxy("locator/report_pick", ReportPick)

    def locate(self):
        return self.locate_part(part=self.part, timeout=rospy.Duration(20.0))

    def look_again(self, robot, part):
        """The part as all views together have it; None where it is not there, or elsewhere now."""
        while part is not None and part.views < self.views:
            proposed = self.next_view(stamp=part.header.stamp, child_frame=part.child_frame)
            if proposed.status != NextViewResponse.OK:
                return part  # a robot that has to be sure would pass the part over
            robot.move_camera(matrix(proposed.camera.pose))
            answer = self.refine_part(stamp=part.header.stamp, child_frame=part.child_frame,
                                      timeout=rospy.Duration(20.0))
            if answer.status == RefinePartResponse.OK:
                part = answer.parts[0]
            elif answer.looks and answer.looks[0].look == PartLook.NOT_SEEN:
                return part
            else:
                part = None
        return part

    def report(self, part, success):
        """The next part to go to out of the same image, or None."""
        response = self.report_pick(stamp=part.header.stamp, child_frame=part.child_frame,
                                    success=success)
        return response.next if response.status == ReportPickResponse.NEXT else None


class Attempt:
    """One try at one part. Its pick poses that the tool cannot get to are passed over."""

    def __init__(self, robot, part):
        self.part = copy.deepcopy(part)
        self.pick = None
        self.outcome = Outcome(False, f"the file of {part.part} names no pick poses", False)
        for pick in part.picks:  # those that the bin's wall does not bar, in order of preference
            self.pick = pick
            self.outcome = robot.pick(matrix(pick.pose))
            if self.outcome.reached:
                break

    def success(self):
        return self.outcome.success


class Cycle:
    """What one cycle came to: one part picked, or none although up to IMAGES were looked at."""

    def __init__(self):
        self.attempts = []  # in order
        self.answers = []   # of LocatePart

    def picked(self):
        """The attempt that picked a part, or None."""
        return self.attempts[-1] if self.attempts and self.attempts[-1].success() else None


def run_cycle(robot, locator):
    cycle = Cycle()
    while cycle.picked() is None and len(cycle.answers) < IMAGES:
        answer = locator.locate()
        cycle.answers.append(answer)
        if answer.status not in MAY_HELP_TO_ASK_AGAIN:
            raise RuntimeError("locator: " + answer.message)
        part = answer.parts[0] if answer.parts else None
        while part is not None:
            part = locator.look_again(robot, part)
            if part is None:
                robot.move_flange(robot.T_base_home)  # and locate again
                break
            cycle.attempts.append(Attempt(robot, part))
            part = locator.report(part, cycle.attempts[-1].success())
    return cycle


class TallyDisplay:
    """The count so far as a text beside the bin, for rviz."""

    def __init__(self):
        self.publisher = rospy.Publisher("tally", Marker, queue_size=1, latch=True)

    def show(self, text):
        marker = Marker(type=Marker.TEXT_VIEW_FACING, text=text)
        marker.header.frame_id = "base"
        marker.pose.position.y, marker.pose.position.z = 0.22, 0.1
        marker.pose.orientation.w = 1.0
        marker.scale.z = 0.02  # height of a letter
        marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
        self.publisher.publish(marker)
        print(text.replace("\n", "; "), flush=True)


def main():
    rospy.init_node("pick_program")
    display = TallyDisplay()
    robot = Robot()
    locator = Locator(rospy.get_param("~part", "bracket"), rospy.get_param("~views", 1))
    refill = rospy.ServiceProxy("cell/refill", Trigger)  # in the demo, somebody brings a new bin
    cycles = rospy.get_param("~cycles", 0)  # 0 = for ever
    first = later = none = 0
    while not rospy.is_shutdown() and (cycles == 0 or first + later + none < cycles):
        cycle = run_cycle(robot, locator)
        if cycle.picked() is None:
            none += 1
            print(f"no part could be picked: {cycle.answers[-1].message}")
            print("new bin: " + refill().message)
        elif len(cycle.attempts) == 1:
            first += 1
        else:
            later += 1
        seconds = sum(t.seconds for t in cycle.answers[-1].times if t.stage != "wait")
        display.show(f"first match {first}, later match {later}, none {none}\n"
                     f"last locate {seconds:.2f} s")
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except rospy.ROSInterruptException:
        pass
    except RuntimeError as error:  # of the robot or of the locator; its message says what to do
        sys.exit(str(error))
