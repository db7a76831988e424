#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Cameras that look at three decades of light and take an exposure time, each with its own manners:

    obeys      dynamic_reconfigure (int, microseconds); two frames are still under way with the old one
    seconds    dynamic_reconfigure (double, seconds)
    service    SetExposure
    ignores    answers as if it had taken the command in
    clamps     uses 10 ms at most, and says so
    drops      sends nothing for 3 s after a command
    waits      takes a frame on request only
    eager      as waits, ignores commands, and answers a request only once its frame is out
    refuses    SetExposure: takes no command in, and says why
    rounds     SetExposure: uses 10 ms, and says so
    auto       says that its exposure is 0
    hangs      does not answer a command for 3 s
    mute       as waits, but does not answer a request for 3 s, and takes no frame

    fake_cameras.py obeys service ...      topics and services stand below the name
"""
import threading

import numpy
import rospy
from dynamic_reconfigure.msg import Config, DoubleParameter, IntParameter
from dynamic_reconfigure.srv import Reconfigure, ReconfigureResponse
from planar_bin_picking.srv import SetExposure, SetExposureResponse
from sensor_msgs.msg import CameraInfo, Image
from std_srvs.srv import Trigger, TriggerResponse

RATE = 25.0  # Hz
SINGLE = 0.008  # s
WIDTH, HEIGHT = 320, 240
UNDER_WAY = 2  # frames
SILENCE = 3.0  # s


def light():
    """Per second; 255 is full scale. Three decades over the width, with a pattern on them."""
    x, y = numpy.meshgrid(numpy.arange(WIDTH), numpy.arange(HEIGHT))
    return 100.0 * 1000.0 ** (x / (WIDTH - 1.0)) * numpy.where((x // 8 + y // 8) % 2, 1.2, 1.0)


class Camera:
    def __init__(self, manners):
        self.manners = manners
        self.lock = threading.Lock()
        self.exposures = [SINGLE] * (UNDER_WAY + 1)  # of the next frames
        self.silent_until = 0.0
        self.random = numpy.random.default_rng(1)
        self.image = rospy.Publisher(f"{manners}/camera/image_raw", Image, queue_size=1)
        self.info = rospy.Publisher(f"{manners}/camera/camera_info", CameraInfo, queue_size=1)
        self.wanted = threading.Event()
        self.scene, self.asked = light(), 0
        if manners in ("waits", "mute", "eager"):
            rospy.Service(f"{manners}/camera/trigger", Trigger, self.serve_trigger)
        if manners in ("service", "refuses", "rounds"):
            rospy.Service(f"{manners}/set_exposure", SetExposure, self.serve_exposure)
        else:
            rospy.Service(f"{manners}/camera/set_parameters", Reconfigure, self.serve_parameters)

    def command(self, seconds):
        """Takes a command in; what the camera says that it uses."""
        if self.manners == "hangs":
            rospy.sleep(SILENCE)
        if self.manners in ("clamps", "rounds"):
            seconds = 0.010 if self.manners == "rounds" else min(seconds, 0.010)
        if self.manners not in ("ignores", "eager"):
            with self.lock:
                self.exposures[-1] = seconds
                if self.manners == "drops":
                    self.silent_until = rospy.get_time() + SILENCE
        return seconds

    def serve_trigger(self, _):
        if self.manners == "mute":
            rospy.sleep(SILENCE)
            return TriggerResponse(success=False, message="mute")
        self.wanted.set()
        if self.manners == "eager":
            self.asked += 1
            rospy.set_param("eager/asked", self.asked)
            self.publish(self.scene)
            rospy.sleep(0.02)  # the frame is out and has come in
        return TriggerResponse(success=True)

    def serve_exposure(self, request):
        if self.manners == "refuses":
            return SetExposureResponse(success=False, message="the shutter is locked")
        return SetExposureResponse(success=True, seconds=self.command(request.seconds))

    def serve_parameters(self, request):
        used = 0.0 if self.manners == "auto" else self.exposures[-1]
        for parameter in request.config.ints:
            if parameter.name == "exposure":
                used = self.command(1e-6 * parameter.value)
        for parameter in request.config.doubles:
            if parameter.name == "exposure":
                used = self.command(parameter.value)
        config = Config(ints=[IntParameter("gain", 0)])
        if self.manners == "seconds":
            config.doubles.append(DoubleParameter("exposure", used))
        else:
            config.ints.append(IntParameter("exposure", round(1e6 * used)))
        return ReconfigureResponse(config)

    def publish(self, scene):
        if self.manners in ("waits", "mute", "eager") and not self.wanted.is_set():
            return
        self.wanted.clear()
        with self.lock:
            seconds = self.exposures.pop(0)
            self.exposures.append(self.exposures[-1])
            if rospy.get_time() < self.silent_until:
                return
        grey = scene * seconds + self.random.normal(0.0, 1.0, scene.shape)
        image = Image(height=HEIGHT, width=WIDTH, encoding="mono8", step=WIDTH,
                      data=numpy.clip(numpy.round(grey), 0, 255).astype(numpy.uint8).tobytes())
        image.header.stamp = rospy.Time.now()
        image.header.frame_id = "camera"
        info = CameraInfo(header=image.header, height=HEIGHT, width=WIDTH,
                          distortion_model="plumb_bob", D=[0.0] * 5,
                          K=[400.0, 0.0, 160.0, 0.0, 400.0, 120.0, 0.0, 0.0, 1.0])
        self.image.publish(image)
        self.info.publish(info)


def main():
    rospy.init_node("fake_cameras")
    cameras = [Camera(manners) for manners in rospy.myargv()[1:]]
    scene = light()
    rate = rospy.Rate(RATE)
    while not rospy.is_shutdown():
        for camera in cameras:
            if camera.manners != "eager":
                camera.publish(scene)
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass
