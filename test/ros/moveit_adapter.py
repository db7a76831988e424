#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""An adapter from MoveRobot to MoveIt: an example to copy and to change. It is outside of the build, since its messages
(moveit_msgs) are not in Debian; without MoveIt, replace MoveItArm by a class of its three methods.

    moveit_adapter.py [_group:=manipulator] [_flange_frame:=tool0]

rospy serves each connection in a thread of its own, so a stop is served beside a move that is under way. In roscpp it
takes a MultiThreadedSpinner or AsyncSpinner of two threads or more.
"""
import threading
import time

import rospy
from planar_bin_picking.srv import MoveRobot, MoveRobotResponse

STANDSTILL = 0.2  # s without motion, after which a robot stands
STANDSTILL_MAX = 2.5  # s, less than the calibrator's stop_timeout
STILL_M, STILL_RAD = 1e-4, 1e-3  # less than this is no motion
WHOLE = 0.999  # share of a straight line that is the whole of it
STOPPED = "stopped"


class Unreachable(Exception):
    """No way there; the robot has not moved."""


class MoveItArm:
    """What the adapter needs of a robot, by MoveIt's messages."""

    def __init__(self):
        # pylint: disable=import-error,import-outside-toplevel
        import actionlib
        import tf2_ros
        from moveit_msgs.msg import ExecuteTrajectoryAction, ExecuteTrajectoryGoal
        from moveit_msgs.srv import GetCartesianPath, GetCartesianPathRequest
        self.goal_type, self.request_type = ExecuteTrajectoryGoal, GetCartesianPathRequest
        self.group = rospy.get_param("~group", "manipulator")
        self.flange = rospy.get_param("~flange_frame", "tool0")
        self.plan = rospy.ServiceProxy("compute_cartesian_path", GetCartesianPath)
        self.client = actionlib.SimpleActionClient("execute_trajectory", ExecuteTrajectoryAction)
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)

    def follow(self, target, speed_scale, begin):
        """Goes straight to the target. The motion begins in begin(send), which says whether it may: planning takes its
        time, and a stop may have come meanwhile. @return  "" at its end, else why it broke off."""
        request = self.request_type(group_name=self.group, link_name=self.flange, waypoints=[target.pose],
                                    max_step=0.005, jump_threshold=0.0, avoid_collisions=True)
        request.header.frame_id = target.header.frame_id
        request.start_state.is_diff = True  # from where the robot stands
        answer = self.plan(request)
        if answer.fraction < WHOLE:
            raise Unreachable(f"only {answer.fraction:.0%} of the way can be gone")
        goal = self.goal_type(trajectory=slowed(answer.solution, speed_scale))
        if not begin(lambda: self.client.send_goal(goal)):
            return STOPPED
        self.client.wait_for_result()
        result = self.client.get_result()
        done = result is not None and result.error_code.val == result.error_code.SUCCESS
        return "" if done else "MoveIt broke the motion off: " + self.client.get_goal_status_text()

    def cancel(self):
        """Stops the robot; may return before it stands."""
        self.client.cancel_all_goals()

    def pose(self, frame):
        """Where the flange is, measured."""
        t = self.tf.lookup_transform(frame, self.flange, rospy.Time(), rospy.Duration(1.0)).transform
        return t.translation, t.rotation


def slowed(trajectory, scale):
    """The same way in more time."""
    for point in trajectory.joint_trajectory.points:
        point.time_from_start = rospy.Duration(point.time_from_start.to_sec() / scale)
        point.velocities = [v * scale for v in point.velocities]
        point.accelerations = [a * scale * scale for a in point.accelerations]
    return trajectory


class Adapter:
    """Serves move_robot. Moves one after the other; a stop at once."""

    def __init__(self, arm):
        self.arm = arm
        self.moving = threading.Lock()
        self.gate = threading.Lock()
        self.stops = 0
        self.service = rospy.Service("move_robot", MoveRobot, self.serve)
        rospy.on_shutdown(self.arm.cancel)  # who is ended stops its robot

    def serve(self, request):
        return self.move(request) if request.speed_scale > 0.0 else self.stop(request)

    def move(self, request):
        with self.gate:
            stops = self.stops

        def begin(send):
            with self.gate:  # a stop comes before this, and nothing is sent, or after it, and cancels
                if stops == self.stops:
                    send()
                return stops == self.stops

        with self.moving:
            try:
                if not begin(lambda: None):
                    return MoveRobotResponse(reachable=True, message=STOPPED)
                why = self.arm.follow(request.target, request.speed_scale, begin)
            except Unreachable as error:
                return MoveRobotResponse(message=str(error))
            if not self.stands(request.target.header.frame_id):
                why = why or "the robot does not come to a standstill"
            response = MoveRobotResponse(success=not why, reachable=True, message=why)
            response.reached.header.frame_id = request.target.header.frame_id
            response.reached.header.stamp = rospy.Time.now()
            response.reached.pose.position, response.reached.pose.orientation = \
                self.arm.pose(request.target.header.frame_id)
            return response

    def stop(self, request):
        with self.gate:
            self.stops += 1  # a move that waits to begin does not
        self.arm.cancel()
        stands = self.stands(request.target.header.frame_id, self.arm.cancel)
        return MoveRobotResponse(success=stands, message="" if stands else "the robot still moves")

    def stands(self, frame, meanwhile=lambda: None):
        """Waits until the flange has not moved for a moment."""
        end = time.monotonic() + STANDSTILL_MAX
        last, since = self.arm.pose(frame), time.monotonic()
        while time.monotonic() < end:
            time.sleep(0.02)
            meanwhile()  # a goal that was under way to the controller is cancelled, too
            now = self.arm.pose(frame)
            if not is_same(last, now):
                last, since = now, time.monotonic()
            elif time.monotonic() - since > STANDSTILL:
                return True
        return False


def is_same(one, other):
    (p, q), (r, s) = one, other
    apart = max(abs(p.x - r.x), abs(p.y - r.y), abs(p.z - r.z))
    turned = 1.0 - abs(q.x * s.x + q.y * s.y + q.z * s.z + q.w * s.w)  # half the angle squared, over two
    return apart < STILL_M and turned < STILL_RAD ** 2 / 8.0


if __name__ == "__main__":
    rospy.init_node("moveit_adapter")
    adapter = Adapter(MoveItArm())
    rospy.spin()
