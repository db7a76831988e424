#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Waits for one bgr8 image on a topic and writes it to a file: save_image.py TOPIC FILE"""
import sys

import cv2
import numpy
import rospy
from sensor_msgs.msg import Image

WAIT = 20.0  # s


def main():
    topic, path = rospy.myargv()[1:3]
    rospy.init_node("save_image", anonymous=True)
    message = rospy.wait_for_message(topic, Image, WAIT)
    if message.encoding != "bgr8":
        sys.exit(f"{topic} is {message.encoding}, not bgr8")
    rows = numpy.frombuffer(message.data, numpy.uint8).reshape(message.height, message.step)
    picture = rows[:, :3 * message.width].reshape(message.height, message.width, 3)
    if not cv2.imwrite(path, picture):
        sys.exit(f"cannot write {path}")


if __name__ == "__main__":
    main()
