#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Runs pick cycles as pick_program.py does, holds them against the truth that the simulated cell
publishes, and writes what came of them.

    cycle_statistics.py --cycles 100 [--refill-below 8] [--output result.yaml]

A cycle is one part picked, or a deadlock: nothing could be picked out of three images in a row. The bin is
filled anew after a deadlock, and once fewer parts are left in it than --refill-below (0: it is emptied
as far as it goes; what is left then is counted).
"""
import argparse
import collections
import math
import os
import statistics
import sys

import numpy
import rospy
import yaml

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
import pick_program
from pick_program import matrix
from planar_bin_picking.msg import LocatedParts
from std_srvs.srv import Trigger


class Truth:
    """What lay where at each picture's stamp."""

    def __init__(self):
        self.by_stamp = collections.OrderedDict()
        self.latest = None
        self.subscriber = rospy.Subscriber("truth", LocatedParts, self.receive)

    def receive(self, message):
        self.latest = message
        self.by_stamp[message.header.stamp] = message
        while len(self.by_stamp) > 50:
            self.by_stamp.popitem(last=False)

    def at(self, stamp):
        deadline = rospy.get_time() + 10.0
        while stamp not in self.by_stamp:
            if rospy.get_time() > deadline:
                raise RuntimeError("no truth for the picture's stamp")
            rospy.sleep(0.005)
        return self.by_stamp[stamp]

    def error(self, located):
        """x, y, z in mm, yaw and tilt in degrees, of the pick pose; to the nearest true part."""
        T_part_pick = numpy.linalg.inv(matrix(located.pose.pose)) @ matrix(located.picks[0].pose)
        T = matrix(located.picks[0].pose)
        best = None
        for part in self.at(located.header.stamp).parts:
            if part.part != located.part:
                continue
            for twin in part.picks:
                T_true = matrix(twin.pose) @ T_part_pick
                d = 1e3 * (T[:3, 3] - T_true[:3, 3])
                R = T_true[:3, :3].T @ T[:3, :3]
                yaw = math.degrees(math.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))
                tilt = math.degrees(math.acos(max(-1.0, min(1.0, R[2, 2]))))
                size = numpy.linalg.norm(d) + abs(yaw) + tilt
                if best is None or size < best[0]:
                    best = size, dict(x=abs(d[0]), y=abs(d[1]), z=abs(d[2]), yaw=abs(yaw), tilt=tilt)
        return best[1]


class Tally:
    def __init__(self):
        self.first = self.later = self.deadlock = 0
        self.errors, self.seconds, self.left, self.failures = [], [], [], collections.Counter()

    def add(self, cycle, truth):
        self.seconds += [sum(t.seconds for t in answer.times if t.stage != "wait")
                         for answer in cycle.answers]
        # Only the first: after a failure parts may have moved, and what stood in the image is stale.
        for part, success, message in cycle.attempts[:1]:
            if success:
                continue
            error = truth.error(part)
            is_wrong = max(error["x"], error["y"]) > 1.5 or error["z"] > 5.0 or error["tilt"] > 5.0
            self.failures[message + (", pose wrong" if is_wrong else ", pose right")] += 1
        if cycle.picked() is None:
            self.deadlock += 1
            self.left.append(len(truth.latest.parts))
        else:
            self.errors.append(truth.error(cycle.picked()))
            if len(cycle.attempts) == 1:
                self.first += 1
            else:
                self.later += 1

    def result(self):
        largest = {key: round(float(max(e[key] for e in self.errors)), 3)
                   for key in ("x", "y", "z", "yaw", "tilt")} if self.errors else None
        return dict(cycles=self.first + self.later + self.deadlock, first=self.first,
                    later=self.later, deadlock=self.deadlock, largest_error=largest,
                    seconds_median=round(statistics.median(self.seconds), 3),
                    seconds_max=round(max(self.seconds), 3), left=self.left,
                    failures=dict(self.failures))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=100)
    parser.add_argument("--refill-below", type=int, default=8)
    parser.add_argument("--output")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("cycle_statistics")
    truth = Truth()
    robot = pick_program.Robot()
    locator = pick_program.Locator(rospy.get_param("~part", "bracket"))
    refill = rospy.ServiceProxy("cell/refill", Trigger)
    tally = Tally()
    for _ in range(arguments.cycles):
        cycle = pick_program.run_cycle(robot, locator)
        tally.add(cycle, truth)
        if cycle.picked() is None or len(truth.latest.parts) < max(1, arguments.refill_below):
            refill()
        print(f"first {tally.first}, later {tally.later}, deadlock {tally.deadlock}", flush=True)
    print(yaml.safe_dump(tally.result()))
    if arguments.output:
        with open(arguments.output, "w") as file:
            yaml.safe_dump(tally.result(), file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
