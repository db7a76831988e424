#!/usr/bin/env python3
# SPDX-FileCopyrightText: The planar_bin_picking authors
# SPDX-License-Identifier: BSD-3-Clause
"""The blur that check_cell measures, on squares whose edges are smeared by as much as is known."""
import sys
import unittest
from pathlib import Path

import cv2
import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src/tools/check_cell"))
import cell_measures

FINER = 4  # lines that are drawn for each one


def squares(blur, noise):
    large = numpy.full((600 * FINER, 600 * FINER), 60.0, numpy.float32)
    for row in (100, 350):
        for column in (100, 350):
            large[row * FINER:(row + 150) * FINER, column * FINER:(column + 150) * FINER] = 180.0
    large = cv2.GaussianBlur(large, (0, 0), FINER * blur)
    picture = cv2.resize(large, None, fx=1.0 / FINER, fy=1.0 / FINER, interpolation=cv2.INTER_AREA)
    return (picture + numpy.random.default_rng(1).normal(0.0, noise, picture.shape)).astype(numpy.float32)


class Focus(unittest.TestCase):
    def test_the_blur_is_what_it_is_with_and_without_noise(self):
        for blur, noise in ((1.0, 0.5), (1.0, 4.0), (2.0, 4.0), (3.0, 4.0), (5.0, 0.5), (5.0, 4.0)):
            with self.subTest(blur=blur, noise=noise):
                found, ninths = cell_measures.focus(squares(blur, noise), noise)
                self.assertAlmostEqual(found[0].value, numpy.hypot(blur, 0.29), delta=0.15 * blur)
                self.assertGreaterEqual(numpy.isfinite(ninths).sum(), 4)
                verdict = "GOOD" if blur < 1.5 else "LOOK" if blur < 3.0 else "BAD"
                if blur != 3.0:
                    self.assertEqual(found[0].verdict, verdict)

    def test_noise_alone_has_no_edges(self):
        flat = numpy.random.default_rng(2).normal(100.0, 4.0, (400, 400)).astype(numpy.float32)
        found, _ = cell_measures.focus(flat, 4.0)
        self.assertTrue(numpy.isnan(found[0].value))
        self.assertIn("too few edges", found[0].advice)


if __name__ == "__main__":
    unittest.main()
