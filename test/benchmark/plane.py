#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a known plane is worth: the benchmark's single-layer scenes located without it, with it, and with
one that is off by its own sigma in height or in tilt; prints the errors in depth and tilt of what was found each time.

    ./run bench plane

The plane comes from the scene's truth, as a cell would have it from a calibration of its conveyor.
"""
import math
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import yaml

ROOT = Path(__file__).resolve().parents[2]
SCENES = ROOT / '../shared/scenes'
PROGRAM = ROOT / 'build/devel/lib/planar_bin_picking/locate_image'
SIGMA, SIGMA_TILT_DEG = 0.0005, 0.2  # the defaults of config/locator.yaml
LATERAL = 0.004  # m, within which a detection is of that true part


def matrix(pose):
    x, y, z, w = pose['orientation']
    T = numpy.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = pose['position']
    return T


class Face:
    """The face that is up: its middle and its normal, toward the camera."""

    def __init__(self, pose, is_front, center, thickness):
        T = matrix(pose)
        self.normal = T[:3, 2] if is_front else -T[:3, 2]
        z = 0.0 if is_front else -thickness
        self.middle = (T @ [center[0], center[1], z, 1.0])[:3]
        self.foot = self.middle - thickness * self.normal


def plane_of(faces):
    """Normal and distance of what most of the parts lie on."""
    normal = numpy.median([f.normal for f in faces], axis=0)
    normal /= numpy.linalg.norm(normal)
    return normal, -statistics.median(normal @ f.foot for f in faces)


def locate(scene, wanted, overlay):
    with tempfile.TemporaryDirectory() as folder:
        params, result = Path(folder) / 'params.yaml', Path(folder) / 'result.yaml'
        params.write_text(yaml.safe_dump(overlay))
        command = [PROGRAM, '--camera', scene / 'camera_info.yaml', '--image', scene / 'image.png',
                   '--params', params, '--output', result,
                   '--distance-min', wanted['distance_min_m'], '--distance-max', wanted['distance_max_m'],
                   '--part', SCENES / 'parts' / (wanted['parts'][0] + '.yaml')]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
        return yaml.safe_load(result.read_text())


def errors(found, truth, center, thickness):
    """Depth in mm, along the line of sight, and tilt in degrees of each that is on a true part."""
    depths, tilts, false = [], [], 0
    for detection in found['detections']:
        face = Face(detection, detection['face'] == 'front', center, thickness)
        ray = face.middle / numpy.linalg.norm(face.middle)
        off = lambda true: numpy.linalg.norm(numpy.cross(true.middle - face.middle, ray))
        nearest = min(truth, key=off)
        if off(nearest) > LATERAL:
            false += 1
            continue
        depths.append(1e3 * abs((nearest.middle - face.middle) @ ray))
        tilts.append(math.degrees(math.acos(min(1.0, nearest.normal @ face.normal))))
    return depths, tilts, false


def tree(normal, distance):
    return {'plane': dict(zip(('normal_x', 'normal_y', 'normal_z'), map(float, normal)),
                          distance=float(distance))}


def tilted(normal, distance):
    """Turned by one sigma about where the optical axis meets it."""
    a = math.radians(SIGMA_TILT_DEG)
    n = numpy.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]]) @ normal
    return n, distance * n[2] / normal[2]


def run(scene):
    wanted = yaml.safe_load((scene / 'scene.yaml').read_text())
    part = yaml.safe_load((SCENES / 'parts' / (wanted['parts'][0] + '.yaml')).read_text())
    thickness = 1e-3 * part['thickness_mm']
    box = yaml.safe_load((SCENES / 'truth' / (wanted['parts'][0] + '.yaml')).read_text())['bbox_mm']
    center = 0.5e-3 * (numpy.array(box[0]) + box[1])
    truth = [Face(i, i['face_up'] == 'front', center, thickness)
             for i in yaml.safe_load((scene / 'ground_truth.yaml').read_text())['instances']]
    normal, distance = plane_of(truth)
    for name, overlay in (('without', {}), ('with', tree(normal, distance)),
                          ('with, 0.5 mm too far', tree(normal, distance + SIGMA)),
                          ('with, tilted by 0.2 degrees', tree(*tilted(normal, distance)))):
        found = locate(scene, wanted, overlay)
        depths, tilts, false = errors(found, truth, center, thickness)
        print('| %s | %s | %d of %d | %d | %.2f | %.2f | %.2f | %.2f | %.2f |' % (
            scene.name, name, len(depths), len(truth), false, statistics.median(depths), max(depths),
            statistics.median(tilts), max(tilts), found['seconds']), flush=True)


def main():
    if not (SCENES / 'open').is_dir():
        print('no benchmark scenes at %s: nothing to measure' % SCENES)
        return
    if not PROGRAM.is_file():
        sys.exit('%s is not built; run ./run build first' % PROGRAM)
    print('| scene | plane | found | false | depth mm median | max | tilt deg median | max | s |')
    print('|---|---|---|---|---|---|---|---|---|')
    for scene in sorted((SCENES / 'open').glob('layer_*')):
        run(scene)


if __name__ == '__main__':
    main()
