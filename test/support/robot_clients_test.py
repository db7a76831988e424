#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The examples for robot controllers that cannot be run here, held against doc/robot_server.md: what they send is a line
that the page knows, and what they read are the answer's fields in their order, of the right kind."""
import re
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
PAGE = (PACKAGE / "doc/robot_server.md").read_text()
AHEAD = ["code", "left", "face"]
POSE = 6  # numbers of a pose but for ABB's


def client(name):
    return (PACKAGE / "test/ros/robot_clients" / name).read_text()


def known(line):
    """Whether the page's table of lines has it."""
    rows = re.findall(r"^\| (`[^|]*`[^|]*) \|", PAGE.replace("\\|", "/"), re.MULTILINE)
    lines = [line for row in rows for line in re.findall(r"`([^`]+)`", row)]
    patterns = [re.escape(one).replace(r"PART\ …", r"\S+( \S+)*").replace(r"\ \[front/back\]", "( front| back)?")
                .replace(r"\ \[flange\ POSE\]", "( flange( \\S+){6})?") for one in lines]
    return any(re.fullmatch(pattern, line) for pattern in patterns)


class Page(unittest.TestCase):
    def test_says_what_these_tests_know(self):
        answer = re.search(r"An answer is `0 ([^`]*)`", PAGE)[1]
        self.assertEqual(answer, "LEFT FACE [PART_NUMBER TOOL_NUMBER] POSE [APPROACH] [RETREAT] PART PICK")
        self.assertTrue(known("locate bracket") and known("report ok") and known("locate a b back"))
        self.assertFalse(known("pick bracket") or known("report yes"))


class Kuka(unittest.TestCase):
    program = client("kuka.src")

    def test_sends_lines_that_end(self):
        for line in re.findall(r'words\[\] = "([^"]*)"', self.program):
            self.assertTrue(known(line), line)
        self.assertEqual(re.findall(r'EKI_Send\("BinServer", (\S+)\)', self.program), ["words[]", "eol[]"])
        self.assertIn("eol[1] = 10", self.program)

    def test_reads_code_and_both_poses(self):
        reads = re.findall(r'SREAD\(line\[\], state, offset, "([^"]*)", (.*)\)', self.program)
        self.assertEqual([(formats, names) for formats, names in reads if names == "code"], [("%d", "code")])
        formats = [word for formats, names in reads if names != "code" for word in formats.split()]
        names = [name for _, names in reads if names != "code" for name in names.split(", ")]
        frames = [f"{frame}.{axis}" for frame in ("target", "before") for axis in "XYZABC"]
        self.assertEqual(names, AHEAD + frames)
        self.assertEqual(formats, ["%d"] * len(AHEAD) + ["%f"] * (2 * POSE))
        self.assertIn("approach_mm", self.program)


class Fanuc(unittest.TestCase):
    program = client("fanuc.kl")

    def test_sends_lines_that_end(self):
        writes = re.findall(r"WRITE link \('([^']*)', CHR\(10\)\)", self.program)
        self.assertEqual(len(writes), self.program.count("WRITE link"))
        for line in writes:
            self.assertTrue(known(line), line)

    def test_reads_code_and_pose(self):
        reads = re.findall(r"READ link \((.*)\)", self.program)
        self.assertEqual(", ".join(reads), "code, left, face, x, y, z, w, p, r, rest")
        kinds = {name: kind for names, kind in re.findall(r"^  ([\w, ]+?) *: (\w+)", self.program, re.MULTILINE)
                 for name in names.split(", ")}
        for name in AHEAD:
            self.assertEqual(kinds[name], "INTEGER")
        for name in "xyzwpr":
            self.assertEqual(kinds[name], "REAL")
        self.assertIn("POS(x, y, z, w, p, r, no_turns)", self.program)


class UniversalRobots(unittest.TestCase):
    program = client("universal_robots.script")

    def test_sends_lines(self):
        for line in re.findall(r'socket_send_line\("([^"]*)"', self.program):
            self.assertTrue(known(line), line)

    def test_reads_as_many_numbers_as_there_are(self):
        count = len(AHEAD) + 2 * POSE
        self.assertEqual(set(re.findall(r"socket_read_ascii_float\((\d+),", self.program)), {str(count)})
        self.assertIn(f"answer[0] == {count} and answer[1] == 0", self.program)
        poses = re.findall(r"p\[(.*)\]", self.program)
        indices = [int(index) for pose in poses for index in re.findall(r"answer\[(\d+)\]", pose)]
        self.assertEqual(indices, list(range(1 + len(AHEAD), 1 + count)))  # the list begins with its length


if __name__ == "__main__":
    unittest.main()
