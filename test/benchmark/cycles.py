#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Counts pick cycles on the simulated cell: every part under every light, through the real nodes and
services, and prints the table.

    ./run bench cycles [--cycles 100] [--parts bracket linkarm ...] [--lights diffuse ring side]
    ./run bench cycles --empty --cycles 400     bins are emptied as far as it goes
    ./run bench cycles --bayer RGGB --jpeg-quality 90     a colour camera's demosaiced pictures, through JPEG

Each row is one run of launch/cycle_demo.launch with a ROS master of its own. Results stay in
build/bench/cycles/; --keep prints those that are there and runs the rest.
"""
import argparse
import os
import socket
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PARTS = ("bracket", "linkarm", "sprocket", "hinge", "block")
LIGHTS = ("diffuse", "ring", "side")
SECONDS_PER_CYCLE = 60.0  # far more than any; a run that hangs must end


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cycles", type=int, default=100, help="of each part under each light")
    parser.add_argument("--parts", nargs="+", default=PARTS)
    parser.add_argument("--lights", nargs="+", default=LIGHTS)
    parser.add_argument("--count", type=int, default=20, help="parts in a full bin")
    parser.add_argument("--seed", type=int, default=1, help="of the first bin; the next has the next")
    parser.add_argument("--megapixels", type=float, default=5.0)
    parser.add_argument("--bayer", default="", help="pattern of a colour camera's filters, such as RGGB")
    parser.add_argument("--jpeg-quality", type=int, default=0, help="1 to 100; 0: no JPEG")
    parser.add_argument("--empty", action="store_true", help="empty each bin as far as it goes")
    parser.add_argument("--keep", action="store_true", help="do not run again what has a result")
    parser.add_argument("--save", type=Path, help="folder for pictures and truth of what went wrong")
    parser.add_argument("--output", type=Path, default=ROOT / "build/bench/cycles")
    return parser.parse_args()


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def run(part, light, result, arguments):
    port = free_port()
    refill = 0 if arguments.empty else 8
    save = f" --save {arguments.save.resolve() / light}" if arguments.save else ""
    command = ["roslaunch", "-p", str(port), "planar_bin_picking", "cycle_demo.launch", "rviz:=false",
               f"part:={part}", f"light:={light}", f"count:={arguments.count}",
               f"seed:={arguments.seed}", f"megapixels:={arguments.megapixels}",
               f"bayer:={arguments.bayer}", f"jpeg_quality:={arguments.jpeg_quality}",
               "program:=cycle_statistics.py",
               f"program_args:=--cycles {arguments.cycles} --refill-below {refill} --output {result}{save}"]
    environment = dict(os.environ, ROS_MASTER_URI=f"http://localhost:{port}")
    with open(result.with_suffix(".log"), "w") as log:
        subprocess.run(command, env=environment, stdout=log, stderr=log,
                       timeout=120.0 + SECONDS_PER_CYCLE * arguments.cycles)
    if not result.exists():
        sys.exit(f"{part}, {light}: no result; see {result.with_suffix('.log')}")


def row(name, light, r):
    e = r["largest_error"] or dict.fromkeys(("x", "y", "z", "yaw", "tilt"), float("nan"))
    percent = [100.0 * r[key] / r["cycles"] for key in ("first", "later", "deadlock")]
    return (f"| {name} | {light} | {r['cycles']} | {percent[0]:.1f} % | {percent[1]:.1f} % | "
            f"{percent[2]:.1f} % | {e['x']:.2f} | {e['y']:.2f} | {e['z']:.2f} | {e['yaw']:.2f} | "
            f"{e['tilt']:.1f} | {r['seconds_median']:.2f} |")


def main():
    arguments = parse_arguments()
    arguments.output = arguments.output.resolve()
    arguments.output.mkdir(parents=True, exist_ok=True)
    print("| part | light | cycles | first match | later match | deadlock | x mm | y mm | z mm | "
          "yaw deg | tilt deg | locate s |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    results = []
    for part in arguments.parts:
        for light in arguments.lights:
            kind = "empty" if arguments.empty else "full"
            if arguments.bayer or arguments.jpeg_quality:
                kind += f"_{arguments.bayer or 'grey'}_{arguments.jpeg_quality}"
            result = arguments.output / f"{part}_{light}_{kind}.yaml"
            if not (arguments.keep and result.exists()):
                result.unlink(missing_ok=True)
                run(part, light, result, arguments)
            results.append(yaml.safe_load(result.read_text()))
            print(row(part, light, results[-1]), flush=True)
    total = {key: sum(r[key] for r in results) for key in ("cycles", "first", "later", "deadlock")}
    print("\n%(cycles)d cycles: first match %(first)d, later match %(later)d, deadlock %(deadlock)d"
          % total)
    failures = {}
    for r in results:
        for reason, count in r["failures"].items():
            failures[reason] = failures.get(reason, 0) + count
    for reason, count in sorted(failures.items(), key=lambda item: -item[1]):
        print(f"first match failed: {count} x {reason}")
    left = [n for r in results for n in r["left"]]
    if arguments.empty and left:
        print(f"emptied bins: {len(left)}; parts left in them: {sum(left) / len(left):.2f} on "
              f"average, {max(left)} at most")


if __name__ == "__main__":
    main()
