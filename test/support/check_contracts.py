#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Lists what messages, services and YAML files promise and no rostest or config test names, one a line:
check_contracts.py [PACKAGE_FOLDER]. Exit status 1 if there is any.

A field counts as named where a test of that message reads or sets it, a constant where a test compares
with it (or a .test expects its number), a key where a test sets it. Words in comments do not count."""
import re
import sys
from pathlib import Path

import yaml

from test_sources import flatten, read

# Which key of a tester's parameters holds which constants, by number.
EXPECTED = {"status": ("LocatePart", 1), "face": ("LocatePart", 0), "reason": ("RefusedPart", 0)}
# Structs of parameters, which a unit test of the wrapper may set in place of a tree.
STRUCTS = {"hdr.yaml": "HdrNodeParams", "cell.yaml": "CellParams", "calibrator.yaml": "CalibratorParams",
           "pick.yaml": "PickParams", "robot_server.yaml": "RobotServerParams"}
# Whatever provokes it through the interface is a fault to be mended.
UNREACHABLE = {f"{name}.srv response: constant INTERNAL_ERROR"
               for name in ("LocateBin", "LocatePart", "NextView", "RefinePart")}
PICK_KEYS = {"name", "face", "symmetric"}
PART_KEYS_IN = "src/core/part/part_file.cpp"


class Message:
    """A .msg, or one section of a .srv (0: request, 1: response)."""

    def __init__(self, path, section, text):
        self.name, self.is_service, self.section = path.stem, path.suffix == ".srv", section
        self.fields, self.constants = {}, {}  # field -> type; constant -> number
        for line in text.splitlines():
            constant = re.match(r"(\w+)\s+([A-Z][A-Z_0-9]*)\s*=\s*(\d+)", line)
            field = re.match(r"([\w/]+)(?:\[\d*\])?\s+([a-z]\w*)\s*(?:#|$)", line)
            if constant:
                self.constants[constant[2]] = int(constant[3])
            elif field:
                self.fields[field[2]] = field[1]

    @property
    def part(self):
        return ("Request", "Response")[self.section] if self.is_service else ""

    @property
    def label(self):
        return f"{self.name}.srv {self.part.lower()}" if self.is_service else f"{self.name}.msg"


def read_messages(package):
    messages = []
    for path in sorted([*package.glob("msg/*.msg"), *package.glob("srv/*.srv")]):
        for section, text in enumerate(re.split(r"^---$", path.read_text(), flags=re.MULTILINE)):
            messages.append(Message(path, section, text))
    return messages


def read_keys(package):
    """{file: {path of key}}, with those that are commented out, and with the lists that the code reads by."""
    keys = {}
    for path in sorted(package.glob("config/*.yaml")):
        text = path.read_text()
        tree = yaml.safe_load(text) or {}
        inner = {p for p, value in flatten(tree) if value is None}
        keys[path.name] = {p for p, _ in flatten(tree)} - inner
        keys[path.name] |= set(re.findall(r"^# (\w+): \S", text, re.MULTILINE))
    for path in package.glob("src/ros/**/*_params.h"):
        name = path.stem.replace("_node_params", "").replace("_params", "") + ".yaml"
        if name in keys:
            keys[name] |= set(re.findall(r'visit\("(\w+)"', path.read_text()))
    keys["a part's yaml"] = part_keys(package)
    return keys


def part_keys(package):
    """Of a part file and its pick poses, from the lists by which the code refuses unknown ones."""
    source = (package / PART_KEYS_IN).read_text()
    lists = re.findall(r"(?:refuseUnknownKeys\(\w+, \w+,|kKeys =)\s*\{([^}]*)\}", source)
    keys = {key for one in lists for key in re.findall(r'"(\w+)"', one)}
    if not {"drawing", "position_mm"} <= keys:
        raise LookupError(f"{PART_KEYS_IN} no longer has its lists of keys where this check looks for them")
    return keys


def read_tests(package):
    """(those that call the nodes, those of configuration and command line, data that they load, unit tests of
    the wrapper)."""
    ros = [package / "test/ros", package / "test/sim"]
    tests = [path for folder in ros for pattern in ("*.test", "*_tester.cpp", "*_tester.py", "fake_*.py", "*_node.cpp")
             for path in folder.glob(pattern)]
    tests += [path for folder in ros for path in folder.glob("*.py")
              if path not in tests and re.search(r"^\s*import (?:unittest|rostest)", path.read_text(), re.MULTILINE)]
    of_config = [*package.glob("test/ros/**/config_test.cpp"), *package.glob("test/ros/**/load_params_test.cpp"),
                 *package.glob("test/core/**/*_keys_test.cpp"), *package.glob("test/ros/**/*_keys_test.cpp"),
                 *package.glob("test/tools/*_test.cpp"), *package.glob("test/tools/*_test.py")]
    named = [read(path) for path in tests]
    # What testers import is a part of them.
    imported = set().union(*(one.identifiers for one in named))
    named += [read(path) for folder in ros for path in folder.glob("*.py") if path not in tests and path.stem in imported]
    texts = " ".join(text for one in named for text in one.texts)
    data = [path for path in [*package.glob("test/ros/**/*.y*ml"), *package.glob("test/sim/*.yaml"),
                              *package.glob("test/data/parts/*.yaml")]
            if path.name in texts or path.parent.name in texts]
    units = [read(path) for path in package.glob("test/ros/**/*_test.cpp")]
    return named, [read(path) for path in of_config], [read(path) for path in data], units


def is_about(named, message, messages):
    """Whether a file deals with a message: by its name, or by a field that holds it."""
    names = {message.name, message.name + message.part}
    holders = {field for other in messages for field, type_ in other.fields.items() if type_ == message.name}
    return bool(names & named.identifiers or holders & {field for _, field in named.fields})


def is_set(tests, key):
    return any(path.rsplit("/", 1)[-1] == key for named in tests for tree in named.trees for path in tree)


def names_field(named, message, field, in_both, tests):
    """In a file that is about the message. Where request and response share a name, the owner must say which;
    what a tester takes from a parameter of that name counts where a test sets that."""
    if field in named.parameters and not is_set(tests, field):
        return False
    owners = {owner for owner, name in named.fields if name == field}
    functions = {function for function, name in named.keywords if name == field}
    if not in_both:
        return bool(owners or functions)
    part = message.part.lower()
    return any(owner.lower().endswith(part) for owner in owners | functions)


def names_constant(named, message, constant, number):
    classes = {owner for owner, name in named.constants if name == constant}
    if ({message.name, message.name + message.part, message.part} - {""}) & classes:
        return True
    keys = {key for key, holder in EXPECTED.items() if holder == (message.name, message.section)}
    return any(path.rsplit("/", 1)[-1] in keys and value == number and type(value) is int
               for tree in named.trees for path, value in tree.items())


def names_key(named, key, known):
    """As a text with its path, or in a tree all of whose keys are known to this file."""
    if any(text == key or text.endswith("/" + key) for text in named.texts if not text.startswith("$")):
        return True
    # Inner nodes stand in a tree, too: "plane" above "plane/distance".
    nodes = known | {key[:key.index("/")] for key in known if "/" in key}
    return any(all(ends_in(path, nodes) for path in tree) and any(ends_in(path, {key}) for path in tree)
               for tree in named.trees)


def ends_in(path, keys):
    return any(path == key or path.endswith("/" + key) for key in keys)


def names_part_key(named, key, known):
    """In a tree all of whose keys are a part file's; name, face and the like count beside a position alone."""
    for tree in named.trees:
        words = {word for path in tree for word in path.split("/")}
        if key in words and words <= known and (key not in PICK_KEYS or "position_mm" in words):
            return True
    return False


def message_gaps(messages, tests):
    for message in messages:
        about = [named for named in tests if is_about(named, message, messages)]
        sections = [other for other in messages if other.name == message.name]
        for field in message.fields:
            in_both = sum(field in other.fields for other in sections) > 1
            if not any(names_field(named, message, field, in_both, tests) for named in about):
                yield f"{message.label}: field {field}"
        for constant, number in message.constants.items():
            if not any(names_constant(named, message, constant, number) for named in tests):
                yield f"{message.label}: constant {constant}"


def sets_in_struct(named, name, key):
    return STRUCTS.get(name) in named.identifiers and any(
        field == key and owner.rstrip("_") == "params" for owner, field in named.fields)


def key_gaps(keys, tests, units):
    for name, known in keys.items():
        for key in sorted(known):
            is_named = (any(names_part_key(named, key, known) for named in tests) if name == "a part's yaml"
                        else any(names_key(named, key, known) for named in tests)
                        or any(sets_in_struct(named, name, key) for named in units))
            if not is_named:
                yield f"{name}: key {key}"


def gaps(package):
    tests, of_config, data, units = read_tests(package)
    found = [*message_gaps(read_messages(package), tests),
             *key_gaps(read_keys(package), tests + of_config + data, units)]
    return [gap for gap in found if gap not in UNREACHABLE]


def main():
    package = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
    found = gaps(package)
    for gap in found:
        print(gap)
    if found:
        print(f"{len(found)} promises that no test names; write a test that fails when they are not kept")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
