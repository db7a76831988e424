#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""One locator that runs on while its bin empties and its parts come and go."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy
import roslib.packages
import rospkg
import rospy
import rostest
from planar_bin_picking.srv import LocatePart, LocatePartResponse

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
from driven_cell import DrivenCell

UP = 60.0  # s, for the node to come up; machines may be busy
Status = LocatePartResponse
BIN = {"bin_frame": "base", "bin_min": [0.46, -0.11, -0.03], "bin_max": [0.66, 0.11, 0.17]}


def floor(plates):
    """A grainy floor all over the view, and dark plates on it."""
    def spoil(image, _info):
        grey = numpy.full((image.height, image.width), 120.0)
        for x, y in plates:
            grey[y:y + 30, x:x + 50] = 60.0
        grey += numpy.random.default_rng(1).normal(0.0, 3.0, grey.shape)
        image.data = grey.astype(numpy.uint8).tobytes()
    return spoil


class Operation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rospkg.RosPack().get_path("planar_bin_picking")
        cls.cell = DrivenCell(os.path.join(cls.folder, "test/data/bin_bracket_00"))
        cls.scratch = tempfile.mkdtemp()
        cls.parts = os.path.join(cls.scratch, "parts")
        shutil.copytree(os.path.join(cls.folder, "test/ros/parts"), cls.parts)
        cls.processes = []
        cls.start("op", **BIN)
        cls.start("coarse", **{"empty_mark": 0.5}, **BIN)
        cls.start("no_bin", distance_min=0.78, distance_max=0.98)

    @classmethod
    def tearDownClass(cls):
        for process in cls.processes:
            process.terminate()
        for process in cls.processes:
            process.wait(UP)
        shutil.rmtree(cls.scratch)

    @classmethod
    def start(cls, name, **cell):
        rospy.set_param(name + "/cell", dict(target_frame="base", parts_folder=cls.parts, **cell))
        program = roslib.packages.find_node("planar_bin_picking", "locator")[0]
        cls.processes.append(subprocess.Popen([program, "__name:=" + name]))

    def setUp(self):
        self.cell.good()

    def call(self, locator, status, words="", **fields):
        rospy.wait_for_service(locator + "/locate_part", UP)
        fields.setdefault("timeout", rospy.Duration(30.0))
        response = rospy.ServiceProxy(locator + "/locate_part", LocatePart)(**fields)
        self.assertEqual(response.status, status, response.message)
        self.assertIn(words, response.message)
        return response

    # --- the bin -----------------------------------------------------------------------------------
    def test_an_empty_bin_is_told_from_one_of_other_parts(self):
        full = self.call("op", Status.OK, part="bracket")
        self.assertGreater(full.filling, 0.3)
        self.cell.change(spoil=floor([]))
        empty = self.call("op", Status.EMPTY, "empty", part="bracket")
        self.assertLess(empty.filling, 0.01)
        self.assertEqual(empty.parts + empty.refused, [])
        unknown = self.call("no_bin", Status.NO_PART_FOUND, "bin_frame", part="bracket")
        self.assertEqual(unknown.filling, -1.0)
        rows, columns = self.cell.grey.shape
        self.cell.change(spoil=floor([(columns // 2 + dx, rows // 2) for dx in (-60, 20)]))
        others = self.call("op", Status.NO_PART_FOUND, "lies on the bin's floor", part="bracket")
        self.assertGreater(others.filling, empty.filling + 0.01)
        # 0.5 m: whatever is shorter belongs to the floor.
        self.call("coarse", Status.EMPTY, part="bracket")
        self.cell.change(spoil=lambda image, _info: setattr(image, "data", bytes(len(image.data))))
        self.call("op", Status.NO_PART_FOUND, "too dark", part="bracket")
        self.cell.change(has_images=False)
        blind = self.call("op", Status.NO_IMAGE, part="bracket", timeout=rospy.Duration(0.2))
        self.assertEqual(blind.filling, -1.0)


if __name__ == "__main__":
    rospy.init_node("operation_tester")
    rostest.rosrun("planar_bin_picking", "operation", Operation, sys.argv)
