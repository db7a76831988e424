#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Doxygen takes <word> in a comment for a tag that it does not know, which ends `./run doc`: it has to stand in backticks
or in quotes."""
import re
import unittest
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]


def loose_tags(text):
    """The comments' lines of a header that have one."""
    return [line.strip() for line in text.splitlines()
            if re.search(r"///.*<[a-z_]+>", line) and re.search(r"<[a-z_]+>", re.sub(r"`[^`]*`|\"[^\"]*\"", "", line.split("///")[1]))]


class HeaderComments(unittest.TestCase):
    def test_finds_a_loose_tag(self):
        self.assertEqual(loose_tags("/// as <file>.before\n/// `<part>_1`\nstd::vector<int> x;  ///< `a <b>`"),
                         ["/// as <file>.before"])

    def test_headers_have_none(self):
        found = {str(path): loose_tags(path.read_text()) for folder in ("include", "src")
                 for path in sorted((PACKAGE / folder).rglob("*.h"))}
        self.assertEqual({path: lines for path, lines in found.items() if lines}, {})


if __name__ == "__main__":
    unittest.main()
