#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Each dependency in package.xml is a key of rosdistro or a ROS package, and rosdep resolves it: by the
lists in rosdep/, without a network."""
import os
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import yaml

PACKAGE = Path(__file__).resolve().parents[2]
LISTS = sorted((PACKAGE / "test/support/rosdep").glob("*.yaml"))
EMPTY_INDEX = "%YAML 1.1\n---\ndistributions: {}\ntype: index\nversion: 4\n"


def keys_of(manifest):
    return {element.text for element in ElementTree.fromstring(manifest) if element.tag.endswith("depend")}


def unknown_keys(manifest):
    known = {key for path in LISTS for key in yaml.safe_load(path.read_text())}
    return keys_of(manifest) - known


class Rosdep(unittest.TestCase):
    def setUp(self):
        self.manifest = (PACKAGE / "package.xml").read_text()

    def test_knows_each_key(self):
        self.assertEqual(unknown_keys(self.manifest), set())

    def test_refuses_a_name_of_debian(self):
        made_up = self.manifest.replace(">embree<", ">libembree-dev<")
        self.assertEqual(unknown_keys(made_up), {"libembree-dev"})

    def test_lists_hold_nothing_else(self):
        for path in LISTS:
            self.assertLessEqual(set(yaml.safe_load(path.read_text())), keys_of(self.manifest), path.name)

    def test_installs_them(self):
        with tempfile.TemporaryDirectory() as folder:
            home = Path(folder)
            (home / "sources").mkdir()
            (home / "sources/10-lists.list").write_text("".join(f"yaml file://{path}\n" for path in LISTS))
            (home / "index.yaml").write_text(EMPTY_INDEX)
            environment = dict(os.environ, HOME=folder, ROS_HOME=folder, ROSDEP_SOURCE_PATH=str(home / "sources"),
                               ROSDISTRO_INDEX_URL=f"file://{home / 'index.yaml'}")

            def rosdep(*arguments):
                return subprocess.run(["rosdep", *arguments], env=environment, capture_output=True, text=True, timeout=120)

            update = rosdep("update")
            self.assertEqual(update.returncode, 0, update.stderr)
            install = rosdep("--os=debian:bookworm", "--rosdistro=noetic", "install", "--simulate", "--reinstall",
                             "-y", "--from-paths", str(PACKAGE))
            self.assertEqual(install.returncode, 0, install.stderr)
            for package in ("libembree-dev", "libroscpp-dev", "libceres-dev", "librostest-dev"):
                self.assertIn(f"apt-get install -y {package}\n", install.stdout)


if __name__ == "__main__":
    unittest.main()
