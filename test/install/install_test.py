#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Installs the package and runs the examples of README and doc/ as they stand there, with nothing but the installed
files; only the folder /path/to of the examples is another one: install_test.py BUILD_FOLDER"""
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import cv2
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
import board_pictures
import readme
from readme import PACKAGE
from ros_session import Session, installed_environment

BUILD = None  # the folder given on the command line

# Each command of these pages, and which test below runs it.
COMMANDS = {
    "demo": r"\./run demo$",
    "test": r"\./run test$",
    "locate_image": r"\S+/locate_image ",
    "describe_part": r"\S+/describe_part ",
    "add_part": r"rosrun planar_bin_picking add_part ",
    "robot_server": r"roslaunch planar_bin_picking robot_server\.launch ",
    "teach": r"roslaunch planar_bin_picking teach\.launch ",
    "rename": r"rosservice call /teach/rename ",
    "cell": r"roslaunch planar_bin_picking cell\.launch ",
    "locate": r"rosservice call /locator/locate_part ",
    "save_region": r"rosservice call /locator/save_region$",
    "clear_region": r"rosservice call /locator/clear_region$",
    "locate_bin": r"rosservice call /locator/locate_bin ",
    "cycle_demo": r"roslaunch planar_bin_picking cycle_demo\.launch ",
    "calibrate": r"roslaunch planar_bin_picking calibrate\.launch ",
    "plan": r"rosservice call /calibrator/plan$",
    "start": r"rosservice call /calibrator/start$",
    "next": r"rosservice call /calibrator/next$",
    "status": r"rostopic echo /calibrator/status$",
    "calibrate_samples": r"rosrun planar_bin_picking calibrate_samples ",
    "draw_board": r"rosrun planar_bin_picking draw_board ",
    "play_scene": r"rosrun planar_bin_picking play_scene\.py ",
    "tune": r"rosrun dynamic_reconfigure dynparam set /locator/tuning ",
    "save_parameters": r"rosservice call /locator/save_parameters$",
    "check_cell": r"rosrun planar_bin_picking check_cell\.py ",
}

MANIFEST = """<?xml version="1.0"?>
<package format="2">
  <name>{0}</name>
  <version>0.0.0</version>
  <description>A package beside the installed one.</description>
  <maintainer email="nobody@users.noreply.example">nobody</maintainer>
  <license>BSD-3-Clause</license>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>planar_bin_picking</depend>
  <depend>roscpp</depend>
</package>
"""

CLIENT_CMAKE = """cmake_minimum_required(VERSION 3.16)
project(my_client CXX)
set(CMAKE_CXX_STANDARD 17)
find_package(catkin REQUIRED COMPONENTS planar_bin_picking roscpp)
catkin_package()
add_executable(my_client my_client.cpp)
target_include_directories(my_client PRIVATE ${catkin_INCLUDE_DIRS})
target_link_libraries(my_client ${catkin_LIBRARIES})
"""

# Uses both libraries and a service.
CLIENT_SOURCE = """#include <planar_bin_picking/LocatePart.h>
#include <planar_bin_picking/calibrate/calibration_file.h>
#include <planar_bin_picking/locate/locator.h>
#include <planar_bin_picking/part/part_file.h>
#include <iostream>
int main(int, char** argv) {
  const planar_bin_picking::PartModel part(planar_bin_picking::loadPartFile(argv[1]));
  const planar_bin_picking::Locator locator{planar_bin_picking::LocatorParams()};
  const auto hand_eye = planar_bin_picking::loadHandEye(argv[2]);
  std::cout << part.name() << " " << hand_eye.child_frame << " "
            << ros::service_traits::datatype<planar_bin_picking::LocatePart>() << std::endl;
}
"""


HAND_EYE = """parent_frame: flange
child_frame: eye
position: [0, 0, 0]
orientation: [0, 0, 0, 1]
expected_error_mm: 1
expected_error_deg: 1
"""


def install(folder):
    """Into `folder`, away from where the build was told it would go: rospack would find two of everything
    in the source's own folder."""
    cache = (BUILD / "CMakeCache.txt").read_text()
    prefix = Path(re.search(r"^CMAKE_INSTALL_PREFIX:PATH=(.*)$", cache, re.MULTILINE)[1])
    subprocess.run(["cmake", "--install", str(BUILD)], check=True, stdout=subprocess.DEVNULL, timeout=120,
                   env=dict(os.environ, DESTDIR=str(folder / "staged")))
    return (folder / "staged" / prefix.relative_to("/")).rename(folder / "installed")


def command(name):
    """The pages' command, in the one form in which it stands there."""
    found = [line for line in readme.commands(readme.text()) if re.match(COMMANDS[name], line)]
    if len(found) != 1:
        raise LookupError(f"README and doc/ have {len(found)} commands like {COMMANDS[name]}")
    return found[0]


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.root = Path(cls.temporary.name)
        cls.prefix = install(cls.root)
        cls.share = cls.prefix / "share/planar_bin_picking"
        cls.environment = installed_environment(cls.prefix / "setup.bash", cls.root)
        for name, contents in readme.files(readme.text()).items():
            path = cls.root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(cls.here(contents))
        shutil.copy(PACKAGE / "config/parts/bracket.dxf", cls.root / "parts")
        cls.scene = f"{cls.share}/test/data/bin_bracket_00"

    @classmethod
    def here(cls, text):
        return text.replace("/path/to/", f"{cls.root}/")

    def session(self):
        return Session(self.environment, self.root)

    def test_knows_each_command_of_the_pages(self):
        for line in readme.commands(readme.text()):
            fitting = [name for name, pattern in COMMANDS.items() if re.match(pattern, line)]
            self.assertEqual(len(fitting), 1, line)
        for name in COMMANDS:
            command(name)

    def test_needs_neither_source_nor_build(self):
        traces = [str(PACKAGE / "src"), str(PACKAGE / "test"), str(BUILD / "devel"), str(BUILD / "catkin_generated")]
        for path in self.prefix.rglob("*"):
            if path.is_file():
                contents = path.read_bytes()
                for trace in traces:
                    self.assertFalse(trace.encode() in contents and path.suffix != ".pyc", f"{path} names {trace}")
        with self.session() as session:
            self.assertEqual(session.run("rospack find planar_bin_picking").strip(), str(self.share))

    def test_launch_files_find_all_their_files_and_programs(self):
        cases = {name: [""] for name in ("cell", "demo", "calibrate_demo", "hdr", "robot_server")}
        cases["cycle_demo"] = ["", "hdr:=true nodelet:=false"]
        cases["bag"] = ["bag:=my.bag"]
        # The page's two cells, with files of their own.
        for name in ("left", "right"):
            shutil.copy(self.root / "cell.yaml", self.root / f"{name}.yaml")
        cases["calibrate"] = [f"cell:={self.root}/calibrator.yaml"]
        cases["hand_eye"] = ["file:=hand_eye.yaml"]
        cases["teach"] = ["part:=bracket"]
        self.assertEqual(set(cases), {path.stem for path in (self.share / "launch").glob("*.launch")})
        launches = [f"{self.share}/launch/{name}.launch {arguments}"
                    for name, more in cases.items() for arguments in more] + [str(self.root / "two_cells.launch")]
        output = subprocess.run(["python3", str(PACKAGE / "test/install/launch_nodes.py"), *launches], check=True,
                                env=self.environment, capture_output=True, text=True, timeout=120).stdout
        count, *missing = output.strip().splitlines()[-1].split()
        self.assertGreater(int(count), len(launches))
        # Nobody could see it, where there is no display: then it may be missing.
        self.assertEqual(set(missing) - {"rviz/rviz"}, set())

    def test_demo_prints_what_the_page_shows(self):
        environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        output = subprocess.run(command("demo"), shell=True, cwd=PACKAGE, env=environment, timeout=300, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
        shown = next(contents for language, contents in readme.blocks(readme.text())
                     if language == "text" and "poses in frame" in contents)
        for line in shown.strip().splitlines():
            self.assertTrue(any(self.is_alike(line, other) for other in output.splitlines()), f"{line}\n{output}")

    def is_alike(self, line, other):
        """The same words, and numbers that differ by no more than another processor's rounding may make."""
        number = re.compile(r"-?\d+\.\d+")
        if number.sub("#", " ".join(line.split())) != number.sub("#", " ".join(other.split())):
            return False
        return all(abs(float(a) - float(b)) <= 0.5 for a, b in zip(number.findall(line), number.findall(other)))

    def test_run_knows_its_words(self):
        self.assertRegex(subprocess.run(["./run"], cwd=PACKAGE, capture_output=True, text=True).stdout, r"\./run test")
        command("test")  # this is it

    def test_rosrun_knows_the_programs_of_the_checkout(self):
        environment = installed_environment(BUILD / "devel/setup.bash", self.root)
        for line in ("describe_part config/parts/bracket.yaml", "play_scene.py --help"):
            output = subprocess.run("rosrun planar_bin_picking " + line, shell=True, cwd=PACKAGE, env=environment, text=True,
                                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60, stdin=subprocess.DEVNULL)
            self.assertEqual(output.returncode, 0, output.stdout)

    def from_checkout(self, line):
        """A command that is called in the checkout, whose files it reads, with results elsewhere."""
        folder = self.root / "checkout"
        if not folder.exists():
            folder.mkdir()
            for name in ("build", "config", "test"):
                (folder / name).symlink_to(BUILD if name == "build" else PACKAGE / name)
        return f"cd {folder} && {line}"

    def test_locate_image_locates(self):
        output = subprocess.run(self.from_checkout(command("locate_image")), shell=True, check=True, text=True,
                                capture_output=True, timeout=120)
        folder = self.root / "checkout"
        result = yaml.safe_load((folder / "result.yaml").read_text())
        self.assertGreater(len(result["detections"]), 5)
        self.assertIn("bracket", output.stdout)
        self.assertEqual(cv2.imread(str(folder / "overlay.png")).shape, (2048, 2448, 3))

    def test_describe_part_prints_what_the_readme_shows(self):
        output = subprocess.run(self.from_checkout(command("describe_part")), shell=True, check=True, text=True,
                                capture_output=True, timeout=60).stdout
        self.assertIn(output, [contents for language, contents in readme.blocks(readme.text()) if language == "text"])

    def test_part_file_is_read_without_a_warning(self):
        program = self.prefix / "lib/planar_bin_picking/describe_part"
        output = subprocess.run([program, "parts/bracket.yaml"], cwd=self.root, env=self.environment, check=True, text=True,
                                capture_output=True, timeout=60).stdout
        self.assertIn("\npick_poses: [suction, suction_back]\n", output)
        self.assertIn("\nwarnings: []\n", output)

    def test_add_part_writes_a_part_to_begin_with(self):
        shutil.copy(PACKAGE / "config/parts/bracket.dxf", self.root / "lever.dxf")
        output = subprocess.run(self.here(command("add_part")), shell=True, check=True, text=True, env=self.environment,
                                capture_output=True, timeout=60).stdout
        self.assertIn("part: lever", output)
        for name in ("lever.dxf", "lever.yaml", "lever.png"):
            self.assertTrue((self.root / "parts" / name).exists(), name)

    def ask_robot_server(self, line, seconds=60.0):
        """Its answer's words, once it is up."""
        end = time.monotonic() + seconds
        while True:
            try:
                with socket.create_connection(("127.0.0.1", 5700), 30.0) as server:
                    server.sendall(line.encode() + b"\n")
                    return server.makefile().readline().split()
            except ConnectionRefusedError:
                self.assertLess(time.monotonic(), end)
                time.sleep(0.2)

    def test_cell_answers_with_the_pick_poses_of_the_part_file(self):
        with self.session() as session:
            session.start(f"rosrun planar_bin_picking play_scene.py {self.scene} "
                          "camera/image_raw:=/my_camera/image_raw camera/camera_info:=/my_camera/camera_info", "camera")
            session.start(self.here(command("cell")), "cell")
            session.wait_for("rosservice type /locator/locate_part", 60)
            answer = yaml.safe_load(session.run(command("locate")))
            self.assertIn("region_file", session.run(command("save_region")))  # this cell's file names none
            self.assertIn("success: True", session.run(command("clear_region")))
            self.assertIn("names no bin", session.run(command("locate_bin")))
            session.start(self.here(command("robot_server")), "robot_server")
            robot = self.ask_robot_server("locate bracket")
            session.start(self.here(command("teach")) + " rviz:=false", "teach")
            session.wait_for("rosservice call /teach/save | grep 'has these pick poses already'", 60)
            self.assertIn("success: True", session.run(command("rename")))
            session.run(command("tune"))
            saved = session.run(command("save_parameters"))
            checked = session.run(command("check_cell") + " --count 2 || true", 120)  # two say little about the spread
            tuned = yaml.safe_load((self.root / "cell.yaml").read_text())
        self.assertEqual(robot[0], "0", robot)
        self.assertIn("success: True", saved)
        self.assertEqual(tuned["pick"], {"score_min": 0.75, "max_parts": 3})
        self.assertIn("the report is check_cell.html", checked)
        self.assertGreater((self.root / "check_cell.html").stat().st_size, 10000)
        self.assertEqual(len(robot), 3 + 6 + 6 + 2)  # numbers, pose, approach, names
        self.assertEqual(answer["status"], 0, answer["message"])
        self.assertLessEqual(len(answer["parts"]), 3)
        given = yaml.safe_load((self.root / "parts/bracket.yaml").read_text())["pick_poses"]
        front = 1  # LocatedPart.FRONT
        for part in answer["parts"]:
            self.assertEqual(part["header"]["frame_id"], "base")
            up = "front" if part["face"] == front else "back"
            self.assertEqual([pick["name"] for pick in part["picks"]],
                             [pick["name"] for pick in given if pick["face"] == up])
            for pick in part["picks"]:
                q = pick["pose"]["orientation"]
                # The z axis points into the part, that is, down.
                self.assertLess(1 - 2 * (q["x"] ** 2 + q["y"] ** 2), -0.7)

    def test_calibration_ends_with_a_verdict(self):
        with self.session() as session:
            session.start("rosrun planar_bin_picking calibration_cell", "robot")
            session.start(self.here(command("calibrate")), "calibrator")
            session.wait_for("rosservice type /calibrator/plan", 60)
            self.assertIn("success: True", session.wait_for(command("plan") + " | grep -A1 True", 30))
            session.start(command("status"), "status")
            self.assertIn("success: True", session.run(command("start")))
            session.wait_for(f"grep waiting {self.root}/status.log", 120)
            self.assertIn("success: True", session.run(command("next")))
            session.wait_for(f"grep -E 'GOOD|POOR|REFUSED|ABORTED|FAILED' {self.root}/status.log", 120)
            self.assertIn("GOOD", (self.root / "status.log").read_text())
        written = {path.name for path in (self.root / "calibration").iterdir()}
        self.assertLessEqual({"camera_info.yaml", "hand_eye.yaml", "report.html"}, written)

    def test_samples_calibrate_without_ros(self):
        board_pictures.write(self.root)
        with self.session() as session:
            self.assertIn("GOOD", session.run(command("calibrate_samples")))
            self.assertIn("written to", session.run(command("draw_board")))
        self.assertTrue((self.root / "board.pdf").read_bytes().startswith(b"%PDF"))
        camera = yaml.safe_load((self.root / "out/camera_info.yaml").read_text())
        self.assertAlmostEqual(camera["camera_matrix"]["data"][0], board_pictures.FOCAL, delta=5)

    def test_cycle_demo_locates_parts(self):
        with self.session() as session:
            session.start(command("cycle_demo"), "cycle_demo")
            session.wait_for("rosservice type /locator/locate_part", 60)
            session.run("rostopic echo -n 1 /locator/located_parts/header", 120)

    def build(self, name, *targets):
        """Builds a package beside the installed one, and gives its build folder."""
        (self.root / name / "package.xml").write_text(MANIFEST.format(name))
        folder = self.root / f"build_{name}"
        with self.session() as session:
            session.run(f"cmake -S {name} -B {folder} -DPYTHON_EXECUTABLE=/usr/bin/python3", 120)
            session.run(f"cmake --build {folder} --target " + " ".join(targets), 300)
        return folder

    def test_own_bag_is_tested_from_a_package_of_its_own(self):
        with self.session() as session:
            session.run(self.here(command("play_scene")), 120)
        results = self.build("my_cell", "run_tests") / "test_results/my_cell"
        outcomes = {}
        for path in results.glob("rosunit-*.xml"):
            for case in ElementTree.parse(path).getroot().iter("testcase"):
                bad = case.find("failure") is not None or case.find("error") is not None
                outcomes[case.get("name")] = "failed" if bad else "passed"
        self.assertGreaterEqual(len(outcomes), 4, outcomes)
        self.assertEqual(set(outcomes.values()), {"passed"}, outcomes)

    def test_libraries_and_messages_serve_another_package(self):
        folder = self.root / "my_client"
        folder.mkdir()
        (folder / "CMakeLists.txt").write_text(CLIENT_CMAKE)
        (folder / "my_client.cpp").write_text(CLIENT_SOURCE)
        (folder / "hand_eye.yaml").write_text(HAND_EYE)
        program = self.build("my_client", "all") / "devel/lib/my_client/my_client"
        with self.session() as session:
            output = session.run(f"{program} parts/bracket.yaml my_client/hand_eye.yaml")
        self.assertEqual(output.strip(), "bracket eye planar_bin_picking/LocatePart")


if __name__ == "__main__":
    BUILD = Path(sys.argv.pop(1)).resolve()
    unittest.main()
