# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Flat plates before cameras, drawn; test/ros/drawn/plate.dxf has the same outline. tf says where the camera
was at each picture, and that it has moved on right after: who looks it up at another time is wrong."""
import threading
import time

import cv2
import numpy
import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import CameraInfo, Image

WIDTH, HEIGHT, FOCAL, CX, CY = 1200, 1000, 1700.0, 604.0, 493.0
OUTER = [(-33, -29), (47, -29), (47, -9), (-3, -9), (-3, 21), (-33, 21)]
HOLES = [(-18, 6, 6), (32, -19, 4)]
RATE = 8.0  # Hz
FINER = 3  # lines and columns that are drawn for each one


def rotation(axis, degrees):
    vector = numpy.zeros(3)
    vector["xyz".index(axis)] = numpy.radians(degrees)
    T = numpy.eye(4)
    T[:3, :3] = cv2.Rodrigues(vector)[0]
    return T


def shift(x, y, z):
    T = numpy.eye(4)
    T[:3, 3] = x, y, z
    return T


def transform(parent, child, T, stamp):
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id, message.header.stamp = parent, child, stamp
    p, q = message.transform.translation, message.transform.rotation
    p.x, p.y, p.z = T[:3, 3]
    axis = cv2.Rodrigues(T[:3, :3])[0].ravel()
    angle = numpy.linalg.norm(axis)
    half = axis / angle * numpy.sin(angle / 2) if angle > 0 else axis
    q.x, q.y, q.z, q.w = *half, numpy.cos(angle / 2)
    return message


T_HAND_EYE = shift(0.05, 0.02, 0.1) @ rotation("z", 30)
RIM = [(-108, -78), (108, -78), (108, 78), (-108, 78)]  # mm, about a bin of 200 x 140
OPENING = [(-100, -70), (100, -70), (100, 70), (-100, 70)]


def draw(T_base_camera, plates, seed, bins=()):
    """8 bit; plates are poses of the plate in base, bins those of bins, whose rims lie in z = 0."""
    large = numpy.full((HEIGHT * FINER, WIDTH * FINER), 60, numpy.uint8)
    circle = [(numpy.cos(a), numpy.sin(a)) for a in numpy.linspace(0, 2 * numpy.pi, 120)]

    def fill(T_camera_plate, ring, grey):
        points = []
        for i, a in enumerate(ring):
            b = ring[(i + 1) % len(ring)]
            points += [numpy.add(a, numpy.subtract(b, a) * s) for s in numpy.linspace(0, 1, 8, False)]
        x = T_camera_plate @ numpy.array([[p[0] / 1e3, p[1] / 1e3, 0.0, 1.0] for p in points]).T
        u, v = FOCAL * x[0] / x[2] + CX, FOCAL * x[1] / x[2] + CY
        fine = numpy.stack([(u + 0.5) * FINER - 0.5, (v + 0.5) * FINER - 0.5], 1)
        cv2.fillPoly(large, [numpy.round(fine * 256).astype(numpy.int32)], grey, cv2.LINE_AA, 8)

    for T_base_bin in bins:
        T = numpy.linalg.inv(T_base_camera) @ T_base_bin
        fill(T, RIM, 170)
        fill(T, OPENING, 90)
    for T_base_plate in plates:
        T = numpy.linalg.inv(T_base_camera) @ T_base_plate
        if (T @ numpy.array([0, 0, 0, 1.0]))[2] < 0.1:
            continue
        fill(T, OUTER, 150)
        for x, y, r in HOLES:
            fill(T, [(x + r * c, y + r * s) for c, s in circle], 60)
    image = cv2.resize(large, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA).astype(numpy.float32)
    image = cv2.GaussianBlur(image, (0, 0), 0.6)
    image += numpy.random.default_rng(seed).normal(0.0, 2.0, image.shape)
    return numpy.clip(image, 0, 255).astype(numpy.uint8)


class DrawnCell:
    """A camera on an arm and one that stands still, sending pictures all the time."""

    def __init__(self, T_base_second):
        self.lock = threading.Lock()
        self.T_second = T_base_second
        self.cameras = {name: (rospy.Publisher(f"{name}/image_raw", Image, queue_size=1),
                               rospy.Publisher(f"{name}/camera_info", CameraInfo, queue_size=1))
                        for name in ("camera", "second")}
        self.tf = tf2_ros.TransformBroadcaster()
        self.static = tf2_ros.StaticTransformBroadcaster()
        now = rospy.Time.now()
        self.static.sendTransform([transform("base", "second_camera", T_base_second, now),
                                   transform("base", "tray", numpy.eye(4), now),  # where a bin is said to stand
                                   transform("hand", "eye", T_HAND_EYE, now)])  # of a robot that is not on tf
        self.T, self.pictures, self.seed = numpy.eye(4), None, 0
        self.faults = {}
        threading.Thread(target=self.send, daemon=True).start()

    def show(self, T_base_camera, plates, plates_second=None, bins=(), **faults):
        """From now on. Faults: silent, frame_id, encoding, K."""
        with self.lock:
            self.seed += 1
            self.T, self.faults = T_base_camera, faults
            second = plates if plates_second is None else plates_second
            self.pictures = {"camera": draw(T_base_camera, plates, self.seed, bins),
                             "second": draw(self.T_second, second, 100 + self.seed)}

    def send(self):
        while not rospy.is_shutdown():
            with self.lock:
                if self.pictures is not None and not self.faults.get("silent"):
                    self.send_once()
            time.sleep(1.0 / RATE)

    def send_once(self):
        stamp = rospy.Time.now()
        beside = rospy.Duration(0.01)
        self.tf.sendTransform([transform("base", "camera", self.T, stamp - beside),
                               transform("base", "camera", self.T, stamp + beside),
                               transform("base", "camera", self.T @ shift(0.01, 0.01, 0), stamp + 3 * beside)])
        for name, (images, infos) in self.cameras.items():
            image = Image(height=HEIGHT, width=WIDTH, step=WIDTH, encoding="mono8")
            image.header.stamp = stamp
            image.header.frame_id = name
            image.data = self.pictures[name].tobytes()
            info = CameraInfo(header=image.header, width=WIDTH, height=HEIGHT,
                              distortion_model="plumb_bob", D=[0.0] * 5)
            info.K = [FOCAL, 0, CX, 0, FOCAL, CY, 0, 0, 1]
            info.R = [1, 0, 0, 0, 1, 0, 0, 0, 1]
            info.P = [FOCAL, 0, CX, 0, 0, FOCAL, CY, 0, 0, 0, 1, 0]
            image.header.frame_id = self.faults.get("frame_id", name)
            image.encoding = self.faults.get("encoding", "mono8")
            info.K = self.faults.get("K", info.K)
            infos.publish(info)
            images.publish(image)
