// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/board_look.h"

#include "calibrator/calibrator_checks.h"
#include "shared/convert.h"
#include "shared/convert_camera.h"

#include <algorithm>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::BoardObservation;
using planar_bin_picking::HandEyeProblem;

BoardLook::BoardLook(const CalibratorParams& params, ImageSource* source,
                     const TransformBuffer* tf_buffer, std::function<void()> check_stop)
    : params_(params),
      board_(params.boardValue()),
      source_(source),
      tf_buffer_(tf_buffer),
      check_stop_(std::move(check_stop)) {}

HandEyeProblem BoardLook::problemFor(const Look& look) const {
  HandEyeProblem problem;
  problem.mounting = params_.mountingValue();
  problem.board = board_;
  problem.width = look.image.cols;
  problem.height = look.image.rows;
  if (params_.fixed_camera) problem.camera = toCamera(*look.frame.info, *look.frame.image).model();
  return problem;
}

Eigen::Isometry3d BoardLook::flangeAt(const ros::Time& stamp) const {
  constexpr double kSlice = 0.1;  // s; so long a stop waits at most
  for (double left = params_.tf_timeout;; left -= kSlice) {
    check_stop_();
    const LookupResult flange =
        lookup(*tf_buffer_, params_.base_frame, params_.flange_frame, stamp,
               std::chrono::duration<double>(std::clamp(left, 0.0, kSlice)));
    if (flange.T_target_source) return *flange.T_target_source;
    if (left > kSlice) continue;
    throw std::runtime_error("tf has no way from " + params_.base_frame + " to " +
                             params_.flange_frame + " at the image's stamp (" + flange.reason +
                             "); check base_frame, flange_frame and the robot's driver");
  }
}

Look BoardLook::take() const {
  Look look;
  look.frame = source_->await(ros::Time(), ros::Duration(params_.image_timeout));
  look.T_base_flange = flangeAt(look.frame.image->header.stamp);
  look.image = toGrey(look.frame.image);
  look.board = planar_bin_picking::findBoard(look.image, board_, params_.blur_max_px);
  return look;
}

Look BoardLook::takeWithBoard() const {
  Look look = take();
  if (look.board.status != BoardObservation::Status::kFound) {
    throw std::runtime_error("at the start: " + whyNoBoard(look.board, look.image, board_));
  }
  return look;
}

}  // namespace planar_bin_picking_ros
