#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Measures what a large parts folder costs a locator, and whether its memory stays flat.

    ./run bench parts [--count 500]      seconds from the start to the first answer, memory per part
    ./run bench parts --calls 2000       locates while parts come, change and go; memory at each quarter of the calls

The parts are the drawings of test/data/parts, over and over. The locator is the built node, with a ROS master of
its own; its log stays in build/bench/parts/.
"""
import argparse
import itertools
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import roslib.packages
import rospy

from planar_bin_picking.srv import ListParts, LocatePart

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/ros"))
UP = 60.0  # s, for a node to come up
EVERY = 3  # calls from one change of the parts folder to the next
FEW = 100  # calls after which all threads have had one


def free_port():
    with socket.socket() as probe:
        probe.bind(("localhost", 0))
        return probe.getsockname()[1]


def drawings():
    return sorted((ROOT / "test/data/parts").glob("*.dxf"))


def fill(folder, count):
    for number, drawing in zip(range(count), itertools.cycle(drawings())):
        name = f"{drawing.stem}_{number:03d}"
        shutil.copy(drawing, folder / f"{name}.dxf")
        (folder / f"{name}.yaml").write_text(f"drawing: {name}.dxf\nthickness_mm: 3.0\n")


def memory_mb(process):
    for line in Path(f"/proc/{process.pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1024.0
    raise RuntimeError("the locator has ended; see its log")


def cpu_seconds(process):
    """Of the process so far: what the start would take on an idle machine with one core."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


class Node:
    """with Node(folder, name) as process: ..."""

    def __init__(self, folder, name):
        rospy.set_param(f"/{name}/cell", {"parts_folder": str(folder), "target_frame": "base", "distance_min": 0.78,
                                          "distance_max": 0.98, "parts_poll": 0.2})
        self.program, self.name = roslib.packages.find_node("planar_bin_picking", "locator")[0], name

    def __enter__(self):
        output = ROOT / "build/bench/parts"
        output.mkdir(parents=True, exist_ok=True)
        self.begin = time.monotonic()
        with open(output / f"{self.name}.log", "w") as log:
            self.process = subprocess.Popen([self.program, "__name:=" + self.name], stdout=log, stderr=log)
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(UP)

    def list_parts(self):
        rospy.wait_for_service(f"/{self.name}/list_parts", UP)
        return rospy.ServiceProxy(f"/{self.name}/list_parts", ListParts)().parts


def measure_start(scratch, count):
    """(seconds, seconds of processor, memory) of a node with so many parts."""
    folder = scratch / f"parts_{count}"
    folder.mkdir()
    fill(folder, count)
    with Node(folder, f"parts_{count}") as node:
        found = node.list_parts()
        seconds = time.monotonic() - node.begin
        assert len(found) == count and all(part.available for part in found), "some parts were not read"
        return seconds, cpu_seconds(node.process), memory_mb(node.process)


def start(scratch, count):
    few_seconds, few_cpu, few_memory = measure_start(scratch, 1)
    seconds, cpu, memory = measure_start(scratch, count)
    print(f"{count} parts: {seconds:.2f} s to the first answer, {few_seconds:.2f} s with one part")
    print(f"processor {cpu:.2f} s, {few_cpu:.2f} s with one part: {1e3 * (cpu - few_cpu) / max(1, count - 1):.1f} ms a part")
    print(f"memory {memory:.0f} MB, {few_memory:.0f} MB with one part: "
          f"{(memory - few_memory) / max(1, count - 1):.2f} MB a part")


def change(folder, number):
    """Parts come, change and go in turn; `kept` is never touched."""
    path = folder / f"guest_{number % 5}.dxf"
    if number % 2 and path.exists():
        path.unlink()
    else:
        shutil.copy(drawings()[number % len(drawings())], path)


def calls(scratch, count):
    import driven_cell
    driven_cell.SHRINK = 4  # a quarter of a second a call
    folder = scratch / "parts"
    folder.mkdir()
    shutil.copy(ROOT / "test/data/parts/bracket.dxf", folder / "kept.dxf")
    driven_cell.DrivenCell(str(ROOT / "test/data/bin_bracket_00"))
    with Node(folder, "calls") as node:
        node.list_parts()
        locate = rospy.ServiceProxy("/calls/locate_part", LocatePart)
        statuses, seen = {}, set()
        print("| calls | memory MB | part versions read |\n|---|---|---|")
        for call in range(1, count + 1):
            if call % EVERY == 0:
                change(folder, call // EVERY)
            names = ["kept"] + [part.name for part in node.list_parts() if part.available and part.name != "kept"][:1]
            status = locate(parts=names, timeout=rospy.Duration(20.0)).status
            statuses[status] = statuses.get(status, 0) + 1
            seen |= {(part.name, part.read_at.to_nsec()) for part in node.list_parts()}
            if call in (1, FEW) or call % max(1, count // 4) == 0:
                print(f"| {call} | {memory_mb(node.process):.1f} | {len(seen)} |", flush=True)
        print("answers by status:", statuses)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=500, help="parts in the folder")
    parser.add_argument("--calls", type=int, default=0, help="locate so many times instead")
    arguments = parser.parse_args()
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
    master = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    scratch = Path(tempfile.mkdtemp())
    try:
        while subprocess.run(["rosparam", "get", "/run_id"], capture_output=True).returncode != 0:
            time.sleep(0.2)
        rospy.init_node("bench_parts", disable_signals=True)
        if arguments.calls:
            calls(scratch, arguments.calls)
        else:
            start(scratch, arguments.count)
    finally:
        rospy.signal_shutdown("done")
        master.terminate()
        master.wait(UP)
        shutil.rmtree(scratch)


if __name__ == "__main__":
    main()
