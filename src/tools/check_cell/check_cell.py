#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Checks a cell that runs: the camera's picture, its camera_info, how far the answers to a scene that stands still lie
apart, and, where the camera rides on the arm, whether parts stay in place when the arm looks from elsewhere.

    rosrun planar_bin_picking check_cell.py --part bracket --output check_cell.html

Exit status 0: nothing is BAD; 1: something is, the report says what and why; 2: the cell could not be checked."""
import argparse
import math
import os
import statistics
import sys
import time

import numpy
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from planar_bin_picking.srv import LocatePart, LocatePartResponse
from sensor_msgs.msg import CameraInfo, Image

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))  # not catkin's relay of it
import cell_measures
import cell_report

WAIT = 30.0  # s, for whatever has to come
PICTURES = 5  # that are measured
FAR_MM, FAR_DEG = 20.0, 5.0  # how far the camera has to move to look from elsewhere
LOOKED = (LocatePartResponse.OK, LocatePartResponse.DEADLOCK, LocatePartResponse.NO_PART_FOUND, LocatePartResponse.EMPTY)
STILL_MM, STILL_DEG, STILL_S = 0.2, 0.05, 1.0  # less is no motion, and so long


class CannotCheck(Exception):
    """What has to be mended first."""


def parse_args(words):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", default="", help="name in the parts folder; all where it is left out")
    parser.add_argument("--locator", default="locator", help="name of its node")
    parser.add_argument("--count", type=int, default=20, help="calls of a scene that stands still, at least 2")
    parser.add_argument("--image", help="the camera's topic; found out where it is left out")
    parser.add_argument("--output", default="check_cell.html", help="the report")
    parser.add_argument("--histograms", help="a PNG file for the histograms alone")
    parser.add_argument("--limit-mm", type=float, default=0.5, help="of the spread, standard deviation for each axis")
    parser.add_argument("--limit-deg", type=float, default=0.5)
    parser.add_argument("--second-pose", type=float, default=0.0, metavar="SECONDS",
                        help="wait so long for the arm to be moved by hand; 0: hand and eye are not checked")
    parser.add_argument("--hand-eye-mm", type=float, default=3.0, help="how far a part may seem to move between both poses")
    parser.add_argument("--hand-eye-deg", type=float, default=2.0)
    args = parser.parse_args(words)
    if args.count < 2:
        parser.error("--count must be at least 2")
    return args


class Cell:
    def __init__(self, args):
        self.args = args
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        service = rospy.resolve_name(args.locator + "/locate_part")
        try:
            rospy.wait_for_service(service, WAIT)
        except rospy.ROSException:
            raise CannotCheck(f"nobody serves {service}: start the cell, or name its node with --locator")
        self.locate_part = rospy.ServiceProxy(service, LocatePart)
        self.topic = args.image or self.topic_of_camera()

    def topic_of_camera(self):
        """As the locator's diagnostics tell it."""
        name = rospy.resolve_name(self.args.locator).lstrip("/")
        end = time.monotonic() + WAIT
        while time.monotonic() < end:
            try:
                message = rospy.wait_for_message("/diagnostics", DiagnosticArray, WAIT)
            except rospy.ROSException:
                break
            for status in message.status:
                if status.name == name + ": camera":
                    return next(pair.value for pair in status.values if pair.key == "topic")
        raise CannotCheck(f"{name} does not tell its camera's topic on /diagnostics: name it with --image")

    def pictures(self):
        """[(Image, grey levels)] and the camera_info of the last one."""
        images, infos = [], {}
        collect = rospy.Subscriber(self.topic.rsplit("/", 1)[0] + "/camera_info", CameraInfo,
                                   lambda info: infos.update({info.header.stamp: info}), queue_size=10)
        try:
            while len(images) < PICTURES:
                image = rospy.wait_for_message(self.topic, Image, WAIT)
                grey = cell_measures.grey_of(image)
                if grey is None:
                    raise CannotCheck(f"{self.topic} has the encoding {image.encoding}, which is not measured; set the camera to "
                                      "mono8, mono16, rgb8 or an 8-bit Bayer pattern")
                images.append((image, grey))
        except rospy.ROSException:
            raise CannotCheck(f"no image comes on {self.topic}: start the camera; one that waits for a trigger has to run "
                              "freely for this")
        end = time.monotonic() + 2.0
        while images[-1][0].header.stamp not in infos and time.monotonic() < end:
            time.sleep(0.05)
        collect.unregister()
        return images, infos.get(images[-1][0].header.stamp) or next(iter(infos.values()), None)

    def answers(self, count):
        found = []
        for i in range(count):
            answer = self.locate_part(part=self.args.part, timeout=rospy.Duration(WAIT))
            if answer.status not in LOOKED:
                raise CannotCheck(f"call {i + 1} of {count}: {answer.message}")
            # Refused ones are located, too, and as still as the others.
            answer.parts += [refused.located for refused in answer.refused]
            found.append(answer)
        return found

    def camera_pose(self, frame, camera):
        t = self.tf.lookup_transform(frame, camera, rospy.Time(0), rospy.Duration(WAIT)).transform
        return numpy.array([t.translation.x, t.translation.y, t.translation.z]), cell_measures.rotation(t.rotation)

    def await_second_pose(self, frame, camera):
        """Until the camera has moved on tf and stands."""
        start = before = self.camera_pose(frame, camera)
        print(f"move the arm now, by more than {FAR_MM:.0f} mm or {FAR_DEG:.0f} degrees, so that the camera sees the same parts",
              flush=True)
        end, still_since = time.monotonic() + self.args.second_pose, time.monotonic()
        while time.monotonic() < end:
            time.sleep(0.1)
            now = self.camera_pose(frame, camera)
            if is_apart(now, before, STILL_MM, STILL_DEG):
                before, still_since = now, time.monotonic()
            elif is_apart(now, start, FAR_MM, FAR_DEG) and time.monotonic() - still_since > STILL_S:
                return
        raise CannotCheck(f"the camera has not moved within {self.args.second_pose:.0f} s and come to a stop again")


def is_apart(a, b, mm, deg):
    turn = math.degrees(math.acos(min(1.0, max(-1.0, (numpy.trace(a[1].T @ b[1]) - 1.0) / 2.0))))
    return 1e3 * numpy.linalg.norm(a[0] - b[0]) > mm or turn > deg


def picture_section(images, info):
    picture = images[-1][1]
    noise = cell_measures.noise([grey for _, grey in images])
    # Their mean has less noise, which would pass for sharp edges.
    mean = numpy.mean([grey for _, grey in images], axis=0, dtype=numpy.float32)
    focus, ninths = cell_measures.focus(mean, noise[0].value / math.sqrt(len(images)))
    glare, mask = cell_measures.glare(picture)
    findings = [*focus, *cell_measures.exposure(picture), *glare, *noise]
    section = ("The picture", f"{len(images)} pictures of a scene that stands still. Grey levels are those of 8 bits.", findings,
               [cell_report.figure(cell_report.marked(picture, ninths, mask), "What the camera sees: the blur of the edges in each "
                                   "ninth, overexposed spots in red"),
                cell_report.figure(cell_report.grey_histogram(picture), "How often each grey level occurs")])
    if info is None:
        missing = cell_measures.Finding("camera_info comes", "no", "", cell_measures.BAD, "publish camera_info beside the picture")
        return [section, ("The camera's calibration", "", [missing], [])]
    return [section, ("The camera's calibration", "camera_info against the picture.",
                      cell_measures.camera_info(images[-1][0], info), [])]


def spread_section(answers, args):
    tracks = cell_measures.tracks_of(answers)
    findings, deviations = cell_measures.spread(tracks, len(answers), args.limit_mm, args.limit_deg)
    seconds = [sum(t.seconds for t in answer.times if t.stage != "wait") for answer in answers]
    findings.append(cell_measures.Finding("time of a call", statistics.median(seconds), f"s, at most {max(seconds):.2f} s",
                                          cell_measures.GOOD))
    histograms = cell_report.deviation_histograms(deviations)
    if args.histograms:
        with open(args.histograms, "wb") as file:
            file.write(cell_report.png(histograms))
    return tracks, ("How far the answers lie apart", f"{len(answers)} calls of the same scene, each with an image of its own. In the "
                    "frame of the answers.", findings,
                    [cell_report.figure(histograms, "Deviations of each part from its mean, by axis")])


def hand_eye_section(cell, tracks, answers, args):
    heading = "Hand and eye"
    first = next((part for answer in answers for part in answer.parts), None)
    if args.second_pose <= 0.0 or first is None:
        why = "no part was located." if first is None else "call with --second-pose 120 and move the arm when told to."
        return heading, "Not checked: " + why, [], []
    cell.await_second_pose(first.header.frame_id, cell.camera)
    again = cell_measures.tracks_of(cell.answers(max(2, args.count // 4)))
    findings, rows = cell_measures.hand_eye(tracks, again, args.hand_eye_mm, args.hand_eye_deg)
    return heading, "Parts that lie still, located from a second pose of the arm, have to stay in place.", findings, [
        cell_report.moves_table(rows)]


def check(args):
    cell = Cell(args)
    images, info = cell.pictures()
    cell.camera = images[-1][0].header.frame_id
    sections = picture_section(images, info)
    answers = cell.answers(args.count)
    tracks, section = spread_section(answers, args)
    sections.append(section)
    sections.append(hand_eye_section(cell, tracks, answers, args))
    facts = [("Date", time.strftime("%Y-%m-%d %H:%M")), ("Locator", rospy.resolve_name(args.locator)), ("Part", args.part or "all"),
             ("Camera", f"{cell.topic}, frame '{cell.camera}', {images[-1][0].width} x {images[-1][0].height} pixels")]
    with open(args.output, "w", encoding="utf-8") as file:
        file.write(cell_report.page("Check of a cell", facts, sections))
    findings = [finding for _, _, some, _ in sections for finding in some]
    for finding in findings:
        if finding.verdict != cell_measures.GOOD:
            print(f"{finding.verdict}: {finding.name} {cell_report.number(finding.value)} {finding.unit}: {finding.advice}")
    overall = cell_report.verdict(findings)
    print(f"{overall}; the report is {args.output}")
    return 1 if overall == cell_measures.BAD else 0


def main():
    args = parse_args(rospy.myargv()[1:])
    rospy.init_node("check_cell", anonymous=True)
    try:
        return check(args)
    except (CannotCheck, tf2_ros.TransformException, OSError) as error:
        print(f"check_cell: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
