# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the testers of the calibrator share: its cell, the calibrators in it, and how a run begins and ends."""
import time
import unittest
import xmlrpc.client

import rosgraph
import rospy
from geometry_msgs.msg import PoseStamped
from planar_bin_picking.srv import MoveRobot, MoveRobotRequest
from std_msgs.msg import Float64, Int32, String
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

WAIT = 20.0  # s
PICTURE_PASSES = 0.25  # s; more than the cell needs from one picture to the next
ENDS = ("GOOD", "POOR", "REFUSED", "ABORTED", "FAILED")
UNCONFIRMED = "stop was not confirmed"


def until(condition, seconds=WAIT):
    deadline = time.monotonic() + seconds
    while not condition() and time.monotonic() < deadline:
        time.sleep(0.01)
    return condition()


class Cell:
    def __init__(self, ns=""):
        self.ns, self.moves, self.stops, self.targets, self.speeds = ns, 0, 0, [], []
        self.place, self.move_times, self.target_times = None, [], []
        rospy.Subscriber(ns + "/moves", Int32, self.count_move)
        rospy.Subscriber(ns + "/stops", Int32, lambda m: setattr(self, "stops", m.data))
        rospy.Subscriber(ns + "/target", PoseStamped, self.take_target)
        rospy.Subscriber(ns + "/speed", Float64, lambda m: self.speeds.append(m.data))
        rospy.Subscriber("/tf", TFMessage, self.take_tf)

    def count_move(self, message):
        self.moves = message.data
        self.move_times.append(time.monotonic())

    def take_target(self, message):
        self.target_times.append(time.monotonic())
        self.targets.append(message)

    def take_tf(self, message):
        for t in message.transforms:
            if t.child_frame_id == "flange":
                self.place = t.transform

    def behave(self, manner):
        rospy.set_param(self.ns + "/calibration_cell/manner", manner)


class Calibrator:
    def __init__(self, name):
        self.name, self.said = name, []
        rospy.Subscriber(name + "/status", String, lambda m: self.said.append(m.data))
        assert until(lambda: self.said), name + " says nothing"

    def call(self, what):
        rospy.wait_for_service(f"{self.name}/{what}", WAIT)
        return rospy.ServiceProxy(f"{self.name}/{what}", Trigger)()

    def start(self):
        self.said.clear()
        answer = self.call("start")
        assert answer.success, answer.message

    def has_ended(self):
        return bool(self.said) and self.said[-1].startswith(ENDS)

    def process(self):
        api = rosgraph.Master("/tester").lookupNode(self.name)
        return xmlrpc.client.ServerProxy(api), xmlrpc.client.ServerProxy(api).getPid("/tester")[2]


class InCell(unittest.TestCase):
    """A cell at /, and in it /calibrator."""
    @classmethod
    def setUpClass(cls):
        cls.cell = Cell()
        cls.calibrator = Calibrator("/calibrator")
        assert until(lambda: cls.cell.place is not None), "no tf"
        cls.start = cls.cell.place

    def setUp(self):
        self.go_to_start()

    def go_to_start(self):
        """The robot stands at the start, with the board in view."""
        self.cell.behave("")
        rospy.wait_for_service("/move_robot", WAIT)
        request = MoveRobotRequest(speed_scale=1.0)
        request.target.header.frame_id = "base"
        request.target.pose.position = self.start.translation
        request.target.pose.orientation = self.start.rotation
        self.assertTrue(rospy.ServiceProxy("/move_robot", MoveRobot)(request).success)

    def tearDown(self):
        self.cell.behave("")
        self.calibrator.call("abort")
        rospy.wait_for_service("/move_robot", WAIT)
        rospy.ServiceProxy("/move_robot", MoveRobot)(MoveRobotRequest())  # stop
        time.sleep(0.1)  # until it has noticed

    def begin(self, manner, calibrator=None):
        """A run with a robot of these manners, once it has been asked for its first move."""
        self.cell.behave(manner)
        asked = len(self.cell.targets)
        (calibrator or self.calibrator).start()
        self.assertTrue(until(lambda: len(self.cell.targets) > asked), "no move was asked for")

    def check_end(self, *words, calibrator=None, seconds=WAIT):
        calibrator = calibrator or self.calibrator
        self.assertTrue(until(calibrator.has_ended, seconds), calibrator.said[-1:])
        for word in words:
            self.assertIn(word, calibrator.said[-1])
        return calibrator.said[-1]

    def check_fault(self, manner, *words, calibrator=None):
        """The first move ends the run, and no other follows."""
        self.go_to_start()
        asked, stops = len(self.cell.targets), self.cell.stops
        self.begin(manner, calibrator)
        self.check_end("FAILED: ", *words, calibrator=calibrator)
        self.assertEqual(len(self.cell.targets), asked + 1)
        return stops

    def check_still(self, seconds=0.6):
        """Nothing moves from now on, nor is anything asked for: a run that went on would look and go within that."""
        time.sleep(0.1)  # for what is under way to the tester
        asked, moves, place = len(self.cell.targets), self.cell.moves, self.cell.place
        time.sleep(seconds)
        self.assertEqual((len(self.cell.targets), self.cell.moves), (asked, moves))
        self.assertEqual(self.cell.place, place)
