// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The pick policy between LocatePart and ReportPick: takes what must not be offered out of an
/// answer, and keeps the rest until the robot program has said what came of it. Any number of
/// threads.

#include "answer.h"
#include "cell_params.h"
#include "planar_bin_picking/pick_policy.h"

#include <planar_bin_picking/RefusedPart.h>
#include <planar_bin_picking/ReportPick.h>

#include <Eigen/Geometry>

#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class PickKeeper {
 public:
  /// @throws std::invalid_argument  a parameter out of its range
  explicit PickKeeper(const planar_bin_picking::PickParams& params) : policy_(params) {}

  /// Where the answer's frames are, as far as the policy asks for it.
  struct Frames {
    Eigen::Isometry3d T_target_camera = Eigen::Isometry3d::Identity();
    std::optional<planar_bin_picking::PickBin> bin;
  };

  /// What sort() took out, and what it has to know again once the answer has gone out.
  struct Sorted {
    std::vector<planar_bin_picking::RefusedPart> refused;
    std::vector<planar_bin_picking::PickCandidate> offered;
    std::string hint;  ///< what to do where all were refused
  };

  /// Orders the answer's detections and located parts as the policy offers them, leaves out their
  /// pick poses that the tool cannot reach, and takes the refused ones out.
  Sorted sort(Answer* answer, const Frames& frames);

  /// The answer as it went out, with its frames' names: what reports are about from now on.
  /// @param offered  as sort() returned it for this answer
  void keep(const std::vector<planar_bin_picking::LocatedPart>& located,
            const std::vector<planar_bin_picking::PickCandidate>& offered);

  void report(const planar_bin_picking::ReportPick::Request& request,
              planar_bin_picking::ReportPick::Response* response);

 private:
  struct Offered {
    planar_bin_picking::LocatedPart located;
    planar_bin_picking::PickCandidate candidate;
  };

  std::mutex mutex_;
  planar_bin_picking::PickPolicy policy_;
  std::vector<Offered> offered_;  ///< by the latest answer, and not yet reported
};

}  // namespace planar_bin_picking_ros
