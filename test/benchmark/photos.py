#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Runs locate_image over real photographs, all with one parameter file, and prints a table of what was found.

The photographs lie beside the repository, in ../shared/real (its README says whose they are); where they are absent
there is nothing to do. photos/ holds recipes and judge.py, which compares the located parts' holes with holes that were
found by hand; plates/ holds check.py, which compares them with holes that it sees itself.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHON = '/usr/bin/python3'  # Debian's, which has OpenCV and ezdxf
SUMMARY = re.compile(r'(\d+) pictures, (\d+) parts: (\d+) found, (\d+) ranked first, (\d+) false, .*'
                     r'worst point px median ([\d.]+) max ([\d.]+); s median ([\d.]+)')
HOLES = re.compile(r'hole error px \[([^]]+)\].* face (\w+) ')
PLATE_RANGE = ('1.15', '1.40')  # metres, as ../shared/real/README.md gives it


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--real', type=Path, default=ROOT / '../shared/real', help='folder with photos/ and plates/')
    parser.add_argument('--program', type=Path, default=ROOT / 'build/devel/lib/planar_bin_picking/locate_image')
    parser.add_argument('--params', type=Path, default=ROOT / 'config/locator.yaml')
    parser.add_argument('--output', type=Path, default=ROOT / 'build/bench/photos', help='results and overlays')
    parser.add_argument('--details', action='store_true', help='a line for each picture')
    return parser.parse_args()


def judge(recipe, arguments):
    """One row of the table: what judge.py says of all pictures of a recipe."""
    run = subprocess.run(
        [PYTHON, 'judge.py', recipe.name, '.', str(arguments.program.resolve()), '--params',
         str(arguments.params.resolve()), '--keep', str(arguments.output.resolve() / recipe.stem)],
        cwd=recipe.parent, capture_output=True, text=True)
    found = SUMMARY.search(run.stdout)
    if run.returncode != 0 or not found:
        sys.exit('%s failed:\n%s%s' % (recipe.name, run.stdout, run.stderr))
    if arguments.details:
        print(run.stdout, end='')
    pictures, parts, right, first, false, median, worst, seconds = found.groups()
    return '| %s | %s | %s of %s | %s | %s | %s / %s | %.0f |' % (
        recipe.stem.replace('recipe_', ''), pictures, right, parts, first, false, median, worst, 1e3 * float(seconds))


def check_plate(photo, arguments):
    """Largest error of a plate's three holes in pixels, or nothing where it was not found; and whether its face is
    right."""
    folder = photo.parent
    with tempfile.TemporaryDirectory() as temporary:
        result = os.path.join(temporary, 'result.yaml')
        subprocess.run([str(arguments.program), '--part', str(folder / '002.dxf'), '--camera',
                        str(folder / 'camera_info.yaml'), '--image', str(photo), '--params', str(arguments.params),
                        '--distance-min', PLATE_RANGE[0], '--distance-max', PLATE_RANGE[1], '--output', result],
                       check=True, stdout=subprocess.DEVNULL)
        run = subprocess.run([PYTHON, str(folder / 'check.py'), str(folder / '002.dxf'),
                              str(folder / 'camera_info.yaml'), str(photo), result], capture_output=True, text=True)
    found = HOLES.search(run.stdout)
    if arguments.details:
        print(photo.name, run.stdout.strip().splitlines()[-1:] or run.stderr)
    if not found:
        return None, False
    face = 'front' if photo.stem == 'mirrored' else 'back'
    return max(float(value) for value in found[1].split(',')), found[2] == face


def main():
    arguments = parse_arguments()
    if not (arguments.real / 'photos').is_dir():
        print('no photographs at %s: nothing to measure' % arguments.real)
        return
    if not arguments.program.is_file():
        sys.exit('%s is not built; run ./run build first' % arguments.program)
    arguments.output.mkdir(parents=True, exist_ok=True)
    rows = [judge(recipe, arguments) for recipe in sorted((arguments.real / 'photos').glob('recipe_*.yaml'))]
    plates = [check_plate(photo, arguments)
              for photo in sorted((arguments.real / 'plates').glob('*.png')) if photo.stem != 'checkerboard']
    print('| pictures of | pictures | found | ranked first | false | worst hole px, median / largest | ms |')
    print('|---|---|---|---|---|---|---|')
    print('\n'.join(rows))
    errors = [error for error, _ in plates if error is not None]
    print('\nplates: %d of %d found, %d faces right, largest error of a hole %.2f px' % (
        len(errors), len(plates), sum(right for _, right in plates), max(errors, default=float('nan'))))


if __name__ == '__main__':
    main()
