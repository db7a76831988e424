#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Teaches pick poses of a part as a person does with rviz: drags interactive markers, chooses from their menus,
and looks at what the part's file says afterwards."""
import copy
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import roslib.packages
import rospkg
import rospy
import rostest
import yaml
from planar_bin_picking.srv import RenamePick
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import InteractiveMarkerControl, InteractiveMarkerFeedback, InteractiveMarkerInit, Marker

UP = 20.0  # s, for anything that is waited for
PART = "/part"  # the part's own marker
BY_HAND = """# an angle bracket
drawing: bracket.dxf  # revision C
thickness_mm: 3.0
pick_poses:
  # for the soft cup
  - {name: elbow, face: front, position_mm: [30, 17, 0], rpy_deg: [180, 0, 0]}  # first
tool_radius_mm: 5
"""


class Teach(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp()
        package = rospkg.RosPack().get_path("planar_bin_picking")
        shutil.copy(os.path.join(package, "test/ros/parts/bracket.dxf"), self.folder)
        with open(self.file(), "w") as file:
            file.write(BY_HAND)
        rospy.set_param("teach/part", "bracket")
        rospy.set_param("teach/parts_folder", self.folder)
        self.markers, self.status, self.seen = {}, "", []
        self.topics = [rospy.Subscriber("teach/poses/update_full", InteractiveMarkerInit, self.take),
                       rospy.Subscriber("teach/status", String, self.take_status)]
        self.feedback = rospy.Publisher("teach/poses/feedback", InteractiveMarkerFeedback, queue_size=10)
        self.process = subprocess.Popen([self.program("teach"), "__name:=teach"])
        self.addCleanup(self.end)
        self.comes_true(lambda: PART in self.markers and self.feedback.get_num_connections() > 0)

    def end(self):
        self.process.terminate()
        self.assertEqual(self.process.wait(UP), 0)
        for topic in self.topics:
            topic.unregister()
        shutil.rmtree(self.folder)

    @staticmethod
    def program(name):
        return roslib.packages.find_node("planar_bin_picking", name)[0]

    def file(self):
        return os.path.join(self.folder, "bracket.yaml")

    def content(self):
        with open(self.file()) as file:
            return file.read()

    def take(self, message):
        self.markers = {marker.name: marker for marker in message.markers}

    def take_status(self, message):
        self.status = message.data
        self.seen.append(message.data)

    def comes_true(self, condition):
        end = time.monotonic() + UP
        while not condition():
            self.assertLess(time.monotonic(), end, f"does not come true; status '{self.status}'")
            time.sleep(0.02)

    def send(self, name, event, **fields):
        message = InteractiveMarkerFeedback(client_id="tester", marker_name=name, event_type=event, **fields)
        message.header.frame_id = "taught_part"
        self.feedback.publish(message)

    def choose(self, name, title, words, **fields):
        """From a marker's menu, and waits for what is said then."""
        self.comes_true(lambda: name in self.markers)  # what is said may come before what is shown
        entry, = [entry.id for entry in self.markers[name].menu_entries if entry.title == title]
        self.status = ""
        self.send(name, InteractiveMarkerFeedback.MENU_SELECT, menu_entry_id=entry, pose=self.markers[name].pose,
                  **fields)
        self.comes_true(lambda: words in self.status)

    def drag(self, name, words="is moved", roll=None, **position):
        pose = copy.deepcopy(self.markers[name].pose)
        for axis, value in position.items():
            setattr(pose.position, axis, value)
        if roll is not None:
            o = pose.orientation
            o.x, o.y, o.z, o.w = math.sin(roll / 2), 0.0, 0.0, math.cos(roll / 2)
        self.status = ""
        for event in (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.POSE_UPDATE,
                      InteractiveMarkerFeedback.MOUSE_UP):
            self.send(name, event, pose=pose)
        self.comes_true(lambda: words in self.status)

    def drawn(self, name, kind):
        """Markers of that type within an interactive marker."""
        return [marker for control in self.markers[name].controls for marker in control.markers if marker.type == kind]

    def assert_fault(self, name, words=""):
        """The pose is red and the part's marker says why; or neither."""
        self.comes_true(lambda: name in self.markers)

        def is_so():
            color = self.drawn(name, Marker.CYLINDER)[0].color
            said = " ".join(" ".join(text.text.split()) for text in self.drawn(PART, Marker.TEXT_VIEW_FACING))
            is_red = color.r > 0.9 and color.g < 0.2
            return is_red == bool(words) and (words in said if words else f"{name}: its" not in said)
        self.comes_true(is_so)

    def saved(self):
        """The poses as the locator's reader has them: (names, warnings)."""
        said = subprocess.run([self.program("describe_part"), self.file()], capture_output=True, text=True, timeout=UP)
        self.assertEqual(said.returncode, 0, said.stderr)
        summary = yaml.safe_load(said.stdout)
        return summary["pick_poses"], summary["warnings"]

    def test_rviz_looks_at_the_part(self):
        said = subprocess.run([self.program("rviz_cell.py"), "teach", "--teach", "--only-write"], capture_output=True,
                              text=True, timeout=UP)
        self.assertEqual(said.returncode, 0, said.stderr)
        with open(said.stdout.strip()) as file:
            text = file.read()
        self.assertNotIn("@", text.split("\n", 1)[1])
        rviz = yaml.safe_load(text)["Visualization Manager"]
        view = rviz["Views"]["Current"]
        self.assertAlmostEqual(view["Focal Point"]["X"], 0.06, delta=0.02)
        self.assertAlmostEqual(view["Distance"], 0.28, delta=0.05)  # for 120 x 80 mm
        topics = {display["Update Topic"] for display in rviz["Displays"] if "Update Topic" in display}
        self.assertLessEqual(topics, {name for name, _ in rospy.get_published_topics()})

    def test_poses_are_taught_and_saved(self):
        self.assertEqual(set(self.markers), {PART, "elbow"})
        self.assertTrue(self.drawn(PART, Marker.TRIANGLE_LIST)[0].points)  # the face
        self.assertEqual(len(self.drawn(PART, Marker.LINE_LIST)), 2)  # outline, holes
        modes = {control.interaction_mode for control in self.markers["elbow"].controls}
        self.assertLessEqual({InteractiveMarkerControl.MOVE_PLANE, InteractiveMarkerControl.MOVE_AXIS,
                              InteractiveMarkerControl.ROTATE_AXIS}, modes)
        self.assert_fault("elbow")
        self.drag("elbow", x=0.5)
        self.assert_fault("elbow", "outside of the part's outline")
        self.choose("elbow", "snap to the nearest hole", "elbow: snap")
        self.assert_fault("elbow", "over a hole")
        self.drag("elbow", x=0.046, y=0.017)
        self.assert_fault("elbow")
        clicked = InteractiveMarkerFeedback().mouse_point
        clicked.x, clicked.y = 0.017, 0.04
        self.choose(PART, "add a pick pose here, back", "back is new", mouse_point=clicked, mouse_point_valid=True)
        self.assert_fault("back")
        self.assertAlmostEqual(self.markers["back"].pose.position.z, -0.003)
        self.choose(PART, "add a pick pose here, front", "front is new")
        self.choose("front", "to the other face", "front: to")
        self.choose("front", "delete", "front is deleted")
        self.comes_true(lambda: "front" not in self.markers)
        self.choose("back", "turn by 90 degrees", "back: turn")
        # A click alone is no move.
        self.seen.clear()
        for event in (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.POSE_UPDATE,
                      InteractiveMarkerFeedback.MOUSE_UP):
            self.send("back", event, pose=self.markers["back"].pose)
        self.choose("back", "rename", "rosservice call /teach/rename \"{name: back, new_name: NEW}\"")
        self.assertNotIn("back is moved", self.seen)
        self.assertEqual(self.content(), BY_HAND)
        self.choose(PART, "save", "2 pick poses written")
        expected = BY_HAND.replace("[30, 17, 0]", "[46, 17, 0]").replace(
            "# first\n", "# first\n  - {name: back, face: back, position_mm: [17, 40, -3], rpy_deg: [0, 0, 90]}\n")
        self.assertEqual(self.content(), expected)
        self.assertEqual(self.saved(), (["elbow", "back"], []))
        self.choose("back", "earlier: the robot prefers it", "the order is back, elbow")
        self.choose("back", "earlier: the robot prefers it", "is the first already")
        rename = rospy.ServiceProxy("teach/rename", RenamePick)
        for name, new_name, words in (("back", "under side", "a word without"), ("back", "elbow", "already")):
            refused = rename(name=name, new_name=new_name)
            self.assertFalse(refused.success)
            self.assertIn(words, refused.message)
        self.assertTrue(rename(name="elbow", new_name="web").success)
        self.comes_true(lambda: set(self.markers) == {PART, "back", "web"})
        self.choose(PART, "save", "2 pick poses written")
        self.assertEqual(self.saved(), (["back", "web"], []))
        self.assertIn("# for the soft cup", self.content())

    def test_what_would_send_the_tool_the_wrong_way_is_not_saved(self):
        save = rospy.ServiceProxy("teach/save", Trigger)
        self.drag("elbow", roll=0.0)
        self.assert_fault("elbow", "does not point into the part")
        refused = save()
        self.assertFalse(refused.success)
        self.assertIn("elbow", refused.message)
        self.assertEqual(self.content(), BY_HAND)
        self.choose("elbow", "snap to the face's normal", "elbow: snap")
        self.choose("elbow", "snap to the centroid", "elbow: snap")
        self.comes_true(lambda: self.markers["elbow"].pose.position.y > 0.02)  # of both arms
        self.choose(PART, "forget the changes, read the file anew", "the file's")
        self.assertTrue(save().success)
        self.assertEqual(self.content(), BY_HAND)
        # Nothing that comes in ends the node.
        self.drag("elbow", "not in the frame", x=float("nan"))
        self.send("nobody", InteractiveMarkerFeedback.MOUSE_UP)
        self.assertTrue(save().success)
        with open(self.file(), "a") as file:
            file.write("pick_poses: []\n")
        broken = save()
        self.assertFalse(broken.success)
        self.assertIn("twice", broken.message)


if __name__ == "__main__":
    rospy.init_node("teach_tester")
    rostest.rosrun("planar_bin_picking", "teach_tester", Teach, sys.argv)
