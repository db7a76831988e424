#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The loop of a robot program: locate, go there, suck, go up, report, next. Copy it and go on from here; what your cell
has in place of move_robot and the gripper's services goes into the class Robot.

    rosrun planar_bin_picking pick_program.py [_part:=bracket] [_cycles:=20] [_views:=2]

It goes on where the robot cannot get to a pose, where the gripper gets hold of nothing or loses the part on the way, where
a part's file names no pick poses, and while there is no image, no transform or no locator for a moment. It ends where the
robot breaks a motion off, and where something has to be mended first; what it prints then says what.

With views:=2 it looks at each part once more before it goes there, from where the locator proposes.
"""
import copy
import enum
import sys

import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped
from planar_bin_picking.msg import PartLook
from planar_bin_picking.srv import (LocatePart, LocatePartResponse, MoveRobot, NextView,
                                    NextViewResponse, RefinePart, RefinePartResponse, ReportPick,
                                    ReportPickResponse)
from PyKDL import Frame, Vector
from std_srvs.srv import SetBool, Trigger
from tf_conversions import posemath
from visualization_msgs.msg import Marker

WAIT = 60.0  # s, for nodes to come up, and again after one has died
ABOVE = 0.15  # m, over the part before and after the pick
SEEK = 0.004  # m before the part, from where the cup goes on until it holds: less than its bellows take up
IMAGES = 3  # in a row without a part that could be picked: then the bin needs somebody
PAUSE = 1.0  # s, before asking again where it is a matter of time
PICTURE_TIMEOUT = 20.0  # s, for an image to come
# With any other status the cell is not set up as it should be, and somebody has to mend it first.
MAY_HELP_TO_ASK_AGAIN = (LocatePartResponse.OK, LocatePartResponse.NO_PART_FOUND,
                         LocatePartResponse.EMPTY, LocatePartResponse.DEADLOCK, LocatePartResponse.NO_IMAGE,
                         LocatePartResponse.BAD_IMAGE, LocatePartResponse.NO_TRANSFORM)
IS_A_MATTER_OF_TIME = (LocatePartResponse.NO_IMAGE, LocatePartResponse.BAD_IMAGE, LocatePartResponse.NO_TRANSFORM)


def frame(pose):
    """Of a pose's or a transform's message."""
    if hasattr(pose, "translation"):
        t, q = pose.translation, pose.rotation
        return posemath.fromTf(((t.x, t.y, t.z), (q.x, q.y, q.z, q.w)))
    return posemath.fromMsg(pose)


def matrix(pose):
    """4 x 4."""
    return posemath.toMatrix(frame(pose))


class Unreachable(Exception):
    """The robot cannot get there, and has not moved; another pose may do."""


class Result(enum.Enum):
    PICKED = 1
    NOTHING_HELD = 2  # the gripper has no vacuum
    LOST = 3  # it had the part, and lost it on the way
    NOT_REACHED = 4  # the robot could not get to any pick pose


class Outcome:
    def __init__(self, result, message=""):
        self.result, self.message = result, message
        self.success = result == Result.PICKED


class Robot:
    """Moves the tool's tip; knows where the tool sits on the flange."""

    def __init__(self):
        for name in ("move_robot", "gripper/suction"):
            rospy.wait_for_service(name, WAIT)
        self.move_robot = rospy.ServiceProxy("move_robot", MoveRobot)
        self.suction = rospy.ServiceProxy("gripper/suction", SetBool)  # success: the vacuum holds
        self.holds = rospy.ServiceProxy("gripper/holds", Trigger)  # success: it still does
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        self.T_flange_tool = self.lookup("flange", "tool")
        self.T_base_home = self.lookup("base", "flange")

    def lookup(self, target, source):
        return frame(self.tf.lookup_transform(target, source, rospy.Time(0), rospy.Duration(WAIT)).transform)

    def move_flange(self, T_base_flange):
        target = PoseStamped(pose=posemath.toMsg(T_base_flange))
        target.header.frame_id = "base"
        response = self.move_robot(target=target, speed_scale=1.0)
        if response.success:
            return
        if not response.reachable:
            raise Unreachable(response.message)
        raise RuntimeError("robot: " + response.message)  # it broke off: somebody has to look

    def move_camera(self, T_base_camera):
        """Of a camera on the arm."""
        self.move_flange(T_base_camera * self.lookup("flange", "camera").Inverse())

    def move_tool(self, T_base_tool):
        self.move_flange(T_base_tool * self.T_flange_tool.Inverse())

    def go_home(self):
        """Out of the camera's sight."""
        self.move_flange(self.T_base_home)

    def pick(self, T_base_pick):
        """There, suck, up, back home: what came of it."""
        # There along the tool's axis, so that it meets the part squarely ...
        T_base_before = Frame(T_base_pick)
        T_base_before.p -= T_base_pick.M.UnitZ() * ABOVE
        T_base_pick = Frame(T_base_pick)
        T_base_pick.p -= T_base_pick.M.UnitZ() * SEEK
        try:
            self.move_tool(T_base_before)
            self.move_tool(T_base_pick)
        except Unreachable as error:
            self.go_home()
            return Outcome(Result.NOT_REACHED, str(error))
        held = self.suction(True)
        for _ in range(2):  # depth is what one picture tells worst: there and a little beyond
            if held.success:
                break
            T_base_deeper = Frame(T_base_pick)
            T_base_deeper.p += T_base_pick.M.UnitZ() * SEEK
            try:
                self.move_tool(T_base_deeper)
            except Unreachable:
                break  # the bin's floor or wall: no part is there
            T_base_pick = T_base_deeper
            held = self.suction(True)
        # ... and away straight up, whichever way the part leans: so it comes free of what lies about it.
        T_base_after = Frame(T_base_pick)
        T_base_after.p += Vector(0.0, 0.0, ABOVE)
        try:
            self.move_tool(T_base_after)
        except Unreachable:
            self.move_tool(T_base_before)
        self.go_home()
        still_held = held.success and self.holds().success
        self.suction(False)  # a real program puts the part down before
        if not held.success:
            return Outcome(Result.NOTHING_HELD, held.message)
        return Outcome(Result.PICKED) if still_held else Outcome(Result.LOST, "the part was lost on the way")


class Locator:
    def __init__(self, part, views=1):
        self.part = part
        self.views = views  # pictures of a part before the robot goes to it
        self.types = {"locate_part": LocatePart, "report_pick": ReportPick, "refine_part": RefinePart,
                      "next_view": NextView}

    def call(self, name, **request):
        """The answer, also of a locator that is started again meanwhile."""
        service = "locator/" + name
        for last_try in (False, True):
            try:
                rospy.wait_for_service(service, WAIT)
                return rospy.ServiceProxy(service, self.types[name])(**request)
            except (rospy.ServiceException, rospy.ROSException) as error:
                if last_try or rospy.is_shutdown():
                    raise RuntimeError(f"locator: {service} does not answer: {error}")
                rospy.logwarn("%s: %s; asking again", service, error)
                rospy.sleep(PAUSE)

    def locate(self):
        return self.call("locate_part", part=self.part, timeout=rospy.Duration(PICTURE_TIMEOUT))

    def look_again(self, robot, part):
        """The part as all views together have it; None where it is not there, or elsewhere now."""
        while part is not None and part.views < self.views:
            proposed = self.call("next_view", stamp=part.header.stamp, child_frame=part.child_frame)
            if proposed.status != NextViewResponse.OK:
                return part  # a robot that has to be sure would pass the part over
            try:
                robot.move_camera(frame(proposed.camera.pose))
            except Unreachable:
                return part
            answer = self.call("refine_part", stamp=part.header.stamp, child_frame=part.child_frame,
                               timeout=rospy.Duration(PICTURE_TIMEOUT))
            if answer.status == RefinePartResponse.OK:
                part = answer.parts[0]
            elif answer.looks and answer.looks[0].look == PartLook.NOT_SEEN:
                return part
            else:
                rospy.logwarn("refine_part: %s", answer.message)
                part = None
        return part

    def report(self, part, success):
        """The next part to go to out of the same image, or None."""
        response = self.call("report_pick", stamp=part.header.stamp, child_frame=part.child_frame, success=success)
        return response.next if response.status == ReportPickResponse.NEXT else None


class Attempt:
    """One try at one part. Its pick poses that the robot cannot get to are passed over."""

    def __init__(self, robot, part):
        self.part = copy.deepcopy(part)
        self.pick = None
        self.outcome = Outcome(Result.NOT_REACHED, f"the file of {part.part} names no pick poses")
        for pick in part.picks:  # those that the bin's wall does not bar, in order of preference
            self.pick = pick
            self.outcome = robot.pick(frame(pick.pose))
            if self.outcome.result != Result.NOT_REACHED:
                break

    def success(self):
        return self.outcome.success

    def has_left_its_place(self):
        """What the locator is told: where the part was, it is no longer."""
        return self.outcome.result in (Result.PICKED, Result.LOST)


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
        if answer.status == LocatePartResponse.EMPTY:
            break  # looking again brings no parts
        if answer.status in IS_A_MATTER_OF_TIME:
            rospy.logwarn("locator: %s", answer.message)
            rospy.sleep(PAUSE)
        part = answer.parts[0] if answer.parts else None
        while part is not None:
            part = locator.look_again(robot, part)
            if part is None:
                robot.go_home()  # and locate again
                break
            attempt = Attempt(robot, part)
            cycle.attempts.append(attempt)
            if not attempt.success():
                rospy.logwarn("%s: %s, %s", part.child_frame, attempt.outcome.result.name, attempt.outcome.message)
            part = locator.report(part, attempt.has_left_its_place())
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
    # Who brings a new bin when nothing can be picked any more (std_srvs/Trigger); empty: a person, who needs time.
    new_bin = rospy.get_param("~new_bin_service", "")
    cycles = rospy.get_param("~cycles", 0)  # 0 = for ever
    first = later = none = 0
    while not rospy.is_shutdown() and (cycles == 0 or first + later + none < cycles):
        cycle = run_cycle(robot, locator)
        if cycle.picked() is None:
            none += 1
            print(f"no part could be picked: {cycle.answers[-1].message}")
            if new_bin:
                print("new bin: " + rospy.ServiceProxy(new_bin, Trigger)().message)
            else:
                rospy.sleep(PAUSE)
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
    except (RuntimeError, Unreachable) as error:  # of the robot or of the locator; its message says what to do
        sys.exit(str(error))
