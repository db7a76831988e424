# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""check_cell.py on a cell that is well, and on one that is not: cases of operation_tester.py."""
import math
import os
import re
import subprocess
import threading
import time

import cv2
import numpy
import play_scene
import roslib.packages

MINUTES = 180.0  # s, for the program; machines may be busy
HALF_TURN = 0.3  # rad, half of what the camera is turned by about its axis


def turned_about_the_axis():
    """The flange's pose at which the camera has turned about its axis, and the picture that it then sees."""
    mount, turn = numpy.array(play_scene.MOUNT[:2]), 2.0 * HALF_TURN
    rotation = numpy.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    shift = mount - rotation @ mount  # in the flange's frame, whose y and z are against the base's
    x, y, z = play_scene.START
    flange = (x + shift[0], y - shift[1], z)
    orientation = (math.cos(HALF_TURN), -math.sin(HALF_TURN), 0.0, 0.0)  # half a turn about x, then about the flange's z

    def spoil(image, info):
        K = numpy.reshape(info.K, (3, 3)).copy()
        K[:2] /= info.binning_x  # as the picture is binned
        K[:2, 2] -= 0.5 * (1.0 - 1.0 / info.binning_x)
        R = cv2.Rodrigues(numpy.array([0.0, 0.0, -turn]))[0]
        grey = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width)
        image.data = cv2.warpPerspective(grey, K @ R @ numpy.linalg.inv(K), (image.width, image.height),
                                         flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).tobytes()
    return {"flange": flange, "turn": orientation, "spoil": spoil}


class CheckCellCases:
    def check_cell(self, *arguments, during=None):
        """(exit status, what it printed, its report); `during` is called once the arm is to be moved."""
        program = roslib.packages.find_node("planar_bin_picking", "check_cell.py")[0]
        report = os.path.join(self.scratch, "check_cell.html")
        process = subprocess.Popen([program, "--locator", "op", "--part", "bracket", "--count", "4", "--output", report,
                                    "--histograms", os.path.join(self.scratch, "histograms.png"), *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        watchdog = threading.Timer(MINUTES, process.kill)
        watchdog.start()
        printed = ""
        for line in process.stdout:
            printed += line
            if during and line.startswith("move the arm now"):
                during()
        watchdog.cancel()
        with open(report) as file:
            return process.wait(), printed, file.read()

    def verdicts(self, report):
        """{what: verdict}."""
        return dict(re.findall(r"<tr><td>([^<]*)</td><td class=\"number\">[^<]*</td><td>[^<]*</td><td class=\"verdict (\w+)\">",
                               report))

    def test_check_cell_finds_nothing_wrong_where_nothing_is(self):
        status, printed, report = self.check_cell("--second-pose", "60", "--limit-mm", "1.0",
                                                  during=lambda: self.cell.change(**turned_about_the_axis()))
        self.assertEqual(status, 0, printed)
        verdicts = self.verdicts(report)
        for what in ("blur of edges", "overexposed", "noise", "camera_info is calibrated", "spread, x, mm", "spread, about z, deg",
                     "they seem to move by"):
            self.assertEqual(verdicts[what], "GOOD", printed)
        self.assertGreaterEqual(report.count("data:image/png;base64,"), 3)
        histograms = cv2.imread(os.path.join(self.scratch, "histograms.png"))
        self.assertGreater(numpy.count_nonzero((histograms == (150, 90, 20)).all(axis=2)), 100)  # bars

    def test_check_cell_says_what_is_wrong(self):
        generator = numpy.random.default_rng(1)

        def spoil(image, info):
            grey = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width)
            blurred = 0.85 * cv2.GaussianBlur(grey, (0, 0), 2.5) + generator.normal(0.0, 4.0, grey.shape)
            blurred[:150, :150] = 255.0
            image.data = numpy.clip(blurred, 0, 255).astype(numpy.uint8).tobytes()
            info.header.frame_id = "other"
        self.cell.change(spoil=spoil)
        # The picture stays as it is: where the arm says that it goes, the parts seem to go, too.
        x, y, z = play_scene.START
        status, printed, report = self.check_cell("--second-pose", "60",
                                                  during=lambda: self.cell.change(flange=(x + 0.03, y, z)))
        self.assertEqual(status, 1, printed)
        verdicts = self.verdicts(report)
        self.assertEqual({what: verdicts[what] for what in (
            "blur of edges", "noise", "overexposed", "largest spot of glare", "both have the same frame", "they seem to move by")},
            {"blur of edges": "LOOK", "noise": "LOOK", "overexposed": "LOOK", "largest spot of glare": "BAD",
             "both have the same frame": "BAD", "they seem to move by": "BAD"}, printed)
        self.assertIn("calibrate hand and eye anew", printed)
        # A picture in which nothing is found gets a report, too.
        self.cell.change(spoil=lambda image, _info: setattr(image, "data", bytes([40]) * len(image.data)))
        status, printed, report = self.check_cell("--second-pose", "60")
        self.assertEqual(status, 1, printed)
        verdicts = self.verdicts(report)
        self.assertEqual((verdicts["brightest hundredth"], verdicts["contrast"], verdicts["parts that every answer has"]),
                         ("BAD", "BAD", "BAD"), printed)
        self.assertIn("no part was located", report)

    def test_check_cell_says_why_it_cannot_check(self):
        self.cell.change(has_images=False)
        time.sleep(0.5)
        program = roslib.packages.find_node("planar_bin_picking", "check_cell.py")[0]
        done = subprocess.run([program, "--locator", "op", "--image", "nowhere/image_raw"], capture_output=True, text=True,
                              timeout=MINUTES)
        self.assertEqual(done.returncode, 2)
        self.assertIn("no image comes on nowhere/image_raw", done.stderr)
