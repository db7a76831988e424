#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The robot server through its sockets, with the example client that robot programmers copy."""
import math
import os
import socket
import subprocess
import sys
import time
import unittest

import cv2
import numpy
import roslib.packages
import rospkg
import rospy
import rostest
from geometry_msgs.msg import TransformStamped
from planar_bin_picking.srv import LocatePart, LocatePartResponse
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

sys.path[:0] = [os.path.join(os.path.dirname(os.path.abspath(__file__)), folder) for folder in ("", "robot_clients")]
import robot_client
from driven_cell import DrivenCell
from robot_client import RobotClient

UP = 60.0  # s, for the nodes to come up; machines may be busy
FLANGE = [500.0, 0.0, 1000.0, 180.0, 0.0, 0.0]  # of play_scene.py, mm and degrees
# Two servers, all of whose parameters differ.
KUKA = {"address": "127.0.0.1", "port": 15711, "clients_max": 2, "convention": "kuka", "locator": "locator",
        "timeout": 20.0, "tool": [0.0, 0.0, 120.0, 90.0, 0.0, 0.0], "approach_mm": 50.0, "retreat_mm": 30.0,
        "base_frame": "base", "flange_frame": "", "numbers": True, "calibrator": "eye", "calibrator_timeout": 2.0}
UR = {"port": 15712, "convention": "ur", "base_frame": "base", "flange_frame": "flange"}
DEAF = {"port": 15713, "locator": "nobody", "timeout": 0.5}


def rigid(position, rotation_vector):
    transform = numpy.eye(4)
    transform[:3, :3] = cv2.Rodrigues(numpy.array(rotation_vector, float))[0]
    transform[:3, 3] = position
    return transform


def matrix(pose):
    q, p = pose.orientation, pose.position
    axis = numpy.array([q.x, q.y, q.z])
    angle = 2.0 * math.atan2(numpy.linalg.norm(axis), q.w)
    return rigid([p.x, p.y, p.z], axis * (angle / max(numpy.linalg.norm(axis), 1e-12)))


def from_kuka(numbers):
    """As the controller's manual defines it: about z, about the new y, about the new x."""
    a, b, c = [math.radians(n) for n in numbers[3:]]
    turn = rigid([0, 0, 0], [0, 0, a]) @ rigid([0, 0, 0], [0, b, 0]) @ rigid([0, 0, 0], [c, 0, 0])
    return rigid([1e-3 * n for n in numbers[:3]], [0, 0, 0]) @ turn


class RobotServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rospkg.RosPack().get_path("planar_bin_picking")
        cls.cell = DrivenCell(os.path.join(cls.folder, "test/data/bin_bracket_00"))
        rospy.set_param("locator/cell", dict(target_frame="base", distance_min=0.78, distance_max=0.98,
                                             parts_folder=os.path.join(cls.folder, "test/ros/parts")))
        cls.processes = [cls.run_node("locator", "locator")]
        for name, server in (("kuka", KUKA), ("ur", UR), ("deaf", DEAF)):
            rospy.set_param(name + "/server", server)
            cls.processes.append(cls.run_node("robot_server", name))
        rospy.wait_for_service("locator/locate_part", UP)
        time.sleep(2.0)  # of tf, which the first call needs

    @staticmethod
    def run_node(program, name):
        return subprocess.Popen([roslib.packages.find_node("planar_bin_picking", program)[0], "__name:=" + name])

    @classmethod
    def tearDownClass(cls):
        for process in cls.processes:
            process.terminate()
        for process in cls.processes:
            process.wait(UP)

    def setUp(self):
        self.cell.good()

    def connect(self, server, numbers=False):
        end = time.monotonic() + UP
        while True:
            self.assertLess(time.monotonic(), end)
            try:
                client = RobotClient("127.0.0.1", server["port"], numbers)
            except ConnectionRefusedError:  # it is still starting
                time.sleep(0.1)
                continue
            self.addCleanup(client.close)
            if client.ask("hello")[0] == robot_client.DONE:
                return client
            time.sleep(0.1)  # a client that went is still being answered

    def test_locate_next_report(self):
        client = self.connect(KUKA, numbers=True)
        self.assertEqual(client.ask("HELLO"), (robot_client.DONE, "planar_bin_picking kuka"))
        self.assertEqual(client.report(True)[0], robot_client.BAD_LINE)
        code, first = client.locate("bracket")
        self.assertEqual(code, robot_client.POSE, first)
        truth = rospy.ServiceProxy("locator/locate_part", LocatePart)(part="bracket")
        self.assertEqual(first.left, len(truth.parts) - 1)
        self.assertEqual((first.part, first.pick), ("bracket", truth.parts[0].picks[0].name))
        self.assertEqual(first.face, ("front", "back")[truth.parts[0].face - 1])
        # The flange, with the tool 120 mm along its z and turned by 90 degrees about it.
        tool = from_kuka(KUKA["tool"])
        pick = matrix(truth.parts[0].picks[0].pose)
        numpy.testing.assert_allclose(from_kuka(first.target) @ tool, pick, atol=2e-4)
        numpy.testing.assert_allclose(from_kuka(first.approach) @ tool,
                                      pick @ rigid([0, 0, -0.05], [0, 0, 0]), atol=2e-4)
        numpy.testing.assert_allclose(from_kuka(first.retreat) @ tool, rigid([0, 0, 0.03], [0, 0, 0]) @ pick, atol=2e-4)
        self.assertEqual(first.numbers, [0, 0])
        code, second = client.next()
        self.assertEqual((code, second.left), (robot_client.POSE, first.left - 1))
        self.assertNotEqual(second.target[:2], first.target[:2])
        code, _ = client.locate("bracket", "front")
        code, third = client.report(False)
        self.assertEqual(code, robot_client.POSE, third)
        self.assertEqual(third.face, "front")
        self.assertEqual(client.report(True)[0], robot_client.DONE)
        self.assertEqual(client.next()[0], robot_client.NOTHING)
        self.assertEqual(client.report(True)[0], robot_client.BAD_LINE)

    def test_ways_and_numbers_of_the_parts_file(self):
        client = self.connect(KUKA, numbers=True)
        code, pose = client.locate("front_only")
        self.assertEqual(code, robot_client.POSE, pose)
        truth = rospy.ServiceProxy("locator/locate_part", LocatePart)(part="front_only").parts[0]
        self.assertEqual((truth.part_number, truth.tool_number), (4, 2))
        self.assertEqual(pose.numbers, [4, 2])
        tool, pick = from_kuka(KUKA["tool"]), truth.picks[0]
        numpy.testing.assert_allclose(matrix(pick.approach), matrix(pick.pose) @ rigid([0, 0, -0.07], [0, 0, 0]),
                                      atol=1e-6)
        numpy.testing.assert_allclose(matrix(pick.retreat), rigid([0, 0, 0.12], [0, 0, 0]) @ matrix(pick.pose),
                                      atol=1e-6)
        numpy.testing.assert_allclose(from_kuka(pose.approach) @ tool, matrix(pick.approach), atol=2e-4)
        numpy.testing.assert_allclose(from_kuka(pose.retreat) @ tool, matrix(pick.retreat), atol=2e-4)

    def test_calibration(self):
        client = self.connect(KUKA)
        self.assertEqual(client.ask("calibrate start"), (robot_client.NO_LOCATOR, "eye/start is not there"))
        self.assertEqual(client.ask("calibrate status")[0], robot_client.NO_LOCATOR)
        called = []

        def serve(name, success):
            def answer(_):
                called.append(name)
                return TriggerResponse(success=success, message=name + " it is")
            return rospy.Service("eye/" + name, Trigger, answer)
        services = [serve(name, name != "verify") for name in ("plan", "start", "next", "abort", "add_sample", "finish",
                                                               "verify")]
        for word in ("plan", "start", "next", "abort", "add", "finish"):
            code, text = client.ask("calibrate " + word)
            self.assertEqual(code, robot_client.DONE, text)
            self.assertTrue(text.startswith(called[-1] + " it is"), text)
        self.assertEqual(client.ask("calibrate verify"), (robot_client.SET_UP, "verify it is"))
        self.assertEqual(called, ["plan", "start", "next", "abort", "add_sample", "finish", "verify"])
        for service in services:
            service.shutdown()
        rospy.Service("eye/finish", Trigger, lambda _: time.sleep(4.0))
        self.assertEqual(client.ask("calibrate finish"), (robot_client.NO_LOCATOR, "eye/finish did not answer in time"))
        status = rospy.Publisher("eye/status", String, queue_size=1, latch=True)
        for text, code in (("running: 3 of 20", robot_client.AGAIN), ("REFUSED: too few", robot_client.SET_UP),
                           ("GOOD: 0.1 mm", robot_client.DONE)):
            status.publish(text)
            end = time.monotonic() + UP
            while client.ask("calibrate status") != (code, text):
                self.assertLess(time.monotonic(), end)
                time.sleep(0.1)
        for line in ("calibrate", "calibrate start start", "calibrate shutdown", "calibrate " + "x" * 900):
            self.assertEqual(client.ask(line)[0], robot_client.BAD_LINE, line)

    def test_a_flange_that_is_none_is_refused(self):
        locate = rospy.ServiceProxy("locator/locate_part", LocatePart)
        flange = TransformStamped()
        flange.header.frame_id = "base"
        self.assertEqual(locate(part="bracket", flange=flange).status, LocatePartResponse.BAD_REQUEST)
        flange.child_frame_id = "flange"
        self.assertEqual(locate(part="bracket", flange=flange).status, LocatePartResponse.BAD_REQUEST)
        flange.transform.rotation.w = 1.0
        flange.transform.translation.x = math.inf
        self.assertEqual(locate(part="bracket", flange=flange).status, LocatePartResponse.BAD_REQUEST)

    def test_says_what_is_wrong(self):
        client = self.connect(KUKA)
        code, text = client.locate("nonesuch")
        self.assertEqual(code, robot_client.SET_UP)
        self.assertIn("nonesuch", text)
        self.assertEqual(client.locate("thick")[0], robot_client.SET_UP)  # it has no pick pose
        self.assertEqual(client.locate("bracket", flange=FLANGE)[0], robot_client.BAD_LINE)  # no flange_frame
        for line in ("", "GET / HTTP/1.1", "locate bracket flange 1 2", "report maybe"):
            self.assertEqual(client.ask(line)[0], robot_client.BAD_LINE, line)
        code, text = self.connect(DEAF).locate("bracket")
        self.assertEqual(code, robot_client.NO_LOCATOR)
        self.assertIn("nobody/locate_part", text)
        self.cell.change(has_images=False)
        self.assertEqual(client.locate("bracket")[0], robot_client.AGAIN)

    def test_bad_clients_harm_nobody(self):
        patient = self.connect(KUKA)
        self.assertEqual(patient.ask("hello")[0], robot_client.DONE)
        for bytes_ in (b"\xff\x00\n" * 50, b"x" * 5000, b"locate bracket\n", b"loc",
                       b"calibrate \xff\n", b"calibrate finish\n", b"calibrate " * 200):
            with socket.create_connection(("127.0.0.1", KUKA["port"])) as vanishing:
                vanishing.sendall(bytes_)
            time.sleep(0.2)
        self.assertEqual(patient.ask("hello")[0], robot_client.DONE)
        self.connect(KUKA)
        with socket.create_connection(("127.0.0.1", KUKA["port"]), 10.0) as third:
            self.assertIn(b"too many", third.recv(100))

    def test_the_flange_comes_with_the_line(self):
        self.cell.change(has_tf=False)
        time.sleep(0.5)
        with socket.create_connection(("127.0.0.1", UR["port"]), 60.0) as ur:
            answers = ur.makefile("r")
            ur.sendall(b"locate bracket\n")
            self.assertEqual(answers.readline(), "(3,0,0,0,0,0,0,0,0)\n")  # nobody says where the robot is
            ur.sendall(b"locate bracket flange 0.5 0 1.0 3.14159265 0 0\n")
            numbers = eval(answers.readline())  # a list of URScript is a tuple of Python
        self.assertEqual(numbers[0], 0)
        self.assertEqual(len(numbers), 9)
        self.cell.change(has_tf=True)
        time.sleep(0.5)
        truth = rospy.ServiceProxy("locator/locate_part", LocatePart)(part="bracket").parts[0].picks[0].pose
        pick = matrix(truth)
        numpy.testing.assert_allclose(rigid(numbers[3:6], numbers[6:9]), pick, atol=1e-3)


if __name__ == "__main__":
    rospy.init_node("robot_server_tester")
    rostest.rosrun("planar_bin_picking", "robot_server", RobotServer, sys.argv)
