# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Of operation_tester.py: the region of interest, given and taught, and what rviz is told to show."""
import collections
import os

import numpy
import rospy
import yaml
from geometry_msgs.msg import PointStamped
from planar_bin_picking.msg import RefusedPart
from planar_bin_picking.srv import LocatePart, LocatePartResponse as Status
from std_srvs.srv import Trigger
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit, MarkerArray

UP = 60.0  # s, for the node to come up; machines may be busy
CENTER = (0.06, 0.04, 0.0)  # of the bracket, from its origin, m; to the thickness
# Two fingers, opened by 42 mm for an arm of 32 mm, that reach 6 mm down, and two pins that stand 45 mm beside it on what is there.
FINGERS = [-0.008, -0.03, -0.1, 0.008, -0.021, 0.006, -0.008, 0.021, -0.1, 0.008, 0.03, 0.006]
FOCUS = (0.56, 0.03, 0.07)  # m, in base: before the camera, in the middle of the distances
PINS = [0.0, -0.045, 0.006, -0.05, 0.0, 0.0, 0.045, 0.006, -0.05, 0.0]


def center(part):
    """In the answer's frame."""
    p, q = part.pose.pose.position, part.pose.pose.orientation
    axis, x = numpy.array([q.x, q.y, q.z]), numpy.array(CENTER)
    turned = x + 2.0 * numpy.cross(axis, numpy.cross(axis, x) + q.w * x)
    return numpy.array([p.x, p.y, p.z]) + turned


class RegionCases:
    """Needs of the test case: start, call, comes_true, run_tool, cell, scratch."""

    @classmethod
    def start_region(cls):
        cls.region_file = os.path.join(cls.scratch, "region.yaml")
        cls.region = {"region": [0.40, -0.30, 0.62, 0.30], "region_px": [0, 0, cls.cell.grey.shape[1], 330],
                      "region_frame": "base", "region_file": cls.region_file, "distance_min": 0.78,
                      "distance_max": 0.98}
        cls.start("region", **cls.region)
        bin_ = {"bin_frame": "base", "bin_min": [0.20, -0.35, -0.03], "bin_max": [0.90, 0.35, 0.17]}
        cls.start("fingers", {"tool_boxes": FINGERS, "tool_clearance": 0.001, "tool_edges": 0.0}, **bin_)
        cls.start("pins", {"tool_cylinders": PINS, "tool_edges": 0.0}, **bin_)
        cls.start("wary_pins", {"tool_cylinders": PINS, "tool_edges": 0.002}, **bin_)

    def test_rviz_shows_what_there_is(self):
        answer = self.call("coarse", Status.OK, part="bracket", max_parts=3)
        shown = collections.Counter(m.ns for m in rospy.wait_for_message("coarse/markers", MarkerArray, UP).markers)
        for name in ("solid", "outline", "name", "pick"):
            self.assertEqual(shown[name], 3, name)
        for name in ("refused", "refused_outline", "reason"):
            self.assertEqual(shown[name], len(answer.refused), name)
        scene = rospy.wait_for_message("coarse/scene", MarkerArray, UP).markers
        self.assertLessEqual({"bin", "bin_floor", "camera"}, {m.ns for m in scene})
        self.assertEqual({m.header.frame_id for m in scene if m.ns}, {"base"})
        published = {name for name, _ in rospy.get_published_topics()}
        for locator, focus in (("coarse", (0.56, 0.0, 0.07)), ("no_bin", FOCUS)):
            written = self.run_tool("rviz_cell.py", locator, "--only-write")
            self.assertEqual(written.returncode, 0, written.stderr)
            with open(written.stdout.strip()) as file:
                text = file.read()
            self.assertNotIn("@", text.split("\n", 2)[2])
            rviz = yaml.safe_load(text)["Visualization Manager"]
            self.assertEqual(rviz["Global Options"]["Fixed Frame"], "base")
            focal = rviz["Views"]["Current"]["Focal Point"]
            numpy.testing.assert_allclose([focal["X"], focal["Y"], focal["Z"]], focus, atol=0.01)
            topics = {one[key] for one in rviz["Displays"] for key in ("Marker Topic", "Image Topic", "Update Topic")
                      if key in one}
            self.assertEqual(topics - published, {"/tally"})  # of the cycle demo
            self.assertIn(f"/{locator}/overlay", topics)

    # --- the tool ----------------------------------------------------------------------------------
    def test_fingers_need_room_beside_the_part(self):
        def response_of(locator, part):
            rospy.wait_for_service(locator + "/locate_part", UP)
            return rospy.ServiceProxy(locator + "/locate_part", LocatePart)(part=part)

        def without_room(locator):
            response = response_of(locator, "bracket")
            self.assertIn(response.status, (Status.OK, Status.DEADLOCK), response.message)
            reasons = [refused.reason for refused in response.refused]
            self.assertLessEqual(set(reasons), {RefusedPart.NO_ROOM, RefusedPart.WALL})
            self.assertTrue(all(part.picks for part in response.parts))
            return reasons.count(RefusedPart.NO_ROOM)
        self.assertGreater(without_room("fingers"), 0)
        self.assertTrue(response_of("fingers", "bracket").parts)  # others have room
        bodies = [m for m in rospy.wait_for_message("fingers/markers", MarkerArray, UP).markers if m.ns == "tool_bodies"]
        self.assertTrue(bodies)
        # Turned by a quarter, the fingers would come down on the arm that they are to grip.
        with open(os.path.join(self.parts, "crosswise.yaml"), "w") as file:
            file.write("drawing: bracket.dxf\nthickness_mm: 3\npick_poses:\n  - {name: arm, face: front, "
                       "position_mm: [46, 17, 0], rpy_deg: [180, 0, 90]}\n")
        self.addCleanup(os.remove, os.path.join(self.parts, "crosswise.yaml"))
        self.comes_true(lambda: "crosswise" in self.list_parts("fingers"))
        crosswise = response_of("fingers", "crosswise")
        self.assertEqual(crosswise.parts, [])
        self.assertIn("the part itself", " ".join(r.text for r in crosswise.refused if r.reason == RefusedPart.NO_ROOM))
        self.assertGreater(without_room("wary_pins"), without_room("pins"))

    # --- the region --------------------------------------------------------------------------------
    def test_region(self):
        found = self.call("region", Status.OK, part="bracket")
        self.assertTrue(found.refused)
        self.assertEqual({r.reason for r in found.refused}, {RefusedPart.OUTSIDE})
        texts = " ".join(r.text for r in found.refused)
        self.assertIn("outside of the region in the picture", texts)
        self.assertIn("outside of the region, at", texts)
        self.assertTrue(all(center(part)[0] < 0.625 for part in found.parts))
        whole = self.call("no_bin", Status.OK, part="bracket")
        self.assertTrue(any(center(part)[0] > 0.625 for part in whole.parts))

    def test_region_that_is_taught(self):
        x, y, _ = center(self.call("region", Status.OK, part="bracket").parts[0])
        save, clear = [rospy.ServiceProxy("region/" + name, Trigger) for name in ("save_region", "clear_region")]
        points = rospy.Publisher("clicked_point", PointStamped, queue_size=10)
        self.comes_true(lambda: points.get_num_connections() >= 8)
        self.assertIn("no point", save().message)

        def click(*corners):
            before = self.corners()
            for dx, dy in corners:
                point = PointStamped()
                point.header.frame_id, point.point.x, point.point.y = "base", x + dx, y + dy
                points.publish(point)
            self.comes_true(lambda: self.corners() == before + len(corners))
        click((-0.02, -0.02), (0.04, 0.02), (0.02, -0.02), (-0.02, 0.04))
        crossed = save()
        self.assertFalse(crossed.success)
        self.assertIn("crosses itself", crossed.message)
        self.assertTrue(clear().success)
        self.assertEqual(self.corners(), 0)
        click((-0.02, -0.02), (0.02, -0.02), (0.0, 0.03))
        self.assertGreater(len(self.call("region", Status.OK, part="bracket").parts), 1)  # not in force yet
        saved = save()
        self.assertTrue(saved.success, saved.message)
        self.assertEqual(len(self.call("region", Status.OK, part="bracket").parts), 1)
        self.start("taught", **self.region)
        rospy.wait_for_service("taught/locate_part", UP)
        locate = rospy.ServiceProxy("taught/locate_part", LocatePart)
        self.comes_true(lambda: len(locate(part="bracket").parts) == 1)  # once it hears tf
        self.assertTrue(clear().success)
        self.assertFalse(os.path.exists(self.region_file))
        self.assertGreater(len(self.call("region", Status.OK, part="bracket").parts), 1)
        self.assertIn("region_file", rospy.ServiceProxy("no_bin/save_region", Trigger)().message)

    def test_region_that_is_dragged(self):
        handles = []
        rospy.Subscriber("region/region_handles/update_full", InteractiveMarkerInit, handles.append)
        hand = rospy.Publisher("region/region_handles/feedback", InteractiveMarkerFeedback, queue_size=10)
        self.comes_true(lambda: handles and hand.get_num_connections())

        def corners():
            return [marker.name for marker in rospy.wait_for_message(
                "region/region_handles/update_full", InteractiveMarkerInit, UP).markers]

        def does(event, corner="corner 1", menu=0, place=(0.0, 0.0)):
            feedback = InteractiveMarkerFeedback(client_id="hand", marker_name=corner, event_type=event, menu_entry_id=menu)
            feedback.header.frame_id = "base"
            feedback.pose.position.x, feedback.pose.position.y = place
            feedback.pose.orientation.w = 1.0
            hand.publish(feedback)
        # It begins with the region in force, which stays until somebody saves.
        self.assertEqual(corners(), [f"corner {i}" for i in (1, 2, 3, 4)])
        self.assertEqual([entry.title.split(":")[0].split(",")[0] for entry in handles[0].markers[0].menu_entries],
                         ["a corner more", "delete this corner", "save", "forget the changes"])
        more, less, save, forget = (entry.id for entry in handles[0].markers[0].menu_entries)
        menu = InteractiveMarkerFeedback.MENU_SELECT
        # A click alone changes nothing: there is nothing to save.
        at = handles[0].markers[0].pose.position
        for event in (InteractiveMarkerFeedback.MOUSE_DOWN, InteractiveMarkerFeedback.MOUSE_UP):
            does(event, place=(at.x + 1e-7, at.y))
        does(menu, menu=save)
        does(menu, menu=more)
        self.comes_true(lambda: len(corners()) == 5)
        self.assertFalse(os.path.exists(self.region_file))
        self.assertEqual(self.corners(), 5)
        does(menu, corner="corner 2", menu=less)
        self.comes_true(lambda: len(corners()) == 4)
        does(menu, corner="corner 77", menu=less)  # there is none: nothing happens
        # Its two left corners are dragged to the right, past one of the parts.
        before = sorted(center(part)[0] for part in self.call("region", Status.OK, part="bracket").parts)
        middle = (before[0] + before[1]) / 2.0
        for corner, y in (("corner 1", -0.3), ("corner 4", 0.3)):
            for event in (InteractiveMarkerFeedback.POSE_UPDATE, InteractiveMarkerFeedback.MOUSE_UP):
                does(event, corner=corner, place=(middle, y))
        self.comes_true(lambda: sum(abs(p.x - middle) < 1e-6 for m in self.scene("region_points") for p in m.points) == 2)
        does(InteractiveMarkerFeedback.MOUSE_UP, place=(float("nan"), 0.0))
        self.assertEqual(len(self.call("region", Status.OK, part="bracket").parts), len(before))  # not in force yet
        does(menu, menu=save)
        self.comes_true(lambda: os.path.exists(self.region_file))
        after = [center(part)[0] for part in self.call("region", Status.OK, part="bracket").parts]
        self.assertEqual(len(after), len(before) - 1)
        self.assertEqual(self.corners(), 0)
        does(menu, menu=more)
        self.comes_true(lambda: self.corners() == 5)
        does(menu, menu=forget)
        self.comes_true(lambda: self.corners() == 0)
        self.assertTrue(rospy.ServiceProxy("region/clear_region", Trigger)().success)
        self.assertEqual(len(self.call("region", Status.OK, part="bracket").parts), len(before))

    @staticmethod
    def scene(name):
        return [marker for marker in rospy.wait_for_message("region/scene", MarkerArray, UP).markers if marker.ns == name]

    def corners(self):
        """How many points rviz shows of the region that is being taught."""
        return sum(len(marker.points) for marker in self.scene("region_points"))
