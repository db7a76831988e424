# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""Pictures of a checkerboard as a camera on a robot's flange takes them, and the poses of the flange: what
calibrate_samples reads. No lens distortion, no noise: the example is tested here, not the accuracy."""
import cv2
import numpy

COLUMNS, ROWS, SQUARE = 9, 6, 0.02  # inner corners; metres
WIDTH, HEIGHT, FOCAL = 800, 640, 1000.0
FINE = 40  # pixels of the board's texture per square
T_FLANGE_CAMERA = (numpy.radians([2.0, -3.0, 30.0]), [0.05, -0.02, 0.04])
DISTANCE = 0.35
# Tilts about the camera's x and y and turns about its z, degrees: about more than one axis, or the
# hand-eye transform could not be known.
VIEWS = [(0, 0, 0), (25, 0, 20), (-25, 0, -20), (0, 25, 45), (0, -25, -45), (20, 20, 10), (-20, 20, -10),
         (20, -20, 30), (-20, -20, -30), (30, 10, 60), (-10, 30, -60), (10, -30, 15)]


def rigid(rotation_vector, translation):
    T = numpy.eye(4)
    T[:3, :3] = cv2.Rodrigues(numpy.asarray(rotation_vector, float))[0]
    T[:3, 3] = translation
    return T


def texture():
    """The board with a white rim, and texture pixels -> metres on the board."""
    squares = (numpy.indices((ROWS + 1, COLUMNS + 1)).sum(axis=0) % 2 * 255).astype(numpy.uint8)
    image = cv2.resize(squares, None, fx=FINE, fy=FINE, interpolation=cv2.INTER_NEAREST)
    image = cv2.copyMakeBorder(image, FINE, FINE, FINE, FINE, cv2.BORDER_CONSTANT, value=255)
    step = SQUARE / FINE
    # The first inner corner is the origin; pixel centres lie half a pixel inside.
    first = -2 * SQUARE + 0.5 * step
    return image, numpy.array([[step, 0, first], [0, step, first], [0, 0, 1]])


def quaternion(R):
    angle_axis = cv2.Rodrigues(R)[0].ravel()
    angle = numpy.linalg.norm(angle_axis)
    axis = angle_axis / angle if angle > 0 else numpy.zeros(3)
    return [*(axis * numpy.sin(angle / 2)), numpy.cos(angle / 2)]


def write(folder):
    board, pixel_to_board = texture()
    K = numpy.array([[FOCAL, 0, WIDTH / 2 - 0.5], [0, FOCAL, HEIGHT / 2 - 0.5], [0, 0, 1]])
    middle = numpy.array([(COLUMNS - 1) * SQUARE / 2, (ROWS - 1) * SQUARE / 2, 0])
    T_base_board = rigid([numpy.pi, 0, 0], [0.5, 0.1, 0.0])
    lines = []
    for i, (about_x, about_y, about_z) in enumerate(VIEWS):
        turn = rigid([0, 0, numpy.radians(about_z)], [0, 0, 0])
        tilt = rigid(numpy.radians([about_x, about_y, 0]), [0, 0, 0])
        T_camera_board = rigid([0, 0, 0], [0, 0, DISTANCE]) @ tilt @ turn @ rigid([0, 0, 0], -middle)
        H = K @ T_camera_board[:3, [0, 1, 3]] @ pixel_to_board
        fine = cv2.warpPerspective(board, numpy.diag([2, 2, 1]) @ H, (2 * WIDTH, 2 * HEIGHT), borderValue=128)
        cv2.imwrite(str(folder / f"view{i}.png"), cv2.resize(fine, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA))
        T = T_base_board @ numpy.linalg.inv(T_camera_board) @ numpy.linalg.inv(rigid(*T_FLANGE_CAMERA))
        lines.append(f"- {{image: view{i}.png, position: {[float(x) for x in T[:3, 3]]}, "
                     f"orientation: {[float(x) for x in quaternion(T[:3, :3])]}}}\n")
    (folder / "samples.yaml").write_text("".join(lines))
