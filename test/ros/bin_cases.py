# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Of views_tester.py: a bin that stands otherwise than tf has it, and a flange that is not on tf."""
import os
import shutil
import subprocess
import tempfile
import time

import numpy
import roslib.packages
import rospy
import yaml
from drawn_cell import T_HAND_EYE, rotation, shift, transform
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import PoseStamped
from planar_bin_picking.msg import RefusedPart
from planar_bin_picking.srv import (LocateBin, LocateBinResponse, LocatePart, LocatePartResponse, NextView,
                                    NextViewResponse, RefinePart, RefinePartResponse)
from std_srvs.srv import Trigger

TESTS = os.path.dirname(os.path.abspath(__file__))
UP = 60.0  # s, for a node to come up
HOME = shift(0.0, 0.0, 0.6) @ rotation("x", 180)


def matrix(pose):
    q, p = pose.orientation, pose.position
    T = numpy.eye(4)
    x, y, z, w = q.x, q.y, q.z, q.w
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = p.x, p.y, p.z
    return T


class BinCases:
    """Needs of the test case: cell, and the locators `locator` and `binned`."""

    def locate_bin(self, status, T_base_bin=None, plates=(), locator="binned", **fields):
        self.cell.show(HOME, plates, bins=[] if T_base_bin is None else [T_base_bin])
        answer = rospy.ServiceProxy(locator + "/locate_bin", LocateBin)(**fields)
        self.assertEqual(answer.status, status, answer.message)
        return answer

    def test_a_bin_that_stands_otherwise_is_found(self):
        there = shift(0.035, -0.02, 0.01) @ rotation("z", 6) @ rotation("x", 3)
        found = self.locate_bin(LocateBinResponse.OK, there)
        self.assertEqual(found.bin.header.frame_id, "base")
        self.assertLess(numpy.linalg.norm(matrix(found.bin.pose) - there), 0.01)
        self.assertLess(numpy.linalg.norm(matrix(found.bin.pose)[:3, 3] - there[:3, 3]), 0.002)
        self.assertAlmostEqual(found.moved, 0.0415, delta=0.002)
        self.assertAlmostEqual(numpy.degrees(found.turned), 6.0, delta=0.3)
        self.assertAlmostEqual(numpy.degrees(found.tilted), 3.0, delta=0.5)
        self.assertGreater(found.score, 0.6)
        self.assertIn("41.", found.message)
        # A plate beside the file's box, and within the bin where it stands.
        plate = [there @ shift(0.085, 0.0, -0.01)]
        self.cell.show(HOME, plate, bins=[there])
        locate = rospy.ServiceProxy("binned/locate_part", LocatePart)
        outside = locate(part="plate")
        self.assertEqual([r.reason for r in outside.refused], [RefusedPart.OUTSIDE], outside.message)
        self.locate_bin(LocateBinResponse.OK, there, plate, use=True)
        published = rospy.wait_for_message("binned/bin", PoseStamped, UP)
        self.assertLess(numpy.linalg.norm(matrix(published.pose)[:3, 3] - there[:3, 3]), 0.002)
        self.assertEqual(locate(part="plate").status, LocatePartResponse.OK)
        # Farther off than the cell allows: said, and not believed.
        for far, words in ((there @ rotation("z", 6), "turned"), (there @ shift(0.03, 0, 0), "moved")):
            self.assertIn("bin_" + words, self.locate_bin(LocateBinResponse.TOO_FAR, far, use=True).message)
        self.cell.show(HOME, plate, bins=[there])
        self.assertEqual(locate(part="plate").status, LocatePartResponse.OK)
        self.locate_bin(LocateBinResponse.OK, there, plate, forget=True)
        self.assertEqual(rospy.wait_for_message("binned/bin", PoseStamped, UP).header.frame_id, "")
        self.assertEqual([r.reason for r in locate(part="plate").refused], [RefusedPart.OUTSIDE])

    def kept_locator(self, cell):
        """A locator of its own, with these parameters of its cell; once it answers and hears tf."""
        rospy.set_param("kept/cell", cell)
        heard = self.cell.tf.pub_tf.get_num_connections()
        program = roslib.packages.find_node("planar_bin_picking", "locator")[0]
        process = subprocess.Popen([program, "__name:=kept"])
        self.addCleanup(lambda: (process.terminate(), process.wait(UP)))
        rospy.wait_for_service("kept/locate_bin", UP)
        end = time.monotonic() + UP
        while self.cell.tf.pub_tf.get_num_connections() <= heard and time.monotonic() < end:
            time.sleep(0.02)
        return process

    def test_a_bin_that_was_found_is_kept_beyond_a_restart(self):
        scratch = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, scratch)
        cell_file = os.path.join(scratch, "cell.yaml")
        shutil.copy(os.path.join(TESTS, "cell_moved_bin.yaml"), cell_file)

        def cell():
            with open(cell_file) as file:
                return dict(yaml.safe_load(file), cell_file=cell_file, parts_folder=os.path.join(TESTS, "drawn"))
        save = rospy.ServiceProxy("kept/save_parameters", Trigger)
        process = self.kept_locator(cell())
        there = shift(0.035, -0.02, 0.0) @ rotation("z", 6)
        # The box as it is tuned is what is looked for: its rim, said to be 20 mm higher, lies that much lower.
        tuning = Client("kept/tuning", timeout=UP)
        tuning.update_configuration({"bin_max_z": 0.02})
        self.assertAlmostEqual(self.locate_bin(LocateBinResponse.OK, shift(0, 0, 0), locator="kept").moved, 0.02, delta=0.004)
        tuning.update_configuration({"bin_max_z": 0.0})
        used = self.locate_bin(LocateBinResponse.OK, there, locator="kept", use=True)
        self.assertIn("~save_parameters keeps that", used.message)
        saved = save()
        self.assertTrue(saved.success, saved.message)
        self.assertIn("bin_found: [0.0", saved.message)
        process.terminate()
        process.wait(UP)
        # What was believed just within the limits does not stop the next start, whatever rounding made of it.
        process = self.kept_locator(dict(cell(), bin_moved_max=used.moved - 5e-5))
        bin_ = rospy.wait_for_message("kept/bin", PoseStamped, UP)
        self.assertEqual(bin_.header.frame_id, "tray")
        self.assertLess(numpy.linalg.norm(matrix(bin_.pose) - there), 0.01)
        plate = [there @ shift(0.085, 0.0, -0.01)]  # beside the file's box, within the bin where it stands
        self.cell.show(HOME, plate, bins=[there])
        locate = rospy.ServiceProxy("kept/locate_part", LocatePart)
        self.assertEqual(locate(part="plate").status, LocatePartResponse.OK)
        self.locate_bin(LocateBinResponse.OK, there, plate, locator="kept", forget=True)
        self.assertEqual([r.reason for r in locate(part="plate").refused], [RefusedPart.OUTSIDE])
        self.assertTrue(save().success)
        self.assertEqual(cell()["bin_found"], [])
        # What was saved does not hold where the cell allows less.
        process.terminate()
        process.wait(UP)
        rospy.set_param("kept/cell", dict(cell(), bin_found=[0.06, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]))
        program = roslib.packages.find_node("planar_bin_picking", "locator")[0]
        refused = subprocess.run([program, "__name:=kept"], capture_output=True, text=True, timeout=UP)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("bin_found", refused.stdout + refused.stderr)

    def test_a_flange_that_is_not_on_tf(self):
        # Of the eye, tf has the way from the hand only.
        plates = [shift(0.05, 0.02, 0.0) @ rotation("x", 4)]

        def flange(T_base_camera):
            return transform("base", "hand", T_base_camera @ numpy.linalg.inv(T_HAND_EYE), rospy.Time.now())
        self.cell.show(HOME, plates, frame_id="eye")
        locate = rospy.ServiceProxy("locator/locate_part", LocatePart)
        answer = locate(part="plate", flange=flange(HOME))
        self.assertEqual(answer.status, LocatePartResponse.OK, answer.message)
        part = answer.parts[0]
        ask = rospy.ServiceProxy("locator/next_view", NextView)
        proposed = ask(stamp=part.header.stamp, child_frame=part.child_frame, flange_frame="hand")
        self.assertEqual(proposed.status, NextViewResponse.OK, proposed.message)
        self.assertEqual(proposed.flange.header.frame_id, "base")
        T_base_hand = matrix(proposed.flange.pose)
        numpy.testing.assert_allclose(T_base_hand @ T_HAND_EYE, matrix(proposed.camera.pose), atol=1e-6)
        nowhere = ask(stamp=part.header.stamp, child_frame=part.child_frame, flange_frame="nowhere")
        self.assertEqual(nowhere.status, NextViewResponse.NO_TRANSFORM, nowhere.message)
        self.assertIn("flange_frame", nowhere.message)
        there = T_base_hand @ T_HAND_EYE
        refine = rospy.ServiceProxy("locator/refine_part", RefinePart)
        self.cell.show(there, plates, frame_id="eye")
        refined = refine(stamp=part.header.stamp, child_frame=part.child_frame, flange=flange(there))
        self.assertEqual(refined.status, RefinePartResponse.OK, refined.message)
        self.assertEqual(refined.parts[0].views, 2)
        self.assertLess(numpy.linalg.norm((matrix(refined.parts[0].pose.pose) - plates[0])[:3, 3]), 0.001)
        half = flange(there)
        half.child_frame_id = ""
        wrong = refine(stamp=part.header.stamp, child_frame=refined.parts[0].child_frame, flange=half)
        self.assertEqual(wrong.status, RefinePartResponse.BAD_REQUEST)
        self.assertIn("flange", wrong.message)
        again = refine(stamp=refined.parts[0].header.stamp, child_frame=refined.parts[0].child_frame)
        self.assertEqual(again.status, RefinePartResponse.NO_TRANSFORM)  # tf has no way from base to the eye

    def test_no_bin_is_an_answer(self):
        self.locate_bin(LocateBinResponse.NOT_FOUND)
        self.locate_bin(LocateBinResponse.NOT_SET, locator="locator")
        self.locate_bin(LocateBinResponse.BAD_REQUEST, timeout=rospy.Duration(-1.0))
        self.locate_bin(LocateBinResponse.NO_IMAGE, not_before=rospy.Time.now() + rospy.Duration(60),
                        timeout=rospy.Duration(0.3))
        self.cell.show(HOME, [], K=[0.0] * 9)
        call = rospy.ServiceProxy("binned/locate_bin", LocateBin)
        self.assertEqual(call().status, LocateBinResponse.BAD_CAMERA_INFO)
        self.cell.show(HOME, [], encoding="32FC1")
        self.assertEqual(call().status, LocateBinResponse.BAD_IMAGE)
        self.cell.show(HOME, [], frame_id="nowhere")
        self.assertEqual(call().status, LocateBinResponse.NO_TRANSFORM)
        self.cell.show(shift(0.0, 0.0, -0.6) @ rotation("x", 180), [])  # the rim is behind it
        self.assertEqual(call().status, LocateBinResponse.BAD_BIN)
