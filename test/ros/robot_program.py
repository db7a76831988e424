#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a robot program does with the locator, as short as it gets: copy it and go on from here.

    rosrun planar_bin_picking robot_program.py [_part:=bracket]
"""
import math
import sys

import rospy
from planar_bin_picking.msg import LocatedPart
from planar_bin_picking.srv import LocatePart, LocatePartRequest, LocatePartResponse

WAIT_FOR_NODE = 60.0  # s


def tilt_deg(pose):
    """Angle between the part's z and the z of the frame it is given in, whichever way is up."""
    q = pose.orientation
    return math.degrees(math.acos(min(1.0, abs(1.0 - 2.0 * (q.x ** 2 + q.y ** 2)))))


def print_table(response):
    print(f"{'':>4} {'frame':<16} {'face':<6}{'score':>6}{'visible':>9}"
          f"{'x':>9}{'y':>9}{'z':>9} mm{'tilt':>7} deg")
    for rank, part in enumerate(response.parts, start=1):
        p = part.pose.pose.position
        face = "front" if part.face == LocatedPart.FRONT else "back"
        print(f"{rank:>4} {part.child_frame:<16} {face:<6}{part.score:>6.2f}"
              f"{part.visible_fraction:>9.2f}{1e3 * p.x:>9.1f}{1e3 * p.y:>9.1f}{1e3 * p.z:>9.1f}"
              f"{tilt_deg(part.pose.pose):>10.1f}")
    print("time: " + ", ".join(f"{t.stage} {t.seconds:.3f} s" for t in response.times))


def main():
    rospy.init_node("robot_program")
    rospy.wait_for_service("locator/locate_part", WAIT_FOR_NODE)
    locate_part = rospy.ServiceProxy("locator/locate_part", LocatePart)

    # The robot stands still now: only an image taken from this moment on is good enough, which is
    # what a not_before of zero asks for.
    request = LocatePartRequest(part=rospy.get_param("~part", ""), face=LocatePartRequest.ANY)
    response = locate_part(request)

    for refused in response.refused:  # found, and not to be picked
        print(f"not offered: {refused.located.part}, {refused.text}", file=sys.stderr)
    if response.status != LocatePartResponse.OK:  # whatever it is: the message says what may help
        print(f"no part: {response.message}", file=sys.stderr)
        return 1
    print(f"{response.message}, poses in frame '{response.parts[0].header.frame_id}'")
    print_table(response)
    # Here the robot would go to the first pick pose of the first part, and say with report_pick what came
    # of it. A part whose file names no pick poses has none: then the program must know where to pick.
    first = response.parts[0]
    if first.picks:
        print(f"first pick: {first.child_frame}/{first.picks[0].name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
