// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A picture of the board and where the flange was when it was taken.

#include "calibrator/calibrator_params.h"
#include "input/image_source.h"
#include "planar_bin_picking/calibrate/board/find_board.h"
#include "shared/transforms.h"

#include <opencv2/core/mat.hpp>

#include <functional>

namespace planar_bin_picking_ros {

struct Look {
  planar_bin_picking::BoardObservation board;
  Eigen::Isometry3d T_base_flange = Eigen::Isometry3d::Identity();
  cv::Mat image;  ///< grey, 8 or 16 bit
  Frame frame;
};

class BoardLook {
 public:
  /// @param check_stop  called again and again while something is awaited; throws to end it
  BoardLook(const CalibratorParams& params, ImageSource* source, const TransformBuffer* tf_buffer,
            std::function<void()> check_stop);

  const planar_bin_picking::Board& board() const { return board_; }

  /// Takes the next image. @throws std::runtime_error  no image, no transform
  Look take() const;
  /// @throws std::runtime_error  as above, or no sharp board: why
  Look takeWithBoard() const;

  /// The problem of this board, camera and mounting, without observations.
  planar_bin_picking::HandEyeProblem problemFor(const Look& look) const;

 private:
  Eigen::Isometry3d flangeAt(const ros::Time& stamp) const;

  const CalibratorParams& params_;
  const planar_bin_picking::Board board_;
  ImageSource* const source_;
  const TransformBuffer* const tf_buffer_;
  const std::function<void()> check_stop_;
};

}  // namespace planar_bin_picking_ros
