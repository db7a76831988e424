#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Holds what is built against what may come into a process: check_linkage.py DEVEL_LIB_FOLDER

The locating library and the nodelets must bring neither Ceres, which Debian builds with GPL parts of
SuiteSparse, nor a GPL reader of drawings into a camera driver's process (doc/licences.md)."""
import re
import subprocess
import sys
from pathlib import Path

PACKAGE = "planar_bin_picking"
SOLVER = ["ceres", "cholmod", "spqr", "cxsparse", "umfpack", "amd", "camd", "colamd", "ccolamd", "suitesparseconfig"]
DRAWING_READERS = ["dxflib"]
IMAGE_FILES = ["gdal", "poppler", "opencv_imgcodecs"]  # the last brings the others in
RULES = {
    f"lib{PACKAGE}_core.so": SOLVER + DRAWING_READERS + IMAGE_FILES,
    # cv_bridge brings the reading of image files in, whoever uses it.
    f"lib{PACKAGE}_ros.so": SOLVER + DRAWING_READERS,
    f"lib{PACKAGE}_nodelets.so": SOLVER + DRAWING_READERS,
    f"{PACKAGE}/locator": SOLVER + DRAWING_READERS,
}
WITH_SOLVER = f"lib{PACKAGE}_calibration.so"


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def loaded(binary):
    """Names of all libraries that come along with one, without lib and version."""
    text = output_of("ldd", str(binary))
    if "not found" in text:
        raise RuntimeError(f"{binary}: ldd misses libraries:\n{text}")
    return set(re.findall(r"^\s*lib(\S+?)\.so", text, re.MULTILINE))


def has_solver_code(binary):
    """Ceres may also stand in a library itself: Debian has it as an archive, too."""
    return "ceres::" in output_of("nm", "-C", str(binary))


def faults(binary, forbidden):
    found = [f"loads lib{name}" for name in sorted(loaded(binary) & set(forbidden))]
    if has_solver_code(binary):
        found.append("has code of Ceres in it")
    return [f"{binary.name} {fault}" for fault in found]


def main():
    folder = Path(sys.argv[1])
    found = [fault for name, forbidden in RULES.items() for fault in faults(folder / name, forbidden)]
    # Who looks for Ceres must be able to find it.
    if not faults(folder / WITH_SOLVER, SOLVER):
        found.append(f"{WITH_SOLVER} seems to be free of Ceres: this check no longer sees it")
    for fault in found:
        print(fault)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
