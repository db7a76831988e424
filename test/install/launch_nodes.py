#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Loads launch files as roslaunch does, with all files that they include and all parameters that they
load, and prints how many nodes there are and which of their programs are missing:
launch_nodes.py "FILE ARGUMENT:=VALUE ..." ...   (one argument per launch)"""
import sys

import roslaunch.config
import roslib.packages
import rospkg


def has_program(node):
    try:
        return bool(roslib.packages.find_node(node.package, node.type))
    except rospkg.ResourceNotFound:
        return False


def main():
    nodes = []
    for launch in sys.argv[1:]:
        path, *arguments = launch.split()
        config = roslaunch.config.load_config_default([(path, arguments)], None, assign_machines=False)
        nodes += config.nodes
    print(len(nodes), *sorted({f"{node.package}/{node.type}" for node in nodes if not has_program(node)}))


if __name__ == "__main__":
    main()
