#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Compares a result of locate_image with the truth of the embedded scene and fails below the floor:
accuracy_floor.py TRUTH.yaml RESULT.yaml. The floor has slack: it is there to catch what breaks, while
test/benchmark/scenes.py is what accuracy is measured with. For parts without symmetry."""
import sys

import numpy
import yaml

# A detection is right within these, as the benchmark has it.
LATERAL_MM, DEPTH_MM, ANGLE_DEG, TILT_DEG = 2.0, 8.0, 2.0, 6.0
PICKABLE = 0.95  # visible fraction of a part that nothing covers

FLOOR = {"first match right": 1.0, "precision": 0.9, "recall": 0.6}
CEILING = {"lateral mm": 0.3, "depth mm": 4.0, "angle deg": 0.2, "tilt deg": 2.0}  # medians


def rotation(q):
    x, y, z, w = numpy.array(q) / numpy.linalg.norm(q)
    return numpy.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def errors(found, true, center):
    """Lateral and depth in mm at the part's centre, in-plane angle and tilt in degrees."""
    R_found, R_true = rotation(found["orientation"]), rotation(true["orientation"])
    p_true = R_true @ center + true["position"]
    offset = R_found @ center + found["position"] - p_true
    depth = offset @ p_true / numpy.linalg.norm(p_true)
    lateral = numpy.sqrt(max(0.0, offset @ offset - depth ** 2))
    turn = R_true.T @ R_found
    angle = numpy.degrees(numpy.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1]))
    tilt = numpy.degrees(numpy.arccos(numpy.clip(turn[2, 2], -1.0, 1.0)))
    return numpy.array([1e3 * lateral, 1e3 * abs(depth), abs(angle), tilt])


def match(detections, truth):
    """For each detection its errors, or None where no part lies there that is still free."""
    free, matched = list(truth["parts"]), []
    for found in detections:
        best = None
        for true in free:
            if (true["part"], true["face"]) != (found["part"], found["face"]):
                continue
            error = errors(found, true, numpy.array(truth["center"]))
            right = numpy.all(error <= [LATERAL_MM, DEPTH_MM, ANGLE_DEG, TILT_DEG])
            if right and (best is None or error[0] < best[1][0]):
                best = (true, error)
        if best:
            free.remove(best[0])
        matched.append(best)
    return matched


def main():
    with open(sys.argv[1]) as truth_file, open(sys.argv[2]) as result_file:
        truth, detections = yaml.safe_load(truth_file), yaml.safe_load(result_file)["detections"]
    matched = match(detections, truth)
    right = [m for m in matched if m]
    pickable = [p for p in truth["parts"] if p["visible"] >= PICKABLE]
    found_pickable = [m for m in right if m[0]["visible"] >= PICKABLE]
    values = {"first match right": float(bool(matched and matched[0])),
              "precision": len(right) / len(matched) if matched else 0.0,
              "recall": len(found_pickable) / len(pickable)}
    medians = numpy.median([m[1] for m in right], axis=0) if right else [numpy.inf] * 4
    ok = True
    for name, value in values.items():
        good = value >= FLOOR[name]
        ok &= good
        print(f"{name:<18}{value:8.3f}  at least {FLOOR[name]}{'' if good else '  FAILED'}")
    for name, value in zip(CEILING, medians):
        good = value <= CEILING[name]
        ok &= good
        print(f"median {name:<11}{value:8.3f}  at most {CEILING[name]}{'' if good else '  FAILED'}")
    return 0 if ok else 1


if __name__ == "__main__":
    sys.exit(main())
