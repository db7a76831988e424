// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the calibrator holds against each other before it believes a picture, and how it says that
/// something is wrong.

#include "calibrator/calibrator_params.h"
#include "input/image_inbox.h"
#include "planar_bin_picking/calibrate/board/find_board.h"

#include <opencv2/core/mat.hpp>

#include <string>

namespace planar_bin_picking_ros {

/// All pictures of a calibration come from one camera.
/// @throws std::runtime_error  another frame or size
void checkSameCamera(const Frame& first, const Frame& other);

/// @param what   begins the message, up to "it is ... mm"
/// @param where  ends it: of what it is off
/// @throws std::runtime_error  further apart than reached_mm or reached_deg, or not a number
void checkNear(const Eigen::Isometry3d& one, const Eigen::Isometry3d& other,
               const CalibratorParams& params, const std::string& what, const std::string& where);

/// Why this picture shows no board that can be used, and what to do.
std::string whyNoBoard(const planar_bin_picking::BoardObservation& seen, const cv::Mat& image,
                       const planar_bin_picking::Board& board);

/// Adds to the result what the solver cannot know: poses that gave no picture of the board, and why
/// there were not more.
/// @param why_lost  of the last picture without the board
void explain(const planar_bin_picking::CalibrationRun& run, const std::string& why_lost,
             planar_bin_picking::HandEyeResult* result);

}  // namespace planar_bin_picking_ros
