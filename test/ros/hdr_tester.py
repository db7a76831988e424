#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Calls the HDR nodes of hdr.test: what comes of cameras that obey and of cameras that do not."""
import re
import sys
import unittest

import numpy
import rospy
import rostest
from fake_cameras import SINGLE, light
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger

WAIT = 20.0  # s


class Hdr:
    """One HDR node: its service, and the image that comes with its camera_info."""

    def __init__(self, manners):
        self.pairs, self.images, self.infos = [], {}, {}
        rospy.Subscriber(f"{manners}/hdr/image_raw", Image, self.pair, self.images)
        rospy.Subscriber(f"{manners}/hdr/camera_info", CameraInfo, self.pair, self.infos)
        rospy.wait_for_service(f"{manners}/hdr/take", WAIT)
        self.take = rospy.ServiceProxy(f"{manners}/hdr/take", Trigger)

    def pair(self, message, store):
        """Those two belong together that have one stamp."""
        stamp = message.header.stamp
        store[stamp] = message
        if stamp in self.images and stamp in self.infos:
            self.pairs.append((self.images[stamp], self.infos[stamp]))

    def call(self):
        """Response, image as an array, camera_info, and how old the image's stamp is."""
        count, start = len(self.pairs), rospy.Time.now()
        response = self.take()
        deadline = rospy.get_time() + WAIT
        while len(self.pairs) == count:
            if rospy.get_time() > deadline:
                raise AssertionError("no image with a camera_info of its stamp: " + response.message)
            rospy.sleep(0.01)
        image, info = self.pairs[-1]
        grey = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width)
        return response, grey.astype(float), info, (image.header.stamp - start).to_sec()


def contrast(grey, x):
    """Of the pattern about column x, in grey levels: its two kinds of fields."""
    columns, rows = numpy.meshgrid(numpy.arange(x, x + 8), numpy.arange(grey.shape[0]))
    odd = (columns // 8 + rows // 8) % 2 == 1
    fields = grey[:, x:x + 8]
    return fields[odd].mean() - fields[~odd].mean()


class HdrTest(unittest.TestCase):
    def check_merged(self, manners):
        hdr = Hdr(manners)
        for _ in range(2):  # the second call finds the single exposure again
            response, grey, info, age = hdr.call()
            self.assertTrue(response.success, response.message)
            self.assertGreaterEqual(age, 0.0)  # no frame from before the call
            self.assertEqual(info.K[0], 400.0)
            # Both ends of three decades; a single exposure shows one of them at best.
            self.assertGreater(contrast(grey, 128), 1.5)
            self.assertGreater(contrast(grey, 296), 5.0)
            self.assertLess((grey == 255).mean(), 0.01)
            self.assertTrue((numpy.diff(grey.mean(axis=0)[::16]) > 0).all())

    def check_single(self, manners, *words):
        response, grey, _, age = Hdr(manners).call()
        self.assertFalse(response.success)
        message = re.sub(r"looks like (\S+) ms", lambda found: f"looks like {float(found[1]):.1f} ms",
                         response.message)  # the picture has noise
        for word in ("the single exposure goes on",) + words:
            self.assertIn(word, message)
        self.assertGreaterEqual(age, 0.0)
        expected = numpy.clip(light() * SINGLE, 0, 255)
        self.assertLess(numpy.abs(grey - expected).mean(), 2.0)

    def test_obeys(self):
        self.check_merged("obeys")

    def test_seconds(self):
        self.check_merged("seconds")

    def test_service(self):
        self.check_merged("service")

    def test_waits(self):
        self.check_merged("waits")

    def test_ignores(self):
        self.check_single("ignores", "looks like 8.0 ms", "ignores the command")

    def test_clamps(self):
        self.check_single("clamps", "asked for 32 ms, the camera says 10 ms")

    def test_drops(self):
        self.check_single("drops", "no frame came within")

    def test_hangs(self):
        self.check_single("hangs", "did not answer within")

    def test_mute(self):
        response = Hdr("mute").take()
        self.assertFalse(response.success)
        self.assertIn("no answer within ~hdr/command_timeout", response.message)

    def test_eager(self):
        """Nothing ever waits for a frame: the number of triggers ends it."""
        start = rospy.get_time()
        self.check_single("eager", "asked for 2 ms, but the newest of 6 frames since then looks like 8.0 ms")
        self.assertLess(rospy.get_time() - start, 4.0)
        # The single image, six that show no 2 ms, one on the way back.
        self.assertEqual(rospy.get_param("eager/asked"), 8)

    def test_refuses(self):
        self.check_single("refuses", "set_exposure refused 2 ms: the shutter is locked")

    def test_rounds(self):
        self.check_single("rounds", "asked for 2 ms, the camera says 10 ms")

    def test_auto(self):
        self.check_single("auto", "the camera says that its exposure is 0 ms", "~hdr/single_ms")

    def test_long(self):
        self.check_single("long", "5e+04 ms is more than exposure can hold", "~hdr/exposure_unit_seconds")

    def test_absent(self):
        self.check_single("absent", "nobody offers", "nothing/set_parameters")

    def test_misnamed(self):
        self.check_single("misnamed", "ExposureTime", "gain exposure")


if __name__ == "__main__":
    rospy.init_node("hdr_tester")
    rostest.rosrun("planar_bin_picking", "hdr", HdrTest, sys.argv)
