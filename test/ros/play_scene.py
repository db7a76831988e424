#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Plays a scene (image.png, camera_info.yaml) as the camera and the robot of a cell would show it:
live on topics, or written to a bag. The camera rides on the flange and may move; the picture stays
the same, so in the camera's frame the parts do, too.

Topics: camera/image_raw, camera/camera_info, /tf (base -> flange), /tf_static (flange -> camera).
"""
import argparse
import math
import os
import sys

import cv2
import numpy
import rosbag
import rospy
import yaml
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

TF_RATE = 50.0  # Hz
# The flange at the start: half a metre in front of the base, looking straight down.
START = (0.5, 0.0, 1.0)
DOWN = (1.0, 0.0, 0.0, 0.0)  # x, y, z, w: half a turn about x
# What a hand-eye calibration would have found: the camera beside the flange, turned by 30 degrees.
MOUNT = (0.06, -0.03, 0.05)
MOUNT_TURN = (0.0, 0.0, math.sin(math.radians(15)), math.cos(math.radians(15)))


def parse_args():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help="folder with image.png and camera_info.yaml")
    parser.add_argument("--camera-info", help="another file in place of the scene's")
    parser.add_argument("--rate", type=float, default=2.0, help="images per second")
    parser.add_argument("--velocity", type=float, nargs=3, default=(0.0, 0.0, 0.0),
                        metavar=("X", "Y", "Z"), help="of the flange in the base frame, m/s")
    parser.add_argument("--clock-lead", type=float, default=0.0,
                        help="how far the camera's clock is ahead, s")
    parser.add_argument("--frames", default="", help="in front of the frames' names, such as left/, for one of several cells")
    parser.add_argument("--bag", help="write this file in place of publishing")
    parser.add_argument("--duration", type=float, default=20.0, help="of the bag, s")
    return parser.parse_args(rospy.myargv()[1:])


def load_image(folder):
    path = os.path.join(folder, "image.png")
    grey = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    if grey is None:
        sys.exit(f"cannot read {path}")
    message = Image(height=grey.shape[0], width=grey.shape[1], encoding="mono8",
                    step=grey.shape[1], data=numpy.ascontiguousarray(grey).tobytes())
    return message


def load_camera_info(path):
    with open(path) as file:
        values = yaml.safe_load(file)
    message = CameraInfo(width=values["image_width"], height=values["image_height"],
                         distortion_model=values["distortion_model"],
                         D=values["distortion_coefficients"]["data"],
                         K=values["camera_matrix"]["data"],
                         R=values["rectification_matrix"]["data"],
                         P=values["projection_matrix"]["data"])
    return message


def transform(parent, child, translation, rotation, stamp):
    message = TransformStamped()
    message.header.frame_id = parent
    message.header.stamp = stamp
    message.child_frame_id = child
    t, q = message.transform.translation, message.transform.rotation
    t.x, t.y, t.z = translation
    q.x, q.y, q.z, q.w = rotation
    return TFMessage([message])


class Scene:
    def __init__(self, args):
        self.image = load_image(args.scene)
        self.info = load_camera_info(args.camera_info or
                                     os.path.join(args.scene, "camera_info.yaml"))
        self.base, self.flange, self.camera = (args.frames + frame for frame in ("base", "flange", "camera"))
        self.image.header.frame_id = self.info.header.frame_id = self.camera
        self.velocity = args.velocity
        self.start = None

    def tf_static(self, stamp):
        return transform(self.flange, self.camera, MOUNT, MOUNT_TURN, stamp)

    def tf(self, stamp):
        self.start = self.start or stamp
        time = (stamp - self.start).to_sec()
        position = [x + v * time for x, v in zip(START, self.velocity)]
        return transform(self.base, self.flange, position, DOWN, stamp)

    def images(self, stamp):
        self.image.header.stamp = self.info.header.stamp = stamp
        return self.image, self.info


def write_bag(scene, args):
    start = rospy.Time(1000)
    partial = args.bag + ".part"  # a bag that stands under its own name is complete
    with rosbag.Bag(partial, "w") as bag:
        # Latched, as it was when a robot's tf was recorded: for those who come later.
        bag.write("/tf_static", scene.tf_static(start), start, connection_header={
            "topic": "/tf_static", "type": TFMessage._type, "md5sum": TFMessage._md5sum,
            "message_definition": TFMessage._full_text, "latching": "1"})
        for i in range(int(args.duration * TF_RATE)):
            stamp = start + rospy.Duration(i / TF_RATE)
            bag.write("/tf", scene.tf(stamp), stamp)
        for i in range(1, int(args.duration * args.rate)):
            # Between two samples of tf, as it would be; the last tf is later than the last image.
            stamp = start + rospy.Duration((i + 0.3 / TF_RATE) / args.rate)
            image, info = scene.images(stamp)
            bag.write("/camera/image_raw", image, stamp)
            bag.write("/camera/camera_info", info, stamp)
    os.replace(partial, args.bag)


def publish(scene, args):
    rospy.init_node("play_scene")
    tf_static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
    tf = rospy.Publisher("/tf", TFMessage, queue_size=100)
    image_pub = rospy.Publisher("camera/image_raw", Image, queue_size=1)
    info_pub = rospy.Publisher("camera/camera_info", CameraInfo, queue_size=1)
    tf_static.publish(scene.tf_static(rospy.Time.now()))
    ticks_per_image = max(1, round(TF_RATE / args.rate))
    rate, ticks = rospy.Rate(TF_RATE), 0
    try:
        while True:
            tf.publish(scene.tf(rospy.Time.now()))
            ticks += 1
            if ticks % ticks_per_image == 0:
                image, info = scene.images(rospy.Time.now() + rospy.Duration(args.clock_lead))
                image_pub.publish(image)
                info_pub.publish(info)
            rate.sleep()
    except rospy.ROSException:  # what publish and sleep say at shutdown
        if not rospy.is_shutdown():
            raise


def main():
    args = parse_args()
    scene = Scene(args)
    if args.bag:
        write_bag(scene, args)
    else:
        publish(scene, args)


if __name__ == "__main__":
    main()
