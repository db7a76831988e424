#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Lists files of more than 400 lines, and functions of C++ of more than 60: check_length.py [PACKAGE_FOLDER].
Exit status 1 if there is any.

A function is a `{` that follows a parameter list (with whatever may stand after one), up to its `}`. Lambdas belong to
the function that they stand in. It needs the house's format, no parser: clang-tidy takes minutes for the same."""
import re
import sys
from pathlib import Path

FILE_MOST, FUNCTION_MOST = 400, 60

COMMENT_OR_TEXT = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)
# What may stand between a function's parameters and its body.
AFTER_PARAMETERS = re.compile(r"\)(?:\s*(?:const|noexcept|override|final|mutable|->[\w:<>,\s*&]+?))*\s*$")
INITIALISERS = re.compile(r"\)\s*(?:noexcept\s*)?:(?!:)[^;]*$")
NO_FUNCTION = re.compile(r"\b(?:if|for|while|switch|catch)\b[^;{}]*$|\belse\s*$|\bdo\s*$")


def without_comments(text):
    """And without labels of access and braces about a member's first value; of the same number of lines."""
    text = COMMENT_OR_TEXT.sub(lambda match: "\n" * match[0].count("\n"), text)
    text = re.sub(r"\b(?:public|private|protected):", "", text)
    return re.sub(r"\w\{[^{}]*\}", lambda match: "()" + "\n" * match[0].count("\n"), text)


def opens_function(head):
    """Whether the `{` after this text, which begins after the last `;`, `{` or `}`, opens a function's body."""
    if NO_FUNCTION.search(head) or re.search(r"=\s*$|\]\s*(?:\([^()]*\))?\s*$", head):
        return False
    return bool(AFTER_PARAMETERS.search(head) or INITIALISERS.search(head))


def functions(text):
    """(name, first line, lines) of each function, its signature included."""
    text = without_comments(text)
    depth, start, head_from, name = 0, None, 0, ""
    for match in re.finditer(r"[{};]", text):
        at, mark = match.start(), match[0]
        head = text[head_from:at]
        if mark == "{":
            depth += 1
            if start is None and opens_function(head):
                begins = head_from + len(head) - len(head.lstrip())
                start, outside = begins, depth - 1
                found = re.search(r"([\w:~]+)\s*\(", head)
                name = found[1] if found else "?"
        elif mark == "}":
            depth -= 1
            if start is not None and depth == outside:
                first = text.count("\n", 0, start) + 1
                yield name, first, text.count("\n", 0, at) + 2 - first
                start = None
        head_from = at + 1


def faults(package):
    cpp = sorted(path for folder in ("src", "include", "test") for pattern in ("*.h", "*.cpp")
                 for path in (package / folder).rglob(pattern))
    others = sorted([*package.glob("test/**/*.py"), *package.glob("launch/**/*.py"), *package.glob("**/CMakeLists.txt")])
    others = [path for path in [*others, package / "run"] if path.exists() and "build" not in path.parts]
    for path in [*cpp, *others]:
        text = path.read_text()
        lines = text.count("\n")
        if lines > FILE_MOST:
            yield f"{path.relative_to(package)} has {lines} lines; {FILE_MOST} are the most"
        for name, first, length in functions(text) if path in cpp else []:
            if length > FUNCTION_MOST:
                yield f"{path.relative_to(package)}:{first}: {name} has {length} lines; {FUNCTION_MOST} are the most"


def main():
    package = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
    found = list(faults(package))
    for fault in found:
        print(fault)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
