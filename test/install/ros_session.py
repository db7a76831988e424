# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Programs in the environment of an installed workspace, with a ROS master of their own. Everything that
is started here is also ended here, and everything that is waited for has a deadline."""
import os
import shlex
import signal
import socket
import subprocess
import time

END = 20.0  # s, for programs to end after SIGINT before they are killed


def free_port():
    with socket.socket() as listener:
        listener.bind(("localhost", 0))
        return listener.getsockname()[1]


def installed_environment(setup, home):
    """What a shell has in which nothing but the installed workspace was sourced."""
    clean = {"PATH": "/usr/bin:/bin", "HOME": str(home), "ROS_HOME": str(home), "ROS_HOSTNAME": "localhost",
             "LANG": "C.UTF-8", "PYTHONUNBUFFERED": "1"}
    text = subprocess.run(["bash", "-c", f"source {shlex.quote(str(setup))} && env -0"], env=clean, check=True,
                          capture_output=True, text=True, timeout=60).stdout
    return dict(entry.split("=", 1) for entry in text.split("\0") if entry)


class Session:
    """with Session(environment, folder) as session: ..."""

    def __init__(self, environment, folder):
        self.folder = folder
        self.environment = dict(environment, ROS_MASTER_URI=f"http://localhost:{free_port()}")
        self.processes = []

    def __enter__(self):
        self.start("roscore -p " + self.environment["ROS_MASTER_URI"].rsplit(":", 1)[1], "roscore")
        self.wait_for("rosparam get /run_id", 60)
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            self.end(process)

    def start(self, command, name):
        """Into the background; what it says goes into a file."""
        with open(self.folder / f"{name}.log", "w") as log:
            process = subprocess.Popen(command, shell=True, env=self.environment, cwd=self.folder, stdout=log,
                                       stderr=subprocess.STDOUT, start_new_session=True)
        process.name = name
        self.processes.append(process)

    @staticmethod
    def end(process):
        for number in (signal.SIGINT, signal.SIGKILL):
            try:
                os.killpg(process.pid, number)
                process.wait(END)
                return
            except ProcessLookupError:
                return
            except subprocess.TimeoutExpired:
                continue

    def run(self, command, seconds=60):
        """Its whole output. Raises where it fails or takes longer."""
        result = subprocess.run(["timeout", str(seconds), "bash", "-c", command], env=self.environment, cwd=self.folder,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if result.returncode != 0:
            raise RuntimeError(f"{command}: status {result.returncode}\n{result.stdout}\n{self.logs()}")
        return result.stdout

    def wait_for(self, command, seconds):
        """Until a command succeeds."""
        deadline = time.monotonic() + seconds
        while True:
            result = subprocess.run(["timeout", "10", "bash", "-c", command], env=self.environment, cwd=self.folder,
                                    stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            if result.returncode == 0:
                return result.stdout
            if time.monotonic() > deadline:
                raise RuntimeError(f"{command}: not within {seconds} s\n{result.stdout}\n{self.logs()}")
            time.sleep(0.2)

    def logs(self):
        return "\n".join(f"--- {process.name}\n" + (self.folder / f"{process.name}.log").read_text()[-2000:]
                         for process in self.processes)
