#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Counts the junit results below a folder, names what failed, and ends with the line of counts:
count_results.py FOLDER. Exit status 1 if anything failed or nothing ran."""
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def classify(case):
    if case.find("failure") is not None or case.find("error") is not None:
        return "failed"
    if case.find("skipped") is not None or case.get("status") == "notrun":
        return "skipped"
    return "passed"


def read(path):
    """(name, class) of every case in one file. A rostest's file repeats the cases of its tests, which
    have files of their own (rosunit-*); it counts as one case, so that a test that died is seen."""
    try:
        cases = [(f"{case.get('classname')}.{case.get('name')}", classify(case))
                 for case in ElementTree.parse(path).getroot().iter("testcase")]
    except ElementTree.ParseError as error:
        return [(f"{path.name}: {error}", "failed")]
    if not path.name.startswith("rostest-"):
        return cases
    failed = not cases or any(outcome == "failed" for _, outcome in cases)
    return [(path.stem, "failed" if failed else "passed")]


def main():
    results = [result for path in sorted(Path(sys.argv[1]).glob("**/*_results/**/*.xml"))
               for result in read(path)]
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for name, outcome in results:
        counts[outcome] += 1
        if outcome == "failed":
            print(f"failed: {name}")
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()))
    return 1 if counts["failed"] or not counts["passed"] else 0


if __name__ == "__main__":
    sys.exit(main())
