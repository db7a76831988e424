#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""rviz for one cell: fills config/locator.rviz with the frames and topics of a locator that runs, and starts rviz
with it. cell.launch rviz:=true does this. With --teach it is config/teach.rviz, for the part of a teaching node.

    rviz_cell.py NODE [--image TOPIC | --teach] [--only-write] [further arguments of rviz]

With --only-write it prints the path of the filled file and ends."""
import argparse
import math
import os
import sys
import time

import rospkg
import rospy
import tf2_ros
from sensor_msgs.msg import CameraInfo

WAIT = 30.0  # s, for the locator's parameters and the camera's first message
LENS = 45.0  # degrees that rviz shows
SEEN = 0.6  # of what a camera sees at a distance, across
CELLS = 60  # of the grid below a part that is taught


def wait_for(parameter):
    end = time.monotonic() + WAIT
    while not rospy.has_param(parameter):
        if time.monotonic() > end:
            sys.exit(f"rviz_cell.py: there is no parameter {parameter}; start the node, or give its name")
        time.sleep(0.2)
    return rospy.get_param(parameter)


def camera_frame(image):
    """As the camera's messages name it; None where none comes, as from a camera that waits for its trigger."""
    topic = image.rsplit("/", 1)[0] + "/camera_info"
    try:
        return rospy.wait_for_message(topic, CameraInfo, WAIT).header.frame_id.lstrip("/")
    except rospy.ROSException:
        rospy.logwarn(f"rviz_cell.py: no message on {topic} within {WAIT:.0f} s says what the camera's frame is")
        return None


def in_frame(fixed, frame, point):
    """The point of a frame in the fixed one, where tf has it by now."""
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    end = time.monotonic() + WAIT
    while True:
        try:
            transform = buffer.lookup_transform(fixed, frame, rospy.Time(0)).transform
            break
        except tf2_ros.TransformException as error:
            if time.monotonic() > end:
                rospy.logwarn(f"rviz_cell.py: the view begins at the origin of {fixed}: {error}")
                return [0.0, 0.0, 0.0]
            time.sleep(0.1)
    listener.unregister()
    t, q = transform.translation, transform.rotation
    u, p = (q.x, q.y, q.z), point  # p + 2 u x (u x p + w p)
    v = [a + q.w * b for a, b in zip(cross(u, p), p)]
    return [a + 2.0 * b + c for a, b, c in zip(p, cross(u, v), (t.x, t.y, t.z))]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def fill(locator, image):
    """{word of the template: what takes its place}."""
    cell = wait_for(locator + "/cell")
    fixed = cell.get("target_frame") or camera_frame(image)
    if fixed is None:
        sys.exit("rviz_cell.py: nobody says what the fixed frame is; start the camera, or set ~cell/target_frame")
    if cell.get("bin_frame"):
        low, high = cell["bin_min"], cell["bin_max"]
        frame, middle = cell["bin_frame"], [(a + b) / 2.0 for a, b in zip(low, high)]
        size = math.dist(low, high)
    else:  # where parts may lie before the camera
        near, far = cell["distance_min"], cell["distance_max"]
        frame, middle = camera_frame(image), [0.0, 0.0, (near + far) / 2.0]
        size = SEEN * far
    words = {"FIXED_FRAME": fixed, "LOCATOR": locator, "POINT": rospy.resolve_name("clicked_point"),
             "DISTANCE": round(size / 2.0 / math.tan(math.radians(LENS) / 2.0), 3),
             "DOWN": "false" if cell.get("target_frame") else "true"}  # a camera's z points away from it
    focus = [0.0, 0.0, 0.0] if frame is None else in_frame(fixed, frame, middle)
    words.update(zip(("FOCUS_X", "FOCUS_Y", "FOCUS_Z"), (round(m, 4) for m in focus)))
    return words


def fill_teach(node):
    """The same for a part that is taught: all of it is in view, on a grid that suits it."""
    part = wait_for(node + "/view")
    cell = next((size for size in (0.001, 0.01, 0.1) if CELLS * size > 4.0 * part["radius"]), 1.0)
    return {"NODE": node, "FOCUS_X": round(part["x"], 4), "FOCUS_Y": round(part["y"], 4),
            "DISTANCE": round(2.0 * part["radius"] / math.tan(math.radians(LENS) / 2.0) * 0.8, 4),
            "NEAR": round(0.2 * part["radius"], 4), "CELL": cell, "CELL_MM": f"{1e3 * cell:g}",
            "CELLS": CELLS, "BELOW": round(-0.3 * part["radius"], 4)}


def write(locator, words, name):
    """@return  path of the filled file; the next one of the same node takes its place."""
    template = os.path.join(rospkg.RosPack().get_path("planar_bin_picking"), "config", name)
    with open(template, encoding="utf-8") as file:
        text = file.read()
    for word, value in words.items():
        text = text.replace(f"@{word}@", str(value))
    path = os.path.join(rospkg.get_ros_home(), "planar_bin_picking" + locator.replace("/", "_") + ".rviz")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("node", help="name of the locator, or of the teaching node")
    parser.add_argument("--teach", action="store_true")
    parser.add_argument("--image", default="camera/image_raw", help="topic; camera_info stands beside it")
    parser.add_argument("--only-write", action="store_true")
    own, others = parser.parse_known_args()
    rospy.init_node("rviz_cell", anonymous=True, argv=[], disable_signals=True)
    node = rospy.resolve_name(own.node)
    if own.teach:
        path = write(node, fill_teach(node), "teach.rviz")
    else:
        path = write(node, fill(node, rospy.resolve_name(own.image)), "locator.rviz")
    if own.only_write:
        print(path)
        return
    rospy.signal_shutdown("rviz takes over")
    try:
        os.execvp("rviz", ["rviz", "-d", path, *others])
    except FileNotFoundError:
        sys.exit("rviz_cell.py: rviz is not installed: apt install rviz")


if __name__ == "__main__":
    main()
