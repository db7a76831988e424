#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""A camera, a robot's tf and a trigger that do what a test tells them, good or bad."""
import copy
import os
import sys
import threading

import cv2
import numpy
import rospy
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger, TriggerResponse
from tf2_msgs.msg import TFMessage

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
import play_scene

TF_RATE = 50.0  # Hz
TICKS_PER_IMAGE = 10
SHRINK = 2  # by binning: fewer pixels take less time


class Arguments:
    """What play_scene.Scene wants to know."""

    def __init__(self, scene):
        self.scene, self.camera_info, self.velocity, self.frames = scene, None, (0.0, 0.0, 0.0), ""


class DrivenCell:
    """Publishes in a thread. Everything about it may be changed at any time."""

    def __init__(self, scene):
        self.scene = play_scene.Scene(Arguments(scene))
        self.grey = self.shrunken(self.scene.image)
        self.scene.info.binning_x = self.scene.info.binning_y = SHRINK
        self.lock = threading.Lock()
        self.good()
        self.tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self.tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
        self.image = rospy.Publisher("camera/image_raw", Image, queue_size=1)
        self.info = rospy.Publisher("camera/camera_info", CameraInfo, queue_size=1)
        rospy.Service("trigger", Trigger, self.serve_trigger)
        self.tf_static.publish(self.scene.tf_static(rospy.Time.now()))
        threading.Thread(target=self.run, daemon=True).start()

    def good(self):
        """Everything works."""
        with self.lock:
            self.has_tf = self.has_images = self.has_info = True
            self.image_lead = self.info_lead = 0.0  # s, of their stamps
            self.spoil = lambda image, info: None  # changes both before they go out
            self.flange = None  # where it is; None: at rest
            self.turn = play_scene.DOWN  # of the flange
            self.trigger_result = TriggerResponse(success=True)
            self.trigger_takes_image = True
            self.zero_stamps = False

    def change(self, **values):
        with self.lock:
            for name, value in values.items():
                assert hasattr(self, name), name
                setattr(self, name, value)

    @staticmethod
    def shrunken(image):
        grey = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.width)
        size = (image.width // SHRINK, image.height // SHRINK)
        return cv2.resize(grey, size, interpolation=cv2.INTER_AREA)

    def take(self):
        """One image with its camera_info, as things are now. Under the lock."""
        now = rospy.Time.now()
        image = Image(height=self.grey.shape[0], width=self.grey.shape[1], encoding="mono8",
                      step=self.grey.shape[1], data=self.grey.tobytes())
        info = copy.deepcopy(self.scene.info)
        image.header.frame_id = info.header.frame_id = "camera"
        if not self.zero_stamps:
            image.header.stamp = now + rospy.Duration(self.image_lead)
            info.header.stamp = now + rospy.Duration(self.image_lead + self.info_lead)
        self.spoil(image, info)
        self.image.publish(image)
        if self.has_info:
            self.info.publish(info)

    def serve_trigger(self, _):
        with self.lock:
            if self.trigger_takes_image:
                self.take()
            return self.trigger_result

    def run(self):
        try:
            self.play()
        except rospy.ROSException:  # what publish and sleep say at shutdown
            if not rospy.is_shutdown():
                raise

    def play(self):
        rate, ticks = rospy.Rate(TF_RATE), 0
        while not rospy.is_shutdown():
            with self.lock:
                if self.has_tf:
                    self.tf.publish(self.pose())
                if self.has_images and ticks % TICKS_PER_IMAGE == 0:
                    self.take()
            ticks += 1
            rate.sleep()

    def pose(self):
        return play_scene.transform("base", "flange", self.flange or play_scene.START,
                                    self.turn, rospy.Time.now())


def in_sixteen_bits(bits, swapped=False, encoding="mono16"):
    """Makes the image one of a camera of so many bits."""
    def spoil(image, _info):
        grey = numpy.frombuffer(image.data, numpy.uint8).astype(numpy.uint16) << (bits - 8)
        image.data = (grey.byteswap() if swapped else grey).tobytes()
        image.encoding, image.step, image.is_bigendian = encoding, 2 * image.width, swapped
    return spoil
