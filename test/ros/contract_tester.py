#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Each field of LocatePart and ReportPick, each status, each refusal reason, and each key of cell.yaml,
pick.yaml and the part's file that reaches the service: changed, it changes the answer as documented. The
locators of contract.test look through the camera of a DrivenCell. (refusals.test has the rest of the
statuses, with locators that lack something from the start.)"""
import math
import os
import statistics
import sys
import threading
import time
import unittest

import rospy
import rospkg
import rostest
import tf2_ros
from planar_bin_picking.msg import LocatedPart, LocatedParts, RefusedPart
from planar_bin_picking.srv import (LocatePart, LocatePartRequest, LocatePartResponse, ReportPick,
                                    ReportPickResponse)
from std_srvs.srv import TriggerResponse

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # not catkin's relay of it
from driven_cell import DrivenCell, in_sixteen_bits

UP = 120.0  # s, for the nodes to come up; machines may be busy
Status = LocatePartResponse


def place(located):
    return located.pose.pose.position


def distance(a, b):
    a, b = place(a), place(b)
    return math.sqrt((a.x - b.x) ** 2 + (a.y - b.y) ** 2 + (a.z - b.z) ** 2)


def reasons(response):
    return [refused.reason for refused in response.refused]


class Contract(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = rospkg.RosPack().get_path("planar_bin_picking")
        cls.cell = DrivenCell(os.path.join(folder, "test/data/bin_bracket_00"))
        cls.buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.buffer)

    def setUp(self):
        self.cell.good()

    def call(self, locator, **fields):
        name = locator + "/locate_part"
        rospy.wait_for_service(name, UP)
        fields.setdefault("timeout", rospy.Duration(30.0))
        return rospy.ServiceProxy(name, LocatePart)(**fields)

    def locate(self, locator, **fields):
        """The parts that are offered."""
        response = self.call(locator, **fields)
        self.assertEqual(response.status, Status.OK, response.message)
        self.assertGreater(len(response.parts), 0)
        return response

    def refuse(self, locator, status, words, **fields):
        response = self.call(locator, **fields)
        self.assertEqual(response.status, status, response.message)
        self.assertIn(words, response.message)
        self.assertEqual(response.parts, [])
        return response

    def report(self, locator, part, success):
        return rospy.ServiceProxy(locator + "/report_pick", ReportPick)(
            stamp=part.header.stamp, child_frame=part.child_frame, success=success)

    def stands(self, frame, stamp=rospy.Time(0), seconds=5.0, expected=True):
        """Whether tf comes to agree that the frame does (or does not) stand in base."""
        end = time.monotonic() + seconds
        while self.buffer.can_transform("base", frame, stamp) != expected:
            if time.monotonic() > end:
                return not expected
            time.sleep(0.02)
        return expected

    # --- the request -------------------------------------------------------------------------------
    def test_face(self):
        both = self.locate("locator", part="bracket")
        self.assertEqual({part.face for part in both.parts}, {LocatedPart.FRONT, LocatedPart.BACK})
        self.assertEqual(both.refused, [])
        for face, answered in ((LocatePartRequest.FRONT, LocatedPart.FRONT),
                               (LocatePartRequest.BACK, LocatedPart.BACK)):
            one = self.locate("locator", part="bracket", face=face)
            self.assertEqual({part.face for part in one.parts}, {answered})
            self.assertEqual(set(reasons(one)), {RefusedPart.WRONG_FACE})
            self.assertEqual(len(one.parts) + len(one.refused), len(both.parts))
            for part in one.parts:  # face and the sign of the pose's z agree; base's z is up
                q = part.pose.pose.orientation
                up = 1.0 - 2.0 * (q.x ** 2 + q.y ** 2)
                self.assertEqual(up > 0.0, answered == LocatedPart.FRONT)
        self.refuse("locator", Status.BAD_REQUEST, "face is 3", face=3)

    def test_part(self):
        one = self.locate("locator", part="bracket")
        self.assertEqual({part.part for part in one.parts}, {"bracket"})
        self.refuse("locator", Status.UNKNOWN_PART, "there is", part="nonesuch")
        everything = self.locate("locator", part="", max_parts=2)
        self.assertIn("not looked for: part tiny", everything.message)
        self.assertLessEqual({part.part for part in everything.parts},
                             {"bracket", "front_only", "own_tool", "thick"})

    def test_part_size(self):
        response = self.refuse("locator", Status.BAD_PART_SIZE, "tiny", part="tiny")
        self.assertIn("4.4", response.message)

    def test_max_parts_cuts_what_can_be_offered(self):
        everything = self.locate("locator", part="bracket")
        first = everything.parts[0]
        two = self.locate("locator", part="bracket", max_parts=2)
        self.assertEqual(len(two.parts), 2)
        self.assertEqual(set(reasons(two)), {RefusedPart.BEYOND_MAX_PARTS})
        self.assertEqual(len(two.refused), len(everything.parts) - 2)
        # The first in rank fails for good: whoever asks for one part gets the next, and no deadlock.
        for _ in range(2):
            answer = self.locate("fails", part="bracket")
            again = next(p for p in answer.parts if distance(p, first) < 0.003)
            self.assertNotEqual(self.report("fails", again, False).status,
                                ReportPickResponse.UNKNOWN_PART)
        one = self.locate("fails", part="bracket", max_parts=1)
        self.assertEqual(len(one.parts), 1)
        self.assertGreater(distance(one.parts[0], first), 0.01)
        self.assertIn(RefusedPart.FAILED_BEFORE, reasons(one))
        self.assertIn(RefusedPart.BEYOND_MAX_PARTS, reasons(one))

    def test_not_before(self):
        start = rospy.Time.now()
        first = self.locate("locator", part="bracket", max_parts=1)
        self.assertGreater(first.parts[0].header.stamp, start)
        time.sleep(0.5)
        self.cell.change(has_images=False)
        time.sleep(0.5)  # for what is under way
        stored = self.locate("locator", part="bracket", max_parts=1,
                             not_before=first.parts[0].header.stamp)
        self.assertGreater(stored.parts[0].header.stamp, first.parts[0].header.stamp)
        self.refuse("locator", Status.NO_IMAGE, "since the call", part="bracket",
                    not_before=stored.parts[0].header.stamp + rospy.Duration(0.001),
                    timeout=rospy.Duration(0.3))
        self.refuse("locator", Status.BAD_REQUEST, "not_before", part="bracket",
                    not_before=rospy.Time(2 ** 32 - 1, 999999999))

    def test_timeout(self):
        self.cell.change(has_images=False)
        time.sleep(0.3)
        for timeout, low, high in ((rospy.Duration(0.0), 1.5, 6.0), (rospy.Duration(0.2), 0.2, 1.4)):
            start = time.monotonic()  # zero: image_timeout of cell_contract.yaml
            self.refuse("locator", Status.NO_IMAGE, "since the call", part="bracket", timeout=timeout)
            self.assertGreater(time.monotonic() - start, low)
            self.assertLess(time.monotonic() - start, high)
        self.refuse("locator", Status.BAD_REQUEST, "timeout", timeout=rospy.Duration(-1.0))
        self.refuse("locator", Status.BAD_REQUEST, "timeout", timeout=rospy.Duration(2 ** 31 - 1))

    # --- the response ------------------------------------------------------------------------------
    def test_located_parts_say_all_of_themselves(self):
        response = self.locate("locator", part="bracket")
        stages = [t.stage for t in response.times]
        for stage in ("wait", "convert", "transform", "queue", "edges", "hough", "refine", "score", "publish"):
            self.assertIn(stage, stages)
        self.assertTrue(all(t.seconds >= 0.0 for t in response.times))
        self.assertIn("located", response.message)
        for rank, part in enumerate(response.parts, start=1):
            self.assertEqual(part.child_frame, f"bracket_{rank}")
            self.assertEqual(part.header.frame_id, "base")
            self.assertGreaterEqual(part.score, 0.4)  # score/threshold
            self.assertTrue(0.0 < part.visible_fraction <= 1.0)
            self.assertGreater(part.pose.covariance[0], 0.0)
            self.assertEqual([pick.name for pick in part.picks],
                             ["elbow" if part.face == LocatedPart.FRONT else "elbow_back"])
            q = part.picks[0].pose.orientation
            self.assertLess(1.0 - 2.0 * (q.x ** 2 + q.y ** 2), 0.0)  # its z points down, into the part
        topic = rospy.wait_for_message("locator/located_parts", LocatedParts, UP)
        self.assertEqual(topic.header.frame_id, "base")
        camera = self.locate("camera_frame", part="bracket", max_parts=1).parts[0]
        self.assertEqual(camera.header.frame_id, "camera")
        self.assertGreater(place(camera).z, 0.7)

    # --- refusals ----------------------------------------------------------------------------------
    def test_no_pick_pose(self):
        response = self.locate("locator", part="front_only")
        self.assertEqual({part.face for part in response.parts}, {LocatedPart.FRONT})
        self.assertTrue(all(part.picks for part in response.parts))
        self.assertEqual(set(reasons(response)), {RefusedPart.NO_PICK_POSE})
        self.assertIn("suction (front)", response.refused[0].text)
        backs = self.refuse("locator", Status.DEADLOCK, "no pick pose", part="front_only",
                            face=LocatePartRequest.BACK)
        self.assertIn("other face", backs.message)  # a hint for each reason
        self.assertEqual(set(reasons(backs)), {RefusedPart.NO_PICK_POSE, RefusedPart.WRONG_FACE})

    def test_outside_of_the_distances(self):
        everything = self.locate("camera_frame", part="bracket")
        response = self.call("near", part="bracket")
        self.assertIn(RefusedPart.OUTSIDE, reasons(response))
        farthest = max(place(part).z for part in everything.parts)
        for part in response.parts:
            self.assertLess(place(part).z, farthest)
        self.assertLess(len(response.parts), len(everything.parts))

    def test_outside_of_the_bin(self):
        whole = self.locate("bin", part="bracket")
        half = self.locate("half_bin", part="bracket")
        self.assertEqual(reasons(whole), [])
        self.assertEqual(set(reasons(half)), {RefusedPart.OUTSIDE})
        self.assertEqual(len(half.parts) + len(half.refused), len(whole.parts))
        self.assertIn("outside of the bin's box along x", half.refused[0].text)

    def test_score_visibility_and_tilt(self):
        response = self.call("strict", part="bracket")
        self.assertTrue({RefusedPart.LOW_SCORE, RefusedPart.OCCLUDED, RefusedPart.TILT}
                        <= set(reasons(response)), reasons(response))
        limits = rospy.get_param("strict/pick")
        for part in response.parts:
            self.assertGreaterEqual(part.score, limits["score_min"])
            self.assertGreaterEqual(part.visible_fraction, limits["visible_min"])
        words = {RefusedPart.LOW_SCORE: "at least 0.80", RefusedPart.OCCLUDED: "at least 0.85",
                 RefusedPart.TILT: "at most 4.0"}
        for refused in response.refused:
            self.assertIn(words[refused.reason], refused.text)

    def test_tool_and_walls(self):
        def at_wall(locator, part="bracket"):
            return reasons(self.call(locator, part=part)).count(RefusedPart.WALL)
        walls = at_wall("wide_tool")
        self.assertGreater(walls, 0)
        self.assertGreater(at_wall("wide_tool_clear"), walls)
        self.assertLess(at_wall("low_tool"), at_wall("wide_tool_clear"))
        self.refuse("bin", Status.DEADLOCK, "lie at the wall", part="own_tool")

    def test_thickness(self):
        thin = [p for p in self.locate("locator", part="bracket").parts if p.face == LocatedPart.BACK]
        thick = [p for p in self.locate("locator", part="thick").parts if p.face == LocatedPart.BACK]
        apart = [place(b).z - place(a).z for a in thin for b in thick if math.hypot(
            place(a).x - place(b).x, place(a).y - place(b).y) < 0.002]
        self.assertGreater(len(apart), 2)
        # The origin lies on the front, below the face that is up: by 7 mm more.
        self.assertAlmostEqual(statistics.median(apart), -0.007, delta=0.002)

    # --- picks -------------------------------------------------------------------------------------
    def test_report(self):
        answer = self.locate("fails_once", part="bracket")
        other = self.locate("fails_once", part="front_only")
        following = self.report("fails_once", answer.parts[0], False)
        self.assertEqual(following.status, ReportPickResponse.NEXT, following.message)
        self.assertEqual(following.next.child_frame, answer.parts[1].child_frame)
        self.assertEqual(self.report("fails_once", answer.parts[0], False).status,
                         ReportPickResponse.UNKNOWN_PART)
        self.assertEqual(self.report("fails_once", other.parts[0], True).status, ReportPickResponse.LOCATE)
        # Out of an image from before: noted, but where things lie now is not known.
        later = self.report("fails_once", answer.parts[1], False)
        self.assertEqual(later.status, ReportPickResponse.LOCATE, later.message)
        again = self.locate("fails_once", part="bracket")
        self.assertEqual(reasons(again), [RefusedPart.FAILED_BEFORE] * 2)

    def test_same_place(self):
        first = self.locate("everywhere", part="bracket").parts[0]
        self.report("everywhere", first, False)
        self.refuse("everywhere", Status.DEADLOCK, "could not be picked before", part="bracket")

    def test_changed_grey(self):
        first = self.locate("forgets", part="bracket").parts[0]
        self.report("forgets", first, False)
        unchanged = self.call("forgets", part="bracket")
        self.assertIn(RefusedPart.FAILED_BEFORE, reasons(unchanged))
        def noise(image, _info):
            image.data = bytes(b ^ 1 for b in image.data)
        self.cell.change(spoil=noise)
        self.assertEqual(reasons(self.call("forgets", part="bracket")), [])

    # --- images ------------------------------------------------------------------------------------
    def test_images_of_other_kinds(self):
        count = len(self.locate("locator", part="bracket").parts)
        for spoil in (in_sixteen_bits(12), in_sixteen_bits(16), in_sixteen_bits(12, swapped=True),
                      in_sixteen_bits(10, encoding="16UC1")):
            self.cell.change(spoil=spoil)
            self.assertAlmostEqual(len(self.locate("locator", part="bracket").parts), count, delta=1)

        def one_pixel(image, info):
            image.width = image.height = image.step = 1
            image.data = b"\x07"
            info.width = info.height = info.binning_x = info.binning_y = 1
            info.K = [2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0]

        def floats(image, _info):
            image.encoding = "32FC1"
        for spoil, words in ((one_pixel, "1 x 1"), (floats, "32FC1")):
            self.cell.change(spoil=spoil)
            self.refuse("locator", Status.BAD_IMAGE, words, part="bracket")

        def skewed(_image, info):
            info.K = info.K[:1] + (500.0,) + info.K[2:] if isinstance(info.K, tuple) \
                else [info.K[0], 500.0] + list(info.K[2:])
        self.cell.change(spoil=skewed)
        self.refuse("locator", Status.BAD_CAMERA_INFO, "skew", part="bracket")

    def test_says_why_no_image_came(self):
        self.locate("locator", part="bracket", max_parts=1)  # some image has come
        for words, values in (("no image came on /camera/image_raw", dict(has_images=False)),
                              ("camera_info on /camera/camera_info stopped", dict(has_info=False)),
                              ("0.250 s newer", dict(info_lead=0.25)),
                              ("0.250 s older", dict(info_lead=-0.25)),
                              ("0.040 ms newer", dict(info_lead=4e-5)),
                              ("stamp of zero", dict(zero_stamps=True)),
                              ("too early", dict(image_lead=-60.0))):
            self.cell.good()
            self.cell.change(**values)
            time.sleep(0.5)
            self.refuse("locator", Status.NO_IMAGE, words, part="bracket", timeout=rospy.Duration(1.0))
        self.cell.good()
        self.cell.change(image_lead=0.5)
        self.refuse("locator", Status.BAD_IMAGE, "future", part="bracket")

    def test_trigger(self):
        self.cell.change(has_images=False)
        time.sleep(0.3)
        self.locate("triggered", part="bracket", max_parts=1)
        self.cell.change(trigger_result=TriggerResponse(success=False, message="no light"))
        start = time.monotonic()
        self.refuse("triggered", Status.NO_IMAGE, "no light", part="bracket")
        self.assertLess(time.monotonic() - start, 5.0)  # of the 30 s that it might wait
        # The clock of the camera is ahead: the stamp is later than the call, the image is not.
        self.cell.good()
        self.cell.change(image_lead=0.09, trigger_takes_image=False)
        time.sleep(0.5)
        self.cell.change(has_images=False)
        self.refuse("triggered", Status.NO_IMAGE, "since the call", part="bracket",
                    timeout=rospy.Duration(0.5))

    def test_calls_do_not_wait_for_each_other(self):
        answer = self.locate("locator", part="bracket")
        self.cell.change(has_images=False)
        time.sleep(0.3)
        waiting = [threading.Thread(target=self.call, args=("locator",),
                                    kwargs=dict(part="front_only", timeout=rospy.Duration(6.0)))
                   for _ in range(6)]
        for thread in waiting:
            thread.start()
        time.sleep(0.5)
        start = time.monotonic()
        self.assertNotEqual(self.report("locator", answer.parts[0], False).status,
                            ReportPickResponse.UNKNOWN_PART)
        self.refuse("locator", Status.NO_IMAGE, "", part="bracket", timeout=rospy.Duration(0.2))
        self.assertLess(time.monotonic() - start, 3.0)
        self.assertTrue(all(thread.is_alive() for thread in waiting))
        for thread in waiting:
            thread.join()
        self.cell.good()
        self.report("locator", answer.parts[0], True)  # others go on as if nothing had failed

    # --- tf ----------------------------------------------------------------------------------------
    def test_gap_in_tf(self):
        self.locate("locator", part="bracket", max_parts=1)
        self.cell.change(has_images=False, has_tf=False)
        time.sleep(0.6)
        with self.cell.lock:
            self.cell.take()
        time.sleep(0.4)
        self.cell.change(flange=(0.9, 0.0, 1.0), has_tf=True)
        response = self.refuse("locator", Status.NO_TRANSFORM, "flange", part="bracket",
                               not_before=rospy.Time.now() - rospy.Duration(2.0))
        self.assertIn("tf_gap_max", response.message)
        self.locate("patient", part="bracket", max_parts=1,
                    not_before=rospy.Time.now() - rospy.Duration(3.0))

    def test_frames_stand_as_long_as_their_answer(self):
        answer = self.locate("locator", part="bracket")
        for part in (answer.parts[0], answer.parts[-1]):
            self.assertTrue(self.stands(part.child_frame, part.header.stamp))
            self.assertTrue(self.stands(part.child_frame))
            self.assertTrue(self.stands(part.child_frame + "/" + part.picks[0].name))
        self.assertTrue(self.stands("bracket_1", rospy.Time.now()))
        found = self.buffer.lookup_transform("base", "bracket_1", rospy.Time(0)).transform.translation
        self.assertAlmostEqual(found.x, place(answer.parts[0]).x, places=6)
        other = self.locate("other", part="bracket", max_parts=1)
        self.assertEqual(other.parts[0].child_frame, "other/bracket_1")
        self.assertTrue(self.stands("other/bracket_1"))
        prefixed = self.locate("bin", part="bracket", max_parts=1)
        self.assertEqual(prefixed.parts[0].child_frame, "left_bracket_1")
        # A call without an answer: the old one no longer holds, that of others does.
        self.cell.change(has_images=False)
        time.sleep(0.3)
        self.refuse("locator", Status.NO_IMAGE, "", part="bracket", timeout=rospy.Duration(0.2))
        self.assertFalse(self.stands("bracket_1", expected=False))
        self.assertFalse(self.stands("bracket_1/elbow", expected=False))
        self.assertTrue(self.stands("other/bracket_1"))


if __name__ == "__main__":
    rospy.init_node("contract_tester")
    rostest.rosrun("planar_bin_picking", "contract", Contract, sys.argv)
