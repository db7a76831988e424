#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The check of lengths counts the lines of functions of every form, and of nothing else."""
import tempfile
import unittest
from pathlib import Path

from check_length import FILE_MOST, FUNCTION_MOST, faults, functions


def lengths(text):
    return [(name, length) for name, _, length in functions(text)]


class Functions(unittest.TestCase):
    def test_forms_of_functions(self):
        for head in ("int f(int a)", "void A::f() const", "A::f(int a) : a_(a), b_{a}", "auto f() -> std::vector<int>",
                     "template <class T>\nT f(T a) noexcept", "TEST(A, f)", "bool f(int a,\n       int b) const override"):
            text = f"int before;\n{head} {{\n  call();\n  if (a) {{\n    b();\n  }}\n}}\n"
            self.assertEqual([length for _, length in lengths(text)], [6 + head.count("\n")], head)

    def test_it_begins_at_its_signature(self):
        text = "namespace {\n\nint f(int a,\n      int b) {\n  return a;\n}\n}\n"
        self.assertEqual(list(functions(text)), [("f", 3, 4)])

    def test_classes_and_tables_are_none(self):
        text = "class A : public B {\n public:\n  int get() const { return 1; }\n  int b_ = 1;\n};\n" \
               "const int kTable[] = {1,\n 2};\nenum class E { a, b };\nnamespace n {\nstruct S {\n  int a;\n};\n}\n"
        self.assertEqual(lengths(text), [("get", 1)])

    def test_a_lambda_belongs_to_its_function(self):
        text = "void f() {\n  const auto g = [&](int a) {\n    return a;\n  };\n  g(1);\n}\n"
        self.assertEqual(lengths(text), [("f", 6)])

    def test_braces_in_comments_and_texts_do_not_count(self):
        text = "void f() {\n  // {\n  say(\"}\", '{');\n  /* {\n */\n}\nvoid g() {}\n"
        self.assertEqual(lengths(text), [("f", 6), ("g", 1)])


class Faults(unittest.TestCase):
    def faults(self, files):
        with tempfile.TemporaryDirectory() as folder:
            for name, contents in files.items():
                path = Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(contents)
            return list(faults(Path(folder)))

    def test_a_function_of_one_line_too_many(self):
        for more, count in ((0, 0), (1, 1)):
            body = "  a();\n" * (FUNCTION_MOST - 2 + more)
            self.assertEqual(len(self.faults({"src/core/a.cpp": f"void f() {{\n{body}}}\n"})), count)

    def test_a_file_of_one_line_too_many(self):
        for name in ("src/a.cpp", "include/a.h", "test/core/a_test.cpp", "test/support/a.py", "run"):
            self.assertEqual(self.faults({name: "\n" * FILE_MOST}), [])
            self.assertEqual(len(self.faults({name: "\n" * (FILE_MOST + 1)})), 1, name)


if __name__ == "__main__":
    unittest.main()
