// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_params.h"

#include "planar_bin_picking/calibrate/board/board_file.h"
#include "shared/names.h"
#include "shared/param_reader.h"

#include <stdexcept>

namespace planar_bin_picking_ros {

planar_bin_picking::Mounting CalibratorParams::mountingValue() const {
  return mounting == "eye_in_hand" ? planar_bin_picking::Mounting::kEyeInHand
                                   : planar_bin_picking::Mounting::kEyeToHand;
}

planar_bin_picking::Board CalibratorParams::boardValue() const {
  return board_file.empty() ? planar_bin_picking::parseBoard(board, square)
                            : planar_bin_picking::loadBoard(board_file);
}

void validate(const CalibratorParams& params) {
  const auto require = [](bool condition, const std::string& message) {
    if (!condition) throw std::invalid_argument("~calibrator/" + message);
  };
  require(params.mounting == "eye_in_hand" || params.mounting == "eye_to_hand",
          "mounting is \"" + params.mounting + "\", must be eye_in_hand or eye_to_hand");
  require(params.square > 0.0 || !params.board_file.empty(),
          "square is not set: the side of the board's squares in metres; or give board_file");
  require(!params.output_folder.empty(), "output_folder is not set: where the results go");
  require(!params.base_frame.empty() && !params.flange_frame.empty(),
          "base_frame or flange_frame is empty; tf must know both");
  params.boardValue();
  planar_bin_picking::validate(params.solver);
  planar_bin_picking::validate(params.run);
}

CalibratorParams loadCalibratorParams(const XmlRpc::XmlRpcValue& tree) {
  CalibratorParams params = readFields<CalibratorParams>(tree, kCalibratorParams);
  validate(params);
  return params;
}

std::string describe(const CalibratorParams& params) { return printFields(params); }

}  // namespace planar_bin_picking_ros
