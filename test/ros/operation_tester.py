#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""One locator that runs on while its bin empties and its parts come and go."""
import collections
import os
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from xmlrpc.client import ServerProxy

import numpy
import rosgraph
import roslib.packages
import rospkg
import rospy
import rostest
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from planar_bin_picking.srv import ListParts, LocatePart, LocatePartRequest, LocatePartResponse, ReportPick
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Image
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from visualization_msgs.msg import Marker, MarkerArray

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
from check_cell_cases import CheckCellCases
from driven_cell import DrivenCell
from operation_region import RegionCases, center
from tuning_cases import TuningCases

UP = 60.0  # s, for the node to come up; machines may be busy
Status = LocatePartResponse
BIN = {"bin_frame": "base", "bin_min": [0.46, -0.11, -0.03], "bin_max": [0.66, 0.11, 0.17]}

NEAR = {"order_near": 1000.0, "near_x": 0.3, "near_y": 0.3, "near_z": 0.1}


def floor(plates):
    """A grainy floor all over the view, and dark plates on it."""
    def spoil(image, _info):
        grey = numpy.full((image.height, image.width), 120.0)
        for x, y in plates:
            grey[y:y + 30, x:x + 50] = 60.0
        grey += numpy.random.default_rng(1).normal(0.0, 3.0, grey.shape)
        image.data = grey.astype(numpy.uint8).tobytes()
    return spoil


class Operation(TuningCases, CheckCellCases, RegionCases, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = rospkg.RosPack().get_path("planar_bin_picking")
        cls.cell = DrivenCell(os.path.join(cls.folder, "test/data/bin_bracket_00"))
        cls.scratch = tempfile.mkdtemp()
        cls.parts = os.path.join(cls.scratch, "parts")
        shutil.copytree(os.path.join(cls.folder, "test/ros/parts"), cls.parts)
        cls.processes = []
        cls.cell_file = os.path.join(cls.scratch, "cell.yaml")
        with open(cls.cell_file, "w") as file:
            file.write("target_frame: base  # of the robot\n")
        snapshots = {"snapshot_folder": os.path.join(cls.scratch, "snapshots"), "snapshots_max": 3,
                     "snapshots_mb": 100.0, "snapshot_failures": 2, "archive_folder": os.path.join(cls.scratch, "archive"),
                     "archive_mb": 4.0, "archive_hours": 1.0}
        cls.start("op", **{"cell_file": cls.cell_file}, **snapshots, **BIN)
        cls.start("coarse", {"order_walls": 1000.0}, **{"empty_mark": 0.5, "parts_poll": 0.0}, **BIN)
        cls.start("no_bin", NEAR, distance_min=0.78, distance_max=0.98,
                  hand_eye_file=cls.poor_calibration())
        cls.start_region()
        cls.start("highest", {"order_height": 1000.0}, distance_min=0.78, distance_max=0.98)
        time.sleep(2.0)  # of tf, which the first call needs

    @classmethod
    def poor_calibration(cls):
        path = os.path.join(cls.scratch, "hand_eye.yaml")
        shutil.copy(os.path.join(cls.folder, "test/ros/calibration/hand_eye.yaml"), path)
        with open(path, "a") as file:
            file.write("verdict: POOR\n")
        return path

    @classmethod
    def tearDownClass(cls):
        for process in cls.processes:
            process.terminate()
        for process in cls.processes:
            process.wait(UP)
        shutil.rmtree(cls.scratch)

    @classmethod
    def start(cls, name, pick=None, **cell):
        rospy.set_param(name + "/pick", pick or {"failures_max": 2})
        # The camera stands still, and so may tf on a machine that is busy with other tests.
        rospy.set_param(name + "/cell", dict({"tf_gap_max": 2.0}, target_frame="base", parts_folder=cls.parts, **cell))
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

    # --- parts -------------------------------------------------------------------------------------
    def list_parts(self, locator="op"):
        rospy.wait_for_service(locator + "/list_parts", UP)
        response = rospy.ServiceProxy(locator + "/list_parts", ListParts)()
        return {part.name: part for part in response.parts}

    def comes_true(self, condition, seconds=20.0):
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, "does not come true")
            time.sleep(0.1)

    def file(self, name):
        return os.path.join(self.parts, name)

    def test_parts_come_change_and_go(self):
        first = self.list_parts()
        self.assertTrue(first["bracket"].available)
        self.assertIn("120.0 x 80.0 mm, 3 holes", first["bracket"].text)
        self.assertEqual(first["bracket"].pick_poses, ["elbow", "elbow_back"])
        self.assertGreater(first["bracket"].read_at, rospy.Time.now() - rospy.Duration(300.0))
        self.assertFalse(first["torn"].available)
        self.assertIn("EOF", first["torn"].text)
        self.assertIn("INSUNITS", " ".join(first["tiny"].warnings))
        self.call("op", Status.UNKNOWN_PART, "no part 'late'", part="late")
        with open(self.file("late.yaml"), "w") as file:
            file.write("drawing: bracket.dxf\npick_poses:\n  - {name: arm, face: front, position_mm: [46, 17, 0], "
                       "rpy_deg: [180, 0, 0]}\n")
        self.comes_true(lambda: "late" in self.list_parts())
        self.assert_picture("late")
        located = self.call("op", Status.OK, part="late")
        self.assertEqual({pick.name for part in located.parts for pick in part.picks}, {"arm"})
        with open(self.file("late.yaml"), "w") as file:
            file.write("drawing: bracket.dxf\nthickness: 3\n")  # no such key
        self.comes_true(lambda: not self.list_parts()["late"].available)
        self.call("op", Status.UNKNOWN_PART, "thickness", part="late")
        self.assertEqual(self.list_parts()["bracket"].read_at, first["bracket"].read_at)
        os.remove(self.file("late.yaml"))
        self.comes_true(lambda: "late" not in self.list_parts())
        self.comes_true(lambda: "/op/part_pictures/late" not in self.topics())

    @staticmethod
    def topics():
        return {name for name, _ in rospy.get_published_topics()}

    def assert_picture(self, part):
        """Both faces side by side, and below them what is written about the part."""
        picture = rospy.wait_for_message("op/part_pictures/" + part, Image, UP)
        self.assertEqual((picture.encoding, picture.header.frame_id), ("bgr8", part))
        pixels = numpy.frombuffer(picture.data, numpy.uint8).reshape(picture.height, picture.width, 3)
        front, back = pixels[:600, :picture.width // 2], pixels[:600, picture.width // 2:]
        for face in (front, back):
            self.assertLess((face == 255).all(axis=2).mean(), 0.9)  # not only paper
        self.assertTrue((front != back).any())

    def test_parts_are_read_only_on_request_where_the_cell_says_so(self):
        self.list_parts("coarse")
        shutil.copy(self.file("bracket.dxf"), self.file("asked_for.dxf"))
        self.comes_true(lambda: "asked_for" in self.list_parts("op"))
        self.assertNotIn("asked_for", self.list_parts("coarse"))
        reload_parts = rospy.ServiceProxy("coarse/reload_parts", Trigger)
        answer = reload_parts()
        self.assertFalse(answer.success)  # torn.dxf
        self.assertIn("torn", answer.message)
        self.assertIn("asked_for", self.list_parts("coarse"))
        os.remove(self.file("asked_for.dxf"))

    def test_several_parts_in_one_call(self):
        wish = LocatePartRequest(parts=["bracket", "thick"])
        both = self.call("op", Status.OK, part=wish.part, parts=wish.parts)
        self.assertLessEqual({part.part for part in both.parts}, {"bracket", "thick"})
        self.call("op", Status.UNKNOWN_PART, "nonesuch", part="bracket", parts=["nonesuch"])

    # --- snapshots ---------------------------------------------------------------------------------
    def snapshots(self):
        folder = os.path.join(self.scratch, "snapshots")
        return sorted(os.path.join(folder, name) for name in os.listdir(folder) if not name.endswith(".partial"))

    def of(self, reason):
        return [path for path in self.snapshots() if path.endswith(reason)]

    def run_tool(self, *command):
        program = roslib.packages.find_node("planar_bin_picking", command[0])[0]
        return subprocess.run([program, *command[1:]], capture_output=True, text=True, timeout=UP)

    def assert_floor_is_the_bins(self, folder):
        """The bin has the base's axes: up is the base's z, as the camera sees it."""
        with open(os.path.join(folder, "request.yaml")) as file:
            up = yaml.safe_load(file)["floor_normal"]
        with open(os.path.join(folder, "transform.txt")) as file:
            rotation = yaml.safe_load(file)["rotation"]
        x, y, z, w = (rotation[axis] for axis in "xyzw")
        row = [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]  # of base from camera
        numpy.testing.assert_allclose(up, row, atol=1e-5)

    def test_snapshots_give_the_same_answer(self):
        save = rospy.ServiceProxy("op/save_snapshot", Trigger)
        answer = self.call("op", Status.OK, part="bracket", face=LocatePartRequest.FRONT)
        saved = save()
        self.assertTrue(saved.success, saved.message)
        folder = saved.message
        for name in ("image.pgm", "camera_info.yaml", "locator.yaml", "request.yaml", "result.yaml", "parts/bracket.dxf",
                     "parts/bracket.yaml", "ros_request.txt", "ros_answer.txt", "ros_camera_info.txt",
                     "transform.txt", "settings.txt"):
            self.assertTrue(os.path.getsize(os.path.join(folder, name)) > 0, name)
        self.assert_floor_is_the_bins(folder)
        replay = self.run_tool("replay_snapshot", folder)
        self.assertEqual(replay.returncode, 0, replay.stdout + replay.stderr)
        self.assertIn("the same", replay.stdout)
        located = self.run_tool("locate_image", "--snapshot", folder)
        self.assertEqual(located.returncode, 0, located.stderr)
        with open(os.path.join(folder, "result.yaml")) as file:
            found = yaml.safe_load(file)
        self.assertGreaterEqual(len(found["detections"]), len(answer.parts))
        self.assertEqual(located.stdout.count("bracket"), len(found["detections"]))
        self.assertEqual({one["face"] for one in found["detections"]}, {"front"})
        mixed = self.run_tool("locate_image", "--snapshot", folder, "--distance-min", "0.5")
        self.assertEqual(mixed.returncode, 2)
        with open(os.path.join(folder, "result.yaml"), "a") as file:
            file.write("# changed\n")
        self.assertEqual(self.run_tool("replay_snapshot", folder).returncode, 1)
        os.remove(os.path.join(folder, "image.pgm"))
        self.assertEqual(self.run_tool("replay_snapshot", folder).returncode, 2)
        unset = rospy.ServiceProxy("no_bin/save_snapshot", Trigger)()
        self.assertFalse(unset.success)
        self.assertIn("snapshot_folder", unset.message)

    def test_every_call_is_kept_within_the_quota(self):
        folder = os.path.join(self.scratch, "archive")
        for _ in range(4):  # of 1.25 MB each
            self.call("op", Status.OK, part="bracket", max_parts=1)
        self.comes_true(lambda: 2 <= len(os.listdir(folder)) <= 3)
        latest = sorted(name for name in os.listdir(folder) if not name.endswith(".partial"))[-1]
        self.assertTrue(latest.endswith("_CALL"), latest)
        self.assertEqual(self.run_tool("replay_snapshot", os.path.join(folder, latest)).returncode, 0)

    def test_what_goes_wrong_is_saved(self):
        rows, columns = self.cell.grey.shape
        self.cell.change(spoil=floor([(columns // 2, rows // 2)]))
        self.call("op", Status.NO_PART_FOUND, part="bracket")
        self.comes_true(lambda: self.of("NO_PART_FOUND"))
        self.cell.good()
        for _ in range(2):  # snapshot_failures
            part = self.call("op", Status.OK, part="bracket", max_parts=1).parts[0]
            report = rospy.ServiceProxy("op/report_pick", ReportPick)
            report(stamp=part.header.stamp, child_frame=part.child_frame, success=False)
        self.comes_true(lambda: self.of("FAILED_PICKS"))
        self.assertEqual(self.run_tool("replay_snapshot", self.of("FAILED_PICKS")[0]).returncode, 0)
        for _ in range(4):  # no more than snapshots_max
            self.assertTrue(rospy.ServiceProxy("op/save_snapshot", Trigger)().success)
        self.assertEqual(len(self.snapshots()), 3)

    # --- what an operator looks at -----------------------------------------------------------------
    def diagnostics(self, locator):
        """{task: status} of the next message of that locator, among those of all others."""
        found = queue.Queue()

        def take(message):
            tasks = {status.name.split(": ")[-1]: status for status in message.status
                     if status.name.startswith(locator + ":")}  # without a slash
            if tasks:
                found.put(tasks)
        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, take)
        try:
            return found.get(timeout=UP)
        except queue.Empty:
            self.fail("no diagnostics of " + locator)
        finally:
            subscriber.unregister()

    def test_diagnostics_and_parameters(self):
        self.call("op", Status.OK, part="bracket", max_parts=1)
        self.comes_true(lambda: self.diagnostics("op")["calls"].message.startswith("OK: 1 located"))
        found = self.diagnostics("op")
        self.assertEqual(found["camera"].level, DiagnosticStatus.OK)
        values = {task: {pair.key: pair.value for pair in found[task].values} for task in found}
        self.assertAlmostEqual(float(values["camera"]["rate in Hz"]), 5.0, delta=2.5)
        self.assertEqual(values["calls"]["offered"], "1")
        self.assertGreaterEqual(int(values["calls"]["refused, BEYOND_MAX_PARTS"]), 1)
        self.assertGreater(int(values["calls"]["found"]), 1)
        margin = float(values["calls"]["score of the first"]) - 0.4  # score/threshold
        self.assertAlmostEqual(float(values["calls"]["score margin"]), margin, places=3)
        self.assertEqual(values["calls"]["deadlocks in a row"], "0")
        self.assertEqual(values["calls"]["calls under way"], "0")
        self.assertEqual(values["camera"]["frame"], "camera")
        self.assertEqual(values["calibration"]["hand_eye_file"], "not named in the cell's file")
        first = rospy.wait_for_message("op/heartbeat", Header, UP)
        self.assertGreater(rospy.wait_for_message("op/heartbeat", Header, UP).stamp, first.stamp)
        poor = self.diagnostics("no_bin")["calibration"]
        self.assertEqual((poor.level, poor.message), (DiagnosticStatus.WARN, "hand_eye_file is POOR"))
        self.assertLess(float({pair.key: pair.value for pair in poor.values}["hand_eye_file, age in days"]), 1.0)
        self.cell.change(spoil=lambda _image, info: setattr(info, "K", [0.0] * 9))
        self.comes_true(lambda: "calibrat" in self.diagnostics("op")["camera"].message)
        self.assertEqual(found["parts"].level, DiagnosticStatus.WARN)
        self.assertIn("torn", found["parts"].message)
        for words, values in (("0.250 s newer", dict(info_lead=0.25)), ("stamp of zero", dict(zero_stamps=True)),
                              ("stopped", dict(has_info=False)), ("no image comes", dict(has_images=False))):
            self.cell.good()
            self.comes_true(lambda: self.diagnostics("op")["camera"].level == DiagnosticStatus.OK)
            self.cell.change(**values)
            self.comes_true(lambda: words in self.diagnostics("op")["camera"].message)
            self.assertEqual(self.diagnostics("op")["camera"].level, DiagnosticStatus.ERROR, words)
            if words == "stopped":  # so many seconds ago; once a minute in the log all the same
                by_node = collections.Counter()
                log = rospy.Subscriber("/rosout", Log,
                                       lambda line: by_node.update([line.name] if words in line.msg else []))
                time.sleep(4.0)
                log.unregister()
                self.assertLessEqual(max(by_node.values(), default=0), 1, by_node)
        parameters = rospy.ServiceProxy("coarse/parameters", Trigger)()
        self.assertTrue(parameters.success)
        for line in ("empty_mark: 0.5", "hough/yaw_step_deg: 5", "failures_max: 2"):
            self.assertIn(line, parameters.message)

    # --- the order ---------------------------------------------------------------------------------
    def assert_rising(self, values):
        self.assertGreater(len(values), 2)
        for before, after in zip(values, values[1:]):
            self.assertLess(before, after + 0.004)  # the face's middle lies up to a thickness off

    def test_parts_are_offered_in_the_order_that_the_cell_wants(self):
        point = numpy.array([NEAR["near_x"], NEAR["near_y"], NEAR["near_z"]])
        near = self.call("no_bin", Status.OK, part="bracket").parts
        self.assert_rising([numpy.linalg.norm(center(part) - point) for part in near])
        high = self.call("highest", Status.OK, part="bracket").parts
        self.assert_rising([-center(part)[2] for part in high])
        self.assertNotEqual([round(center(part)[0], 3) for part in near], [round(center(part)[0], 3) for part in high])
        inner = self.call("coarse", Status.OK, part="bracket").parts
        (x0, y0, _), (x1, y1, _) = BIN["bin_min"], BIN["bin_max"]
        self.assert_rising([-min(x - x0, x1 - x, y - y0, y1 - y, 0.1) for x, y, _ in map(center, inner)])

    def test_rviz_shows_nothing_old(self):
        def markers():
            return rospy.wait_for_message("op/markers", MarkerArray, UP).markers
        self.call("op", Status.OK, part="bracket")
        self.assertGreater(len(markers()), 2)
        self.cell.change(has_images=False)
        self.call("op", Status.NO_IMAGE, part="bracket", timeout=rospy.Duration(0.2))
        self.comes_true(lambda: [marker.action for marker in markers()] == [Marker.DELETEALL])
        self.cell.good()
        self.call("op", Status.OK, part="bracket")
        self.cell.change(spoil=floor([]))
        self.call("op", Status.EMPTY, part="bracket")
        self.assertEqual([marker.action for marker in markers()], [Marker.DELETEALL])

    def test_it_comes_back_after_it_has_died(self):
        launch = subprocess.Popen(["roslaunch", "planar_bin_picking", "cell.launch", "name:=phoenix", "respawn:=true",
                                   "parts:=" + self.parts], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.processes.append(launch)
        self.list_parts("phoenix")
        master = rosgraph.Master("/operation_tester")
        first = master.lookupNode("/phoenix")
        os.kill(ServerProxy(first).getPid("/operation_tester")[2], signal.SIGKILL)
        self.comes_true(lambda: master.lookupNode("/phoenix") != first)
        self.call("phoenix", Status.OK, part="bracket")

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
