#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""A robot controller's side of the robot server in plain Python, without ROS: copy it.

    robot_client.py [HOST [PORT]] PART
"""
import socket
import sys

POSE, NOTHING, EMPTY, AGAIN, SET_UP, BAD_LINE, NO_LOCATOR, DONE = range(8)
NUMBERS = 6  # of a pose; 7 with abb's quaternions
TIMEOUT = 30.0  # s; more than the server's own


class Pose:
    """Where to go, out of one line of the server."""

    def __init__(self, words, has_numbers):
        self.left, self.face = int(words[1]), ("front", "back")[int(words[2]) - 1]
        first = 5 if has_numbers else 3
        self.numbers = [int(word) for word in words[3:first]]  # of part and tool
        poses = [float(word) for word in words[first:-2]]
        self.target, self.approach, self.retreat = (poses[i * NUMBERS:(i + 1) * NUMBERS] for i in range(3))
        self.part, self.pick = words[-2:]


class RobotClient:
    """has_numbers: as the server's parameter `numbers`."""

    def __init__(self, host="127.0.0.1", port=5700, has_numbers=False):
        self.has_numbers = has_numbers
        self.socket = socket.create_connection((host, port), TIMEOUT)
        self.file = self.socket.makefile("r", encoding="ascii", newline="\n")

    def close(self):
        self.file.close()
        self.socket.close()

    def ask(self, line):
        """(code, Pose or text)."""
        self.socket.sendall(line.encode("ascii") + b"\n")
        answer = self.file.readline()
        if not answer.endswith("\n"):
            raise ConnectionError("the server has closed the connection")
        code, _, text = answer.rstrip("\n").partition(" ")
        return int(code), Pose(answer.split(), self.has_numbers) if int(code) == POSE else text

    def locate(self, part, face="", flange=None):
        """flange: numbers, for a camera on the arm whose pose nobody else publishes."""
        line = f"locate {part} {face}"
        if flange is not None:
            line += " flange " + " ".join(f"{number:.6f}" for number in flange)
        return self.ask(line)

    def next(self):
        return self.ask("next")

    def report(self, success):
        return self.ask("report " + ("ok" if success else "failed"))


def main():
    *where, part = sys.argv[1:]
    client = RobotClient(where[0] if where else "127.0.0.1", int(where[1]) if len(where) > 1 else 5700)
    code, pose = client.locate(part)
    while code == POSE:
        print(f"go to {pose.target} for {pose.part}/{pose.pick}, {pose.face} up, {pose.left} more wait")
        picked = input("picked? [y/n] ") == "y"  # here the robot moves, sucks and looks at its vacuum
        code, pose = client.report(picked)
    print(code, pose)


if __name__ == "__main__":
    main()
