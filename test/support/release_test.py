#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What bloom reads when it releases a package: the manifest and the changelog."""
import re
import unittest

from catkin_pkg.changelog import get_changelog_from_path
from catkin_pkg.package import parse_package

from readme import PACKAGE


class Release(unittest.TestCase):
    def test_changelog_goes_with_the_manifest(self):
        manifest = parse_package(str(PACKAGE))
        manifest.validate()
        text = (PACKAGE / "CHANGELOG.rst").read_text()
        self.assertIn(f"\nChangelog for package {manifest.name}\n", text)
        # What is not released yet stands under "Forthcoming", which catkin_prepare_release turns into the version.
        released = [str(version) for version, *_ in get_changelog_from_path(str(PACKAGE)).foreach_version()]
        self.assertTrue(manifest.version in released or re.search(r"^Forthcoming\n-+\n\* ", text, re.MULTILINE))

    def test_manifest_says_who_keeps_it_and_where(self):
        manifest = parse_package(str(PACKAGE))
        self.assertTrue(all(one.name and "@" in one.email for one in manifest.maintainers) and manifest.maintainers)
        self.assertTrue({url.type for url in manifest.urls} & {"website", "repository"})


if __name__ == "__main__":
    unittest.main()
