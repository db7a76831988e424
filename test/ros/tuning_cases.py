# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What an operator changes while a locator runs: cases of operation_tester.py."""
import math
import threading

import rospy
from dynamic_reconfigure.client import Client
from planar_bin_picking.msg import RefusedPart
from planar_bin_picking.srv import LocatePartResponse as Status
from operation_region import center
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

UP = 60.0  # s, for the node to come up; machines may be busy


class TuningCases:
    """Of one locator, `op`, with a bin's box and a file of its own (cell_file)."""

    def tuning(self, *changed):
        """The client; what a test changes is put back at its end."""
        client = Client("op/tuning", timeout=UP)
        start = client.get_configuration()
        self.addCleanup(lambda: client.update_configuration({name: start[name] for name in changed}))
        return client

    def shows(self, key, value):
        return (key, value) in [(pair.key, pair.value) for pair in self.diagnostics("op")["calls"].values]

    def test_an_operator_tunes_while_it_runs(self):
        tuning = self.tuning("max_parts", "score_min", "score_threshold", "bin_max_z")
        start = tuning.get_configuration()
        self.assertEqual((start["score_threshold"], start["failures_max"], start["bin_min_x"], start["refused"]),
                         (0.4, 2, 0.46, ""))
        ranges = {one["name"]: (one["min"], one["max"]) for one in tuning.get_parameter_descriptions()}
        self.assertEqual(ranges["score_threshold"], (0.0, 1.0))
        everything = self.call("op", Status.OK, part="bracket")
        now = tuning.update_configuration({"max_parts": 2})
        self.assertEqual((now["max_parts"], now["refused"]), (2, ""))
        self.assertEqual(len(self.call("op", Status.OK, part="bracket").parts), 2)
        self.assertEqual(len(self.call("op", Status.OK, part="bracket", max_parts=1).parts), 1)
        # A change that is wrong changes nothing, and says why.
        for wrong, reason in (({"max_parts": 1, "score_min": 1.5}, "score_min is 1.5"),
                              ({"max_parts": 1, "bin_min_x": 1.0}, "bin_min")):
            refused = tuning.update_configuration(wrong)
            self.assertEqual(refused["max_parts"], 2)
            self.assertIn(reason, refused["refused"])
            self.assertEqual((refused["score_min"], refused["bin_min_x"]), (0.0, 0.46))
        tuning.update_configuration({"score_min": 1.0})
        low = self.call("op", Status.DEADLOCK, part="bracket")
        self.assertEqual(low.parts, [])
        self.assertIn(RefusedPart.LOW_SCORE, {part.reason for part in low.refused})
        self.comes_true(lambda: self.shows("deadlocks in a row", "1"))
        tuning.update_configuration({"score_min": 0.0, "score_threshold": 0.999})
        self.call("op", Status.NO_PART_FOUND, "nothing scored 1.00", part="bracket")
        tuning.update_configuration({"score_threshold": 0.7})
        kept = self.call("op", Status.OK, part="bracket")
        self.assertLessEqual(len(kept.parts + kept.refused), len(everything.parts + everything.refused))
        rim = start["bin_max_z"] + 0.02
        tuning.update_configuration({"bin_max_z": rim})
        self.call("op", Status.OK, part="bracket")
        shown = [m for m in rospy.wait_for_message("op/scene", MarkerArray, UP).markers if m.ns == "bin"]
        self.assertAlmostEqual(max(point.z for point in shown[0].points), rim, places=6)

    def test_parts_are_offered_clockwise(self):
        tuning = self.tuning("order_clockwise")
        tuning.update_configuration({"order_clockwise": 1000.0})
        parts = self.call("op", Status.OK, part="bracket").parts
        self.assertGreater(len(parts), 1)

        def turn(part):
            x, y, _ = center(part) - [0.56, 0.0, 0.0]  # from the bin's middle
            return math.atan2(x, y) % (2.0 * math.pi)
        self.assertEqual([turn(part) for part in parts], sorted(turn(part) for part in parts))

    def test_a_change_waits_for_the_next_call(self):
        tuning = self.tuning("max_parts")
        self.cell.change(has_images=False)
        answers = []
        caller = threading.Thread(target=lambda: answers.append(self.call("op", Status.OK, part="bracket")))
        caller.start()
        self.comes_true(lambda: self.shows("calls under way", "1"))
        tuning.update_configuration({"max_parts": 1})
        self.cell.good()
        caller.join()
        self.assertGreater(len(answers[0].parts), 1)
        self.assertEqual(len(self.call("op", Status.OK, part="bracket").parts), 1)

    def test_what_was_tuned_is_saved_to_the_cells_file(self):
        tuning, save = self.tuning("max_parts", "score_threshold"), rospy.ServiceProxy("op/save_parameters", Trigger)
        tuning.update_configuration({"max_parts": 4, "score_threshold": 0.6})
        saved = save()
        self.assertTrue(saved.success, saved.message)
        with open(self.cell_file) as file:
            text = file.read()
        self.assertEqual(text, "target_frame: base  # of the robot\nlocator:\n  score:\n    threshold: 0.6\n"
                               "pick:\n  max_parts: 4\n")
        # For this node when it is started again.
        self.assertEqual(rospy.get_param("op/cell/pick/max_parts"), 4)
        self.assertEqual(rospy.get_param("op/cell/locator/score/threshold"), 0.6)
        self.assertIn("nothing has been changed", save().message)
        parameters = rospy.ServiceProxy("op/parameters", Trigger)().message
        self.assertIn("max_parts: 4", parameters)
        no_file = rospy.ServiceProxy("coarse/save_parameters", Trigger)()
        self.assertFalse(no_file.success)
        self.assertIn("cell_file", no_file.message)
