#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""doc/interface.md out of the code: topics and services of all nodes from src/ros/shared/names.h, parameters from their
structs. Prints the page; with --write it replaces the file. interface_test.py holds the page against the code."""
import re
import sys
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
PAGE = "doc/interface.md"
NAMES = "src/ros/shared/names.h"
SOURCES = "https://docs.ros.org/en/noetic/api/"

# node: (what it is, heading of its names in names.h, [(tree of parameters, its struct)])
NODES = {
    "locator": ("Nodelet `planar_bin_picking/Locator`, node `locator`", "The locator's",
                [("~cell", "CellParams"), ("~pick", "PickParams"), ("~locator", "LocatorParams")]),
    "hdr": ("Nodelet `planar_bin_picking/Hdr`", "The HDR node's", [("~hdr", "HdrNodeParams")]),
    "calibrator": ("Node `calibrator`", "The calibrator's", [("~calibrator", "CalibratorParams")]),
    "teach": ("Node `teach`", "The teaching node's", []),
    "robot_server": ("Node `robot_server`", None, [("~server", "RobotServerParams")]),
}
TYPE = re.compile(r"double|int|bool|std::string|std::vector<double>")
MEMBER = re.compile(r"^ *(?!using|return|static|template|const )([\w:]+(?:<\w+>)?) (\w[^;()]*);(?: *///< (.*))?$")


class Member:
    def __init__(self, type_, default, text):
        self.type, self.default, self.text = type_, default, text


class Struct:
    """A struct of parameters: its members, and the list of fields below it."""

    def __init__(self, body):
        self.members = {}
        self.fields = re.findall(r'visit\("([\w/]+)", self\.([\w.]+)(?:,\s*([^,()]+),\s*([^,()]+))?\)', body)
        self.nested = [(name, member, (re.findall(r'visit\("(\w+/)" \+ key', rest[:200]) or [""])[0])
                       for name, member, rest in re.findall(r"(\w+)::fields\(\s*self\.(\w+)(.{0,300})", body, re.DOTALL)]
        self.read_members(body)

    def read_members(self, body):
        before, latest = [], []
        for line in re.sub(r"=\n\s*", "= ", body).splitlines():
            comment, member = re.match(r"^ *///<? ?(.*)$", line), MEMBER.match(line)
            if comment and "///<" in line:
                for one in latest:
                    one.text += " " + comment[1]
            elif comment:
                before.append(comment[1])
            elif member:
                text = member[3] or " ".join(before)
                latest = []
                for part in re.split(r",\s*(?![^{]*\})", member[2]):
                    name, _, default = part.partition(" = ")
                    self.members[name.strip()] = Member(member[1], default.strip(), text)
                    latest.append(self.members[name.strip()])
                before = []
            elif line.strip():
                before, latest = [], []
            else:
                before = []


def body_at(text, start):
    """From an opening brace to its end."""
    depth = 0
    for i in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[i], 0)
        if depth == 0:
            return text[start:i]
    raise ValueError("a struct without an end")


def read_headers(package):
    """({name: Struct}, {constant: value})."""
    structs, constants = {}, {}
    for path in sorted([*package.glob("include/**/*.h"), *package.glob("src/ros/**/*.h")]):
        text = path.read_text()
        constants.update(re.findall(r"constexpr \w+ (k\w+) =\s*([-\d.e]+);", text))
        for match in re.finditer(r"^ *struct (\w+) \{", text, re.MULTILINE):
            structs.setdefault(match[1], Struct(body_at(text, match.end() - 1)))
    return structs, constants


def last(name):
    return name.rsplit("::", 1)[-1]


def parameters(structs, name, prefix=""):
    """[(key, Member, min, max)] of a struct and of those in it."""
    struct = structs[name]
    found = []
    for key, path, low, high in struct.fields:
        owner, *rest = path.split(".")
        member = struct.members[owner]
        for step in rest:
            member = structs[last(member.type)].members[step]
        found.append((prefix + key, member, low.strip(), high.strip()))
    for _, member, inner in struct.nested:
        found += parameters(structs, last(struct.members[member].type), prefix + inner)
    if name == "LocatorParams":  # its list is a function of its own
        for member, one in struct.members.items():
            if last(one.type) in structs:
                found += parameters(structs, last(one.type), f"{member}/")
            else:
                found.append((member, one, "0", "64"))
    return found


def read_names(package):
    """{heading: [(constant, name, type, text)]} of topics and services."""
    groups, heading, comment = {}, "", []
    for line in (package / NAMES).read_text().splitlines():
        section = re.match(r"// (The [\w ]+'s),", line)
        name = re.match(r'constexpr char (k\w+(?:Service|Topic))\[\] = "([\w/]+)";$', line)
        if section:
            heading = section[1]
        elif line.startswith("/// "):
            comment.append(line[4:])
            continue
        elif name:
            type_, _, text = " ".join(comment).partition(": ")
            groups.setdefault(heading, []).append((name[1], name[2], type_, text))
        comment = []
    return groups


def type_link(type_):
    package, _, name = type_.partition("/")
    if package != "planar_bin_picking":
        return f"`{type_}`"
    folder = "srv" if (PACKAGE / f"srv/{name}.srv").exists() else "msg"
    return f"[`{name}`](../{folder}/{name}.{folder})"


def cell_text(text):
    return " ".join(text.replace("|", "\\|").split())


def value_text(member, constants):
    default = constants.get(last(member.default), member.default).replace('"', "'")
    if not default:
        default = {"std::string": "''", "std::vector<double>": "[]"}.get(member.type, "")
    return default.replace("{", "[").replace("}", "]")


def page(package=PACKAGE):
    structs, constants = read_headers(package)
    names = read_names(package)
    lines = ["# All topics, services and parameters", "",
             "Made from the code by `python3 test/support/interface.py --write`; a test holds it against the code. [Nodes](nodes.md) says "
             "what belongs together, and the comments in [`config`](../config) say more about each parameter. `~` is the node's name.", ""]
    for title, heading, trees in NODES.values():
        lines += [f"## {title}", ""]
        if heading:
            lines += ["| name | type | |", "|---|---|---|"]
            lines += [f"| `{name}` | {type_link(type_)} | {cell_text(text)} |" for _, name, type_, text in names[heading]]
            lines += [""]
        for tree, struct in trees:
            lines += [f"| parameter, below `{tree}` | default | allowed | |", "|---|---|---|---|"]
            for key, member, low, high in parameters(structs, struct):
                allowed = f"{low} .. {high}" if low and member.type != "bool" else ""
                lines.append(f"| `{key}` | `{value_text(member, constants)}` | {allowed} | {cell_text(member.text)} |")
            lines += [""]
    return "\n".join(lines).rstrip() + "\n"


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        (PACKAGE / PAGE).write_text(page())
    else:
        print(page(), end="")
