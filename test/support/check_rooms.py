#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Holds the include lines of src/core, src/ros and the public headers against the rule of the rooms, and lists
what breaks it, one a line: check_rooms.py [PACKAGE_FOLDER]. Exit status 1 if anything does.

A room is a folder. include/planar_bin_picking/part and src/core/part are one room. A unit is X.h and X.cpp of a
room, wherever the header stands."""
import re
import sys
from pathlib import Path

# --- the rule ------------------------------------------------------------------------------------
# What each room includes besides itself. Anything else is an arrow against the data's way.
BELOW_PART = {"base", "drawing"}
BELOW_IMAGE = BELOW_PART | {"part", "params"}
BELOW_STAGES = BELOW_IMAGE | {"camera", "image"}
STAGES = {"locate/vote", "locate/refine", "locate/judge"}
BELOW_LOCATOR = BELOW_STAGES | STAGES | {"locate/evidence", "locate/prior", "locate/align"}
MAY_INCLUDE = {
    "base": set(),
    "drawing/dxf": {"base"},
    "drawing": {"base", "drawing/dxf"},
    "part": BELOW_PART,
    "teach": BELOW_PART | {"part"},  # pick poses that a person sets
    "params": {"base"},
    "camera": {"base"},
    "image": BELOW_IMAGE | {"camera"},
    "locate/evidence": BELOW_STAGES,
    "locate/prior": BELOW_STAGES | {"locate/evidence"},  # what is known besides the image
    "locate/align": BELOW_STAGES,  # one pose to the distance field, and to the image
    **{stage: BELOW_STAGES | {"locate/evidence", "locate/prior", "locate/align"} for stage in STAGES},  # none includes another
    "locate": BELOW_LOCATOR,
    "bin": BELOW_LOCATOR | {"locate"},  # its floor, its region, and its rim, which is located as a part
    "views": BELOW_LOCATOR | {"locate"},
    "pick": BELOW_LOCATOR | {"locate"},
    "robot": {"base"},  # what robot controllers are sent
    "snapshot": BELOW_LOCATOR | {"locate"},
    "show": BELOW_LOCATOR | {"locate"},
    "calibrate/board": {"base", "camera"},
    "calibrate/hand_eye": {"base", "camera", "calibrate/board"},
    "calibrate": {"base", "camera", "calibrate/board", "calibrate/hand_eye"},
    # src/ros; of the core, the nodes include what they need.
    "ros/shared": set(),
    "ros/input": {"ros/shared"},
    "ros/locator/answer": {"ros/shared", "ros/input"},
    "ros/locator/parts": {"ros/shared"},
    "ros/locator/health": {"ros/shared", "ros/input", "ros/hand_eye", "ros/locator/parts", "ros/locator/settings"},
    "ros/locator/bin": {"ros/shared", "ros/input"},
    "ros/locator/region": {"ros/shared", "ros/locator/answer"},
    "ros/locator/snapshot": {"ros/shared", "ros/input", "ros/locator/answer", "ros/locator/parts", "ros/locator/settings"},
    "ros/locator/views": {"ros/shared", "ros/input", "ros/locator/answer"},
    "ros/locator/settings": {"ros/shared"},
    "ros/locator": {"ros/shared", "ros/input", "ros/locator/answer", "ros/locator/bin", "ros/locator/parts", "ros/locator/snapshot",
                    "ros/locator/health", "ros/locator/region", "ros/locator/settings", "ros/locator/views"},
    "ros/hdr": {"ros/shared", "ros/input"},
    "ros/calibrator": {"ros/shared", "ros/input"},
    "ros/hand_eye": {"ros/shared"},
    "ros/robot_server": {"ros/shared"},
    "ros/teach": {"ros/shared"},
}
# Units that others may include without the rest of their room, as if these were rooms of their own.
OWN_ROOM = {
    "image/camera": "camera", "image/camera_file": "camera", "image/grey": "camera",  # for the calibration, too
    "locate/params": "params",  # of all stages
}
UNITS_MAX = 12
# A main or a nodelet stands for itself.
WITHOUT_HEADER = re.compile(r"_(node|nodelet)$")
# Faults that are known, each as it is printed. Whoever mends one takes it out; the list ends empty.
KNOWN = set()

# --- the check -----------------------------------------------------------------------------------
ROOTS = {"include/planar_bin_picking": "", "src/core": "", "src/ros": "ros/"}
INCLUDE = re.compile(r'^ *# *include *"([^"]+)"', re.MULTILINE)


def unit_of(path, package):
    """include/planar_bin_picking/part/part_model.h and src/core/part/part_model.cpp are part/part_model."""
    for root, prefix in ROOTS.items():
        if (package / root) in path.parents:
            return prefix + path.relative_to(package / root).with_suffix("").as_posix()
    raise LookupError(f"{path} stands below none of {', '.join(ROOTS)}")


def folder_of(unit):
    return unit.rpartition("/")[0]


def room_of(unit):
    return OWN_ROOM.get(unit, folder_of(unit))


def sources(package):
    return sorted(path for root in ROOTS for path in (package / root).rglob("*") if path.suffix in (".h", ".cpp"))


def included_unit(name, including, known):
    """The unit that an include line names; the wrapper's own files come before the core's."""
    stem = re.sub(r"^planar_bin_picking/", "", name)
    stem = re.sub(r"\.h$", "", stem)
    if including.startswith("ros/") and not name.startswith("planar_bin_picking/"):
        stem = "ros/" + stem
    return stem if stem in known else None


def read_units(package):
    """({unit: {unit that it includes}}, faults)."""
    files = {path: unit_of(path, package) for path in sources(package)}
    known = set(files.values())
    units, faults = {unit: set() for unit in known}, []
    for path, unit in files.items():
        for name in INCLUDE.findall(path.read_text()):
            other = included_unit(name, unit, known)
            if other is None:
                faults.append(f"{path.relative_to(package)}: \"{name}\" is no header of this package")
            elif other != unit:
                units[unit].add(other)
    return units, faults


def arrow_faults(units):
    for unit, others in sorted(units.items()):
        room = room_of(unit)
        if room not in MAY_INCLUDE:
            yield f"{unit}: the rule knows no room '{room}'"
            continue
        for other in sorted(others):
            of_core = room.startswith("ros/") and not other.startswith("ros/")
            if not of_core and room_of(other) not in MAY_INCLUDE[room] | {room}:
                yield f"{unit} includes {other}: against the way from room {room_of(other)} to {room}"


def circles(units):
    """Sets of units each of which includes each other one, at last (Tarjan's strongly connected components)."""
    index, low, stack, found = {}, {}, [], []

    def visit(unit):
        index[unit] = low[unit] = len(index)
        stack.append(unit)
        for other in sorted(units[unit]):
            if other not in index:
                visit(other)
            if other in stack:
                low[unit] = min(low[unit], low[other])
        if low[unit] == index[unit]:
            at = stack.index(unit)
            found.append(sorted(stack[at:]))
            del stack[at:]

    for unit in sorted(units):
        if unit not in index:
            visit(unit)
    return sorted(group for group in found if len(group) > 1)


def room_faults(units):
    rooms = {}
    for unit in units:
        rooms.setdefault(folder_of(unit), []).append(unit)
    for room, inside in sorted(rooms.items()):
        if len(inside) > UNITS_MAX:
            yield f"room {room} has {len(inside)} units; {UNITS_MAX} are the most"


def header_faults(package):
    """What is defined in X.cpp is declared in X.h, which X.cpp includes first."""
    for path in sources(package):
        if path.suffix != ".cpp" or WITHOUT_HEADER.search(path.stem):
            continue
        first = INCLUDE.search(path.read_text())
        unit = unit_of(path, package)
        headers = {f"planar_bin_picking/{unit}.h", re.sub("^ros/", "", unit) + ".h"}
        if not first or first[1] not in headers:
            yield f"{path.relative_to(package)} does not begin with a header of its own name"


def all_faults(package):
    units, faults = read_units(package)
    faults += arrow_faults(units)
    faults += [f"circle: {' <-> '.join(group)}" for group in circles(units)]
    return faults + [*room_faults(units), *header_faults(package)]


def check(package, known):
    found = all_faults(package)
    mended = [f"no longer so, take it out of KNOWN: {fault}" for fault in sorted(known - set(found))]
    return [fault for fault in found if fault not in known] + mended


def main():
    package = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2]
    found = check(package, KNOWN)
    for fault in found:
        print(fault)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
