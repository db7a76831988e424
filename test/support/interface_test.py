#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""doc/interface.md is what the code says, and the code says it rightly. (operation_tester.py holds the locator's part
against the running node.)"""
import re
import unittest

import interface
from interface import PACKAGE


def code():
    """{path: text} of the nodes, but for the list of names."""
    return {path: path.read_text() for path in PACKAGE.glob("src/ros/**/*") if path.suffix in (".h", ".cpp")
            and path != PACKAGE / interface.NAMES}


class Structs(unittest.TestCase):
    BODY = """
  double a = 1.0, b = -2.0;  ///< of both,
                             ///< in metres
  /// Whose
  /// place it is.
  std::string frame = "base";
  std::vector<double> corner;
  bool is_it = false;
  InnerParams inner;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("a", self.a, 0.0, 1.0);
    visit("frame", self.frame);
    InnerParams::fields(self.inner, [&](const char* key, auto& member, auto min, auto max) {
      visit("inner/" + key, member, min, max);
    });
  }
"""

    def test_are_read_with_what_is_said_of_them(self):
        struct = interface.Struct(self.BODY)
        said = {name: (member.type, member.default, member.text) for name, member in struct.members.items()}
        self.assertEqual(said["a"], ("double", "1.0", "of both, in metres"))
        self.assertEqual(said["b"], ("double", "-2.0", "of both, in metres"))
        self.assertEqual(said["frame"], ("std::string", '"base"', "Whose place it is."))
        self.assertEqual(said["corner"], ("std::vector<double>", "", ""))
        self.assertEqual(struct.fields, [("a", "a", "0.0", "1.0"), ("frame", "frame", "", "")])
        self.assertEqual(struct.nested, [("InnerParams", "inner", "inner/")])


class Page(unittest.TestCase):
    def test_is_what_the_code_says(self):
        self.assertEqual((PACKAGE / interface.PAGE).read_text(), interface.page(),
                         "run: python3 test/support/interface.py --write")

    def test_has_every_parameter_that_the_code_reads(self):
        structs, _ = interface.read_headers(PACKAGE)
        for _, _, trees in interface.NODES.values():
            for _, struct in trees:
                self.assertTrue(interface.parameters(structs, struct), struct)
        keys = [key for key, *_ in interface.parameters(structs, "LocatorParams")]
        listed = re.findall(r"^(\w+):", (PACKAGE / "config/locator.yaml").read_text(), re.MULTILINE)
        self.assertEqual({key.split("/")[0] for key in keys}, set(listed))


class Names(unittest.TestCase):
    def setUp(self):
        self.names = [name for group in interface.read_names(PACKAGE).values() for name in group]
        self.code = code()

    def test_say_type_and_meaning_and_are_used(self):
        self.assertGreater(len(self.names), 25)
        everything = "\n".join(self.code.values())
        for constant, _, type_, text in self.names:
            self.assertRegex(type_, r"^\w+/\w+$", f"{interface.NAMES}: write '/// package/Type: what it is' above {constant}")
            self.assertTrue(text, constant)
            self.assertRegex(everything, rf"\b{constant}\b")

    def test_no_topic_or_service_has_another_name(self):
        for path, text in self.code.items():
            for name in re.findall(r"\badvertise(?:Service)?(?:<[^>]*>)?\(\s*([^,]+),", text):
                self.assertRegex(name, r"^(k\w+|name)$", path)

    def test_have_the_types_of_the_code(self):
        checked = 0
        for constant, _, type_, _ in self.names:
            for path, text in self.code.items():
                topic = re.search(rf"advertise<([\w:]+)>\(\s*{constant}\b", text)
                method = re.search(rf"{constant},\s*&\w+::(\w+)", text)
                if topic:
                    self.assertEqual(topic[1].split("::")[-1], type_.split("/")[1], constant)
                    checked += 1
                if method:
                    folder = "\n".join(other for place, other in self.code.items() if place.parent == path.parent)
                    signatures = " ".join(re.findall(rf"\bbool (?:\w+::)?{method[1]}\(([^)]*)\)", folder))
                    if "(Request&" in f"({signatures}":  # a name for one service's request
                        signatures += " ".join(re.findall(r"using Request = ([^;]*);", folder))
                    self.assertIn(type_.split("/")[1], signatures, constant)
                    checked += 1
        self.assertGreater(checked, 20)


if __name__ == "__main__":
    unittest.main()
