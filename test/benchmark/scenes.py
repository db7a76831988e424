#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Runs locate_image over the benchmark scenes, all with one parameter file, and scores the results.

The scenes are large and lie beside the repository, in ../shared/scenes (its README says how they were
made); where they are absent there is nothing to do. Writes build/bench/<scene>.yaml and <scene>.jpg,
prints the time of each stage and the peak memory per scene, then what evaluate.py says.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
PARTS = {'open': 'parts', 'hard': 'hard_parts'}
TRUTH = {'open': 'truth', 'hard': 'hard_truth'}
STAGE_LINE = re.compile(r'^(\w+)\s+(\d+\.\d+)\s*(\d+)?$')


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('names', nargs='*', help='only scenes whose name begins with one of these')
    parser.add_argument('--scenes', type=Path, default=ROOT / '../shared/scenes',
                        help='folder with open/, parts/ and evaluate.py')
    parser.add_argument('--set', choices=('open', 'hard'), default='open', help='which of the scenes')
    parser.add_argument('--program', type=Path,
                        default=ROOT / 'build/devel/lib/planar_bin_picking/locate_image')
    parser.add_argument('--params', type=Path, default=ROOT / 'config/locator.yaml')
    parser.add_argument('--output', type=Path, default=ROOT / 'build/bench')
    parser.add_argument('--overlay', action='store_true', help='write <scene>.jpg as well')
    return parser.parse_args()


def command_for(scene, arguments):
    wanted = yaml.safe_load((scene / 'scene.yaml').read_text())
    command = [str(arguments.program), '--camera', str(scene / 'camera_info.yaml'),
               '--image', str(scene / 'image.png'), '--params', str(arguments.params),
               '--distance-min', str(wanted['distance_min_m']),
               '--distance-max', str(wanted['distance_max_m']),
               '--output', str(arguments.output / (scene.name + '.yaml'))]
    if arguments.overlay:
        command += ['--overlay', str(arguments.output / (scene.name + '.jpg'))]
    for part in wanted['parts']:
        file = arguments.scenes / PARTS[arguments.set] / (part + '.yaml')
        command += ['--part', str(file if file.exists() else file.with_suffix('.dxf'))]
    return command


def run_one(command):
    """Runs the program alone: its stage times in ms and its peak memory in MB."""
    with tempfile.TemporaryFile('w+') as printed:
        process = subprocess.Popen(command, stdout=printed)
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit('failed: ' + ' '.join(command))
        printed.seek(0)
        stages = {m[1]: float(m[2]) for m in map(STAGE_LINE.match, printed.read().splitlines()) if m}
    return stages, usage.ru_maxrss / 1024.0


def main():
    arguments = parse_arguments()
    if not (arguments.scenes / arguments.set).is_dir():
        print('no benchmark scenes at %s: nothing to measure' % arguments.scenes)
        return
    if not arguments.program.is_file():
        sys.exit('%s is not built; run ./run build first' % arguments.program)
    arguments.output.mkdir(parents=True, exist_ok=True)
    scenes = sorted(path.parent for path in (arguments.scenes / arguments.set).glob('*/scene.yaml'))
    if arguments.names:
        scenes = [s for s in scenes if s.name.startswith(tuple(arguments.names))]
    for scene in scenes:
        # A result of an earlier run must not pass for one of this run.
        (arguments.output / (scene.name + '.yaml')).unlink(missing_ok=True)
    for scene in scenes:
        stages, peak_mb = run_one(command_for(scene, arguments))
        print('%-24s %s  %4.0f MB' % (
            scene.name, '  '.join('%s %.0f' % item for item in stages.items()), peak_mb), flush=True)
    print('(milliseconds)\n')
    subprocess.run(['/usr/bin/python3', str(arguments.scenes / 'evaluate.py'), '--gt'] + [str(s) for s in scenes] +
                   ['--results', str(arguments.output), '--parts', str(arguments.scenes / TRUTH[arguments.set])],
                   check=True)


if __name__ == '__main__':
    main()
