#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The check of contracts finds what no test names, and is not satisfied by words that merely stand there."""
import tempfile
import unittest
from pathlib import Path

from check_contracts import gaps

MESSAGE = "uint8 GOOD = 0  # a comment with spoiled: in it\nuint8 BAD = 1\nuint8 state\nfloat64 width  # of it\n"
SERVICE = "string what\nfloat64 amount\n---\nuint8 OK = 0\nuint8 LOST = 7\nuint8 status\nfloat64 amount\nMade[] made\n"
CONFIG = "rate: 1.0   # Hz\nlamp:\n  power: 2\n# port: 3\n"
SOURCE = 'kKeys = {"drawing", "colour", "pick_poses"};\nrefuseUnknownKeys(node, where,\n   {"position_mm"});'

# Names each of them.
TESTER = """
#include <Made.h>
void test(const Ask::Request& request, const Ask::Response& response) {
  request.what = "x";  request.amount = 2;
  EXPECT_EQ(response.status, Ask::Response::OK);  EXPECT_EQ(response.status, Ask::Response::LOST);
  EXPECT_EQ(response.amount, 1);
  EXPECT_EQ(response.made[0].state, Made::GOOD);  EXPECT_EQ(made->state, Made::BAD);
  EXPECT_GT(response.made[0].width, 0);
}
"""
LAUNCH = """<launch>
  <rosparam ns="node">{rate: 2.0, port: 4}</rosparam>
  <param name="node/lamp/power" value="3"/>
  <arg name="parts" value="parts_here"/>
</launch>
"""
PART = "drawing: a.dxf\ncolour: red\npick_poses: [{position_mm: [0, 0, 0]}]\n"


class Contracts(unittest.TestCase):
    def gaps_of(self, **changed):
        files = {"msg/Made.msg": MESSAGE, "srv/Ask.srv": SERVICE, "config/node.yaml": CONFIG,
                 "src/core/part/part_file.cpp": SOURCE, "test/ros/x_tester.cpp": TESTER, "test/ros/x.test": LAUNCH,
                 "test/ros/parts_here/a.yaml": PART}
        files.update({name: contents for name, contents in changed.pop("files", {}).items()})
        with tempfile.TemporaryDirectory() as folder:
            for name, contents in files.items():
                path = Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(contents)
            return gaps(Path(folder))

    def without(self, name, text, old, new=""):
        self.assertIn(old, text)
        return self.gaps_of(files={name: text.replace(old, new)})

    def test_names_of_everything_leave_no_gap(self):
        self.assertEqual(self.gaps_of(), [])

    def test_a_made_up_field_is_a_gap(self):
        self.assertEqual(self.gaps_of(files={"msg/Made.msg": MESSAGE + "float64 depth\n"}), ["Made.msg: field depth"])

    def test_a_made_up_constant_is_a_gap(self):
        self.assertEqual(self.gaps_of(files={"srv/Ask.srv": SERVICE.replace("LOST = 7", "LOST = 7\nuint8 LATE = 8")}),
                         ["Ask.srv response: constant LATE"])

    def test_a_made_up_key_is_a_gap(self):
        for more, gap in (("depth: 1\n", "depth"), ("# depth: 1\n", "depth"), ("fan:\n  power: 2\n", "fan/power")):
            self.assertEqual(self.gaps_of(files={"config/node.yaml": CONFIG + more}), [f"node.yaml: key {gap}"])

    def test_a_made_up_key_of_a_part_is_a_gap(self):
        self.assertEqual(self.gaps_of(files={"src/core/part/part_file.cpp": SOURCE.replace("colour", "colour\", \"depth")}),
                         ["a part's yaml: key depth"])

    def test_words_in_comments_do_not_count(self):
        for comment in ("// response.made[0].width Made::BAD", "/* made.width */", '// "width"'):
            found = self.without("test/ros/x_tester.cpp", TESTER, "EXPECT_GT(response.made[0].width, 0);", comment)
            self.assertEqual(found, ["Made.msg: field width"])
        found = self.without("test/ros/x.test", LAUNCH, '<param name="node/lamp/power" value="3"/>',
                             "<!-- node/lamp/power: 3 -->")
        self.assertEqual(found, ["node.yaml: key lamp/power"])
        found = self.without("test/ros/parts_here/a.yaml", PART, "colour: red", "# colour: red")
        self.assertEqual(found, ["a part's yaml: key colour"])

    def test_docstrings_and_comments_of_python_do_not_count(self):
        python = '"""made.width"""\nimport unittest\nfrom x import Made\n# made.width\ndef f():\n    """made.width"""\n'
        text = TESTER.replace("EXPECT_GT(response.made[0].width, 0);", "")
        files = {"test/ros/x_tester.cpp": text, "test/ros/y.py": python}
        self.assertEqual(self.gaps_of(files=files), ["Made.msg: field width"])
        files["test/ros/y.py"] = python + "    return Made().width\n"
        self.assertEqual(self.gaps_of(files=files), [])

    def test_the_field_of_another_message_does_not_count(self):
        text = TESTER.replace("EXPECT_GT(response.made[0].width, 0);", "")
        other = "#include <Other.h>\nint f(const Other& other) { return other.width; }\n"
        self.assertEqual(self.gaps_of(files={"test/ros/x_tester.cpp": text, "test/ros/y_tester.cpp": other}),
                         ["Made.msg: field width"])

    def test_request_and_response_are_told_apart(self):
        self.assertEqual(self.without("test/ros/x_tester.cpp", TESTER, "EXPECT_EQ(response.amount, 1);"),
                         ["Ask.srv response: field amount"])

    def test_a_parameter_that_no_test_sets_does_not_count(self):
        text = TESTER.replace('request.what = "x"', 'request.what = params.param("what", "")')
        self.assertEqual(self.gaps_of(files={"test/ros/x_tester.cpp": text}), ["Ask.srv request: field what"])
        launch = LAUNCH.replace("</launch>", '<param name="what" value="y"/></launch>')
        self.assertEqual(self.gaps_of(files={"test/ros/x_tester.cpp": text, "test/ros/x.test": launch}), [])

    def test_a_struct_that_a_unit_test_sets_counts(self):
        text = "void f() { HdrNodeParams params_; params_.depth = 2; }\n"
        files = {"config/hdr.yaml": "depth: 1\n"}
        self.assertEqual(self.gaps_of(files=files), ["hdr.yaml: key depth"])
        self.assertEqual(self.gaps_of(files={**files, "test/ros/z_test.cpp": text}), [])
        other = text.replace("HdrNodeParams", "OtherParams")
        self.assertEqual(self.gaps_of(files={**files, "test/ros/z_test.cpp": other}), ["hdr.yaml: key depth"])

    def test_aliases_of_python_are_followed(self):
        text = TESTER.replace("EXPECT_EQ(response.status, Ask::Response::LOST);", "")
        self.assertNotEqual(text, TESTER)
        python = "import unittest\nfrom x import AskResponse{}\nassert {}.LOST\n"
        for name, owner in (("", "AskRequest"), (" as Status", "Status"), ("\nStatus = AskResponse", "Status")):
            found = ["Ask.srv response: constant LOST"] if owner == "AskRequest" else []
            files = {"test/ros/x_tester.cpp": text, "test/ros/y.py": python.format(name, owner)}
            self.assertEqual(self.gaps_of(files=files), found)

    def test_an_argument_of_a_launch_file_sets_its_parameter(self):
        launch = '<launch><arg name="to"/><param name="node/port" value="$(arg to)/x"/></launch>'
        include = '<include file="$(find here)/launch/node.launch">{}</include>'
        for argument, found in (("", ["node.yaml: key port"]), ('<arg name="to" value="y"/>', [])):
            text = LAUNCH.replace(", port: 4", "").replace("</launch>", include.format(argument) + "</launch>")
            self.assertEqual(self.gaps_of(files={"test/ros/x.test": text, "launch/node.launch": launch}), found)

    def test_texts_that_are_no_honest_yaml_do_no_harm(self):
        deep = "[" * 5000
        text = TESTER + 'const char* a = "&a {b: *a}"; const char* c = "c: ' + deep + '"; const char* d = "d: \x01";'
        self.assertEqual(self.gaps_of(files={"test/ros/x_tester.cpp": text}), [])

    def test_the_same_word_in_another_tree_does_not_count(self):
        self.assertEqual(self.without("test/ros/x.test", LAUNCH, "{rate: 2.0, port: 4}", "{rate: 2.0, service: 4}"),
                         ["node.yaml: key port", "node.yaml: key rate"])


if __name__ == "__main__":
    unittest.main()
