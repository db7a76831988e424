#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Runs pick cycles as pick_program.py does, holds them against the truth that the simulated cell
publishes, and writes what came of them.

    cycle_statistics.py --cycles 100 [--refill-below 8] [--output result.yaml] [--save FOLDER]

A cycle is one part picked, or a deadlock: nothing could be picked out of three images in a row. The bin is
filled anew after a deadlock, and once fewer parts are left in it than --refill-below (0: it is emptied
as far as it goes; what is left then is counted). What went wrong or was off by more than wanted is saved:
the picture, its camera_info, the truth and what was offered.
"""
import argparse
import collections
import math
import os
import statistics
import sys
import time
from pathlib import Path

import numpy
import rospy
import yaml

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
import pick_program
from pick_program import matrix
from planar_bin_picking.msg import LocatedParts
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger
from tf_conversions import posemath


WANTED = dict(x=0.5, y=0.5, yaw=0.3)  # mm, mm, degrees: the largest error of a picked part


def plain(pose):
    """A pose as locate_image writes it."""
    p, q = pose.position, pose.orientation
    return dict(position=[p.x, p.y, p.z], orientation=[q.x, q.y, q.z, q.w])


def camera_info(info):
    """As camera_info.yaml has it, for locate_image."""
    matrix_of = lambda rows, data: dict(rows=rows, cols=len(data) // rows, data=list(data))
    return dict(image_width=info.width, image_height=info.height, camera_name="camera",
                distortion_model=info.distortion_model, camera_matrix=matrix_of(3, info.K),
                distortion_coefficients=matrix_of(1, info.D),
                rectification_matrix=matrix_of(3, info.R), projection_matrix=matrix_of(3, info.P))


class Recorder:
    """Keeps the latest pictures, and writes one with all that belongs to it."""

    PICTURES = 4  # a cycle looks at three at most

    def __init__(self, folder, truth, robot):
        self.folder, self.truth, self.robot = folder, truth, robot
        self.images = collections.OrderedDict()
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        self.subscribers = [rospy.Subscriber("camera/image_raw", Image, self.receive),
                            rospy.Subscriber("camera/camera_info", CameraInfo, self.write_info)]

    def receive(self, image):
        self.images[image.header.stamp] = image
        while len(self.images) > self.PICTURES:
            self.images.popitem(last=False)

    def write_info(self, info):
        (self.folder / "camera_info.yaml").write_text(yaml.safe_dump(camera_info(info)))

    def save(self, name, cycle):
        """Of the cycle's first answer that offered a part, or of its first."""
        if self.folder is None:
            return
        answer = next((a for a in cycle.answers if a.parts), cycle.answers[0])
        report = dict(
            message=answer.message, attempts=[[a.part.child_frame, a.pick.name if a.pick else "", a.outcome.message] for a in cycle.attempts],
            T_base_camera=posemath.toMatrix(self.robot.lookup("base", "camera")).tolist(),
            offered=[dict(frame=p.child_frame, score=p.score, visible=p.visible_fraction, face=p.face,
                          **plain(p.pose.pose)) for p in answer.parts],
            refused=[dict(text=r.text, **plain(r.located.pose.pose)) for r in answer.refused])
        located = answer.parts or [r.located for r in answer.refused]
        if cycle.attempts:
            report["error"] = self.truth.error(cycle.attempts[0])
        if located:
            stamp = located[0].header.stamp
            report["truth"] = [dict(name=t.child_frame, face=t.face, visible=t.visible_fraction,
                                    **plain(t.pose.pose)) for t in self.truth.at(stamp).parts]
            self.write_image(name, self.images[stamp])
        (self.folder / (name + ".yaml")).write_text(yaml.safe_dump(report))

    def write_image(self, name, image):
        head = b"P5 %d %d 255\n" % (image.width, image.height)
        (self.folder / (name + ".pgm")).write_bytes(head + bytes(image.data))


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

    def error(self, attempt):
        """x, y, z in mm, yaw and tilt in degrees, of the pick pose; to the nearest true part."""
        located, T = attempt.part, matrix(attempt.pick.pose)
        T_part_pick = numpy.linalg.inv(matrix(located.pose.pose)) @ T
        best = None
        for part in self.at(located.header.stamp).parts:
            if part.part != located.part:
                continue
            for symmetric in part.picks:
                T_true = matrix(symmetric.pose) @ T_part_pick
                d = 1e3 * (T[:3, 3] - T_true[:3, 3])
                R = T_true[:3, :3].T @ T[:3, :3]
                yaw = math.degrees(math.atan2(R[1, 0] - R[0, 1], R[0, 0] + R[1, 1]))
                tilt = math.degrees(math.acos(max(-1.0, min(1.0, R[2, 2]))))
                size = numpy.linalg.norm(d) + abs(yaw) + tilt
                if best is None or size < best[0]:
                    best = size, dict(zip(("x", "y", "z", "yaw", "tilt"),
                                                map(float, (*abs(d), abs(yaw), tilt))))
        return best[1]


class Tally:
    def __init__(self):
        self.first = self.later = self.deadlock = 0
        self.errors, self.seconds, self.left, self.failures = [], [], [], collections.Counter()

    def add(self, cycle, truth):
        """@return  why this cycle is worth a look, or None"""
        self.seconds += [sum(t.seconds for t in answer.times if t.stage != "wait")
                         for answer in cycle.answers]
        # Only the first: after a failure parts may have moved, and what stood in the image is stale.
        for attempt in cycle.attempts[:1]:
            if attempt.success():
                continue
            error = truth.error(attempt)
            is_wrong = max(error["x"], error["y"]) > 1.5 or error["z"] > 5.0 or error["tilt"] > 5.0
            self.failures[attempt.outcome.message +
                          (", pose wrong" if is_wrong else ", pose right")] += 1
        if cycle.picked() is None:
            self.deadlock += 1
            return "deadlock"
        error = truth.error(cycle.picked())
        self.errors.append(error)
        if len(cycle.attempts) > 1:
            self.later += 1
            return "later"
        self.first += 1
        return "error" if any(error[key] > most for key, most in WANTED.items()) else None

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
    parser.add_argument("--save", type=Path, help="folder for what went wrong")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("cycle_statistics")
    truth = Truth()
    robot = pick_program.Robot()
    locator = pick_program.Locator(rospy.get_param("~part", "bracket"))
    refill = rospy.ServiceProxy("cell/refill", Trigger)
    tally, recorder = Tally(), Recorder(arguments.save, truth, robot)
    start = time.monotonic()
    for i in range(arguments.cycles):
        cycle = pick_program.run_cycle(robot, locator)
        reason = tally.add(cycle, truth)
        if reason is not None:
            recorder.save(f"{locator.part}_{i:04d}_{reason}", cycle)
        if cycle.picked() is None or len(truth.latest.parts) < max(1, arguments.refill_below):
            tally.left.append(len(truth.latest.parts))  # 0 where the bin was emptied
            refill()
        print(f"first {tally.first}, later {tally.later}, deadlock {tally.deadlock}; "
              f"{(time.monotonic() - start) / (i + 1):.2f} s per cycle", flush=True)
    print(yaml.safe_dump(tally.result()))
    if arguments.output:
        with open(arguments.output, "w") as file:
            yaml.safe_dump(tally.result(), file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
