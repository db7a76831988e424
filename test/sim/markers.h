// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The markers of a simulated ChArUco board, as OpenCV draws them.

#include <opencv2/core/version.hpp>
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
#include <opencv2/objdetect/aruco_detector.hpp>
#else
#include <opencv2/aruco.hpp>
#endif

#include "board_cell.h"

namespace planar_bin_picking::sim {

inline constexpr char kDictionary[] = "DICT_4X4_100";

/// Makes the cell's board one with markers of kDictionary, three quarters of a square wide.
inline void giveMarkers(BoardCell* cell) {
  constexpr int kModules = 4 + 2;
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_100);
  cell->marker = 0.75 * cell->square;
  for (int i = 0; i < (cell->cols + 1) * (cell->rows + 1) / 2; ++i) {
    cv::Mat modules;
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 7)
    cv::aruco::generateImageMarker(dictionary, i, kModules, modules, 1);
#else
    cv::aruco::drawMarker(dictionary, i, kModules, modules, 1);
#endif
    cell->markers.push_back(modules);
  }
}

}  // namespace planar_bin_picking::sim
