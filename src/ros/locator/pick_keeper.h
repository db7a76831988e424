// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The pick policy between LocatePart and ReportPick: takes what must not be offered out of an
/// answer, and keeps the rest until the robot program has said what came of it. Any number of
/// threads.
///
/// Several programs may call one locator. An answer is kept until the same caller asks for the same
/// part again: it may locate levers, then gaskets, and then report on a lever. Once any of them has
/// picked a part, the scene is another one: reports on what was seen before are still taken in, but
/// answered with LOCATE.

#include "locator/answer/answer.h"
#include "planar_bin_picking/pick/pick_policy.h"

#include <planar_bin_picking/RefusedPart.h>
#include <planar_bin_picking/ReportPick.h>

#include <Eigen/Geometry>

#include <cstddef>
#include <functional>
#include <list>
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

  /// Who asked, and for how many.
  struct Call {
    std::string caller;         ///< name of its node
    std::size_t max_parts = 0;  ///< 0 = all
    /// From this call on; nothing: as before.
    std::optional<planar_bin_picking::PickParams> params = {};
  };

  /// Publishes an answer and returns what went out, with its frames' names.
  using Publish = std::function<std::vector<planar_bin_picking::LocatedPart>(Answer)>;

  struct Offered {
    std::vector<planar_bin_picking::LocatedPart> parts;
    std::vector<planar_bin_picking::RefusedPart> refused;
    std::string hint;                                       ///< what to do where all were refused
    std::vector<planar_bin_picking::Detection> detections;  ///< of `parts`
    std::vector<planar_bin_picking::Detection> needs_view;  ///< of those refused for that
  };

  /// Turns the result's detections into located parts in the order in which the policy offers them,
  /// without the refused ones and without pick poses that the tool cannot reach; publishes them and
  /// keeps them for reports, in one step: no report or other answer comes in between.
  Offered offer(Answer answer, const Frames& frames, const Call& call, const Publish& publish);

  /// @param caller  name of its node; whoever reports for another one names stamp and frame alike
  void report(const std::string& caller, const planar_bin_picking::ReportPick::Request& request,
              planar_bin_picking::ReportPick::Response* response);

 private:
  struct Kept {
    planar_bin_picking::LocatedPart located;
    planar_bin_picking::PickCandidate candidate;
  };
  /// One answer, and what of it was not reported yet, best first.
  struct Open {
    std::string caller;
    SteadyTime received;  ///< when its image came
    std::vector<Kept> parts;
  };
  /// The tool of a call: another one may be served at the same time.
  std::vector<planar_bin_picking::ToolBody> bodiesOf(const Call& call) const;
  struct Found {
    std::list<Open>::iterator answer;
    std::vector<Kept>::iterator part;
  };

  void keep(Open answer, const std::vector<planar_bin_picking::PartPtr>& asked_for);
  /// In place of those parts, in front of what else their answer offers.
  void replace(Open answer, const std::vector<FormerPart>& former);
  std::optional<Found> find(const std::string& caller,
                            const planar_bin_picking::ReportPick::Request& request);

  mutable std::mutex mutex_;
  planar_bin_picking::PickPolicy policy_;
  std::list<Open> open_;      ///< the latest first
  SteadyTime scene_changed_;  ///< when a part was last picked
};

}  // namespace planar_bin_picking_ros
