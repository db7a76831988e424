#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The check of the rooms finds each kind of fault in a small package, and nothing in one that obeys."""
import tempfile
import unittest
from pathlib import Path

from check_rooms import UNITS_MAX, check

PUBLIC = "include/planar_bin_picking/"
OBEYS = {
    PUBLIC + "base/types.h": "#include <vector>\n",
    "src/core/base/yaml.h": "",
    "src/core/base/yaml.cpp": '#include "base/yaml.h"\n',
    PUBLIC + "part/model.h": '#include "planar_bin_picking/base/types.h"\n',
    "src/core/part/model.cpp": '#include "planar_bin_picking/part/model.h"\n#include "base/yaml.h"\n',
    PUBLIC + "locate/params.h": "",
    "src/core/image/edges.h": '#include "planar_bin_picking/locate/params.h"\n#include "planar_bin_picking/part/model.h"\n',
    "src/core/locate/vote/hough.h": '#include "image/edges.h"\n',
    "src/core/locate/judge/score.h": '#include "image/edges.h"\n',
    "src/core/locate/locator.h": '#include "locate/vote/hough.h"\n#include "locate/judge/score.h"\n',
    "src/ros/shared/convert.h": '#include "planar_bin_picking/part/model.h"\n',
    "src/ros/locator/answer/answer.h": '#include "shared/convert.h"\n',
    "src/ros/locator/locator_ros.h": '#include "locator/answer/answer.h"\n',
    "src/ros/locator/locator_node.cpp": '#include "locator/locator_ros.h"\n',
    "src/ros/hdr/hdr_ros.h": '#include "shared/convert.h"\n',
}


class Rooms(unittest.TestCase):
    def faults(self, more=None, known=frozenset()):
        with tempfile.TemporaryDirectory() as folder:
            for name, contents in {**OBEYS, **(more or {})}.items():
                path = Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(contents)
            return check(Path(folder), set(known))

    def assert_one_fault(self, more, *words):
        found = self.faults(more)
        self.assertEqual(len(found), 1, found)
        for word in words:
            self.assertIn(word, found[0])

    def test_what_obeys_has_no_fault(self):
        self.assertEqual(self.faults(), [])

    def test_an_arrow_against_the_way(self):
        self.assert_one_fault({"src/core/base/yaml.h": '#include "planar_bin_picking/locate/params.h"\n'},
                              "base/yaml", "locate/params")

    def test_a_public_header_belongs_to_its_room(self):
        self.assert_one_fault({PUBLIC + "drawing/symmetry.h": '#  include "planar_bin_picking/part/model.h"\n'},
                              "drawing/symmetry", "from room part to drawing")

    def test_a_stage_includes_no_other(self):
        self.assert_one_fault({"src/core/locate/judge/score.h": '#include "locate/vote/hough.h"\n'},
                              "from room locate/vote to locate/judge")

    def test_a_unit_with_a_room_of_its_own(self):
        camera = {PUBLIC + "image/camera.h": "", "src/core/calibrate/board.h": '#include "planar_bin_picking/image/camera.h"\n'}
        self.assertEqual(self.faults(camera), [])
        camera["src/core/calibrate/board.h"] = '#include "image/edges.h"\n'
        self.assert_one_fault(camera, "calibrate/board", "image/edges")

    def test_nodes_do_not_include_each_other(self):
        self.assert_one_fault({"src/ros/hdr/hdr_ros.h": '#include "locator/locator_ros.h"\n'}, "ros/hdr", "ros/locator")
        self.assert_one_fault({"src/ros/locator/answer/answer.h": '#include "locator/locator_ros.h"\n',
                               "src/ros/locator/locator_ros.h": ""}, "from room ros/locator to ros/locator/answer")

    def test_a_circle_within_a_room(self):
        self.assert_one_fault({"src/core/part/model.cpp": '#include "planar_bin_picking/part/model.h"\n#include "part/size.h"\n',
                               "src/core/part/size.h": '#include "part/weight.h"\n',
                               "src/core/part/weight.h": '#include "planar_bin_picking/part/model.h"\n'},
                              "circle: part/model <-> part/size <-> part/weight")

    def test_a_room_of_too_many_units(self):
        full = {f"src/core/base/unit_{i}.h": "" for i in range(UNITS_MAX - 2)}  # two are there already
        self.assertEqual(self.faults(full), [])
        self.assert_one_fault({**full, "src/core/base/more.h": ""}, "room base", str(UNITS_MAX + 1))

    def test_a_source_without_its_header(self):
        self.assert_one_fault({"src/core/base/other.cpp": '#include "base/yaml.h"\n'}, "src/core/base/other.cpp")
        self.assert_one_fault({"src/core/base/other.cpp": "#include <vector>\n"}, "src/core/base/other.cpp")

    def test_a_room_that_the_rule_does_not_know(self):
        self.assert_one_fault({"src/core/cellar/wine.h": ""}, "cellar")

    def test_an_include_that_leads_nowhere(self):
        self.assert_one_fault({"src/core/base/yaml.h": '#include "base/gone.h"\n'}, "base/gone.h")

    def test_a_known_fault_is_passed_over_until_it_is_mended(self):
        fault = "src/core/base/other.cpp does not begin with a header of its own name"
        self.assertEqual(self.faults({"src/core/base/other.cpp": ""}, {fault}), [])
        self.assertEqual(self.faults(known={fault}), [f"no longer so, take it out of KNOWN: {fault}"])


if __name__ == "__main__":
    unittest.main()
