// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Detections -> what the robot is offered, in which order, and why the rest is refused.
///
/// An instance at which a pick failed is not offered first again until the scene around it has
/// changed, or the robot would try the same in vain for ever: a small picture of its surroundings
/// is kept with each failure and held against the new image. Frame `target` is that of the answers.

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/part_file.h"
#include "planar_bin_picking/types.h"

#include <opencv2/core/mat.hpp>

#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct PickParams {
  double score_min = 0.0;      ///< parts below are refused, over and above the score's threshold
  double visible_min = 0.0;    ///< share of the visible face
  double tilt_max_deg = 90.0;  ///< of the face against the bin's floor, or against the image plane
  /// Of the tool, where the part's file names no other: metres; 0 = neither walls nor what covers
  /// the part are looked at.
  double tool_radius = 0.0;
  double tool_height = 0.0;     ///< metres over the contact that are so wide; 0 = no end
  double wall_clearance = 0.0;  ///< metres between tool and wall on top of it
  int failures_max = 2;         ///< at one instance in an unchanged scene; then it is refused
  double same_place = 0.003;    ///< metres within which a detection is the instance that failed
  double changed_grey = 12.0;   ///< grey levels, mean over its surroundings, that are a change

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("score_min", self.score_min, 0.0, 1.0);
    visit("visible_min", self.visible_min, 0.0, 1.0);
    visit("tilt_max_deg", self.tilt_max_deg, 0.0, 90.0);
    visit("tool_radius", self.tool_radius, 0.0, 1.0);
    visit("tool_height", self.tool_height, 0.0, 10.0);
    visit("wall_clearance", self.wall_clearance, 0.0, 1.0);
    visit("failures_max", self.failures_max, 1, 1000);
    visit("same_place", self.same_place, 0.0, 1.0);
    visit("changed_grey", self.changed_grey, 0.0, 255.0);
  }
};

enum class PickRefusal {
  kLowScore,      ///< score below score_min
  kOccluded,      ///< visible share below visible_min, or no pick pose that nothing covers
  kTilt,          ///< steeper than tilt_max_deg
  kWall,          ///< at each of its pick poses the tool would touch the bin's wall
  kFailedBefore,  ///< failures_max picks failed, and nothing has changed about it since
};

/// The bin's inner space: a box that is open above.
struct PickBin {
  Eigen::Isometry3d T_bin_target = Eigen::Isometry3d::Identity();
  Eigen::Vector3d min = Eigen::Vector3d::Zero(), max = Eigen::Vector3d::Zero();  ///< bin frame
};

/// The face of a part that is up, and what is seen to cover it (src/core/cover.h).
struct PickFace {
  Eigen::Isometry3d T_target_part = Eigen::Isometry3d::Identity();
  std::vector<Eigen::Vector2d> covered;  ///< middles of the cells that something covers, part frame
  double cell_size = 0.0;                ///< metres
};

/// What the policy has to know about one detection.
struct PickCandidate {
  std::string part;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the visible face, target frame
  double score = 0.0, visible_fraction = 0.0;
  double tilt_deg = 0.0;
  /// Origin = contact, z = stroke of the tool, into the part. May be empty: nothing to check.
  std::vector<Eigen::Isometry3d> T_target_pick;
  PickFace face;
  PickTool tool;         ///< in place of the parameters', where it says something
  cv::Mat surroundings;  ///< see cutSurroundings; may be empty
};

struct Refused {
  std::size_t candidate = 0;
  PickRefusal reason = PickRefusal::kLowScore;
  std::string text;  ///< the numbers behind it
};

struct PickPlan {
  struct Offer {
    std::size_t candidate = 0;
    /// Of its pick poses, those at which the tool touches neither the bin's wall nor a cover.
    std::vector<std::size_t> picks;
    int failures = 0;
  };
  /// As given, but what failed before comes last.
  std::vector<Offer> offers;
  std::vector<Refused> refused;  ///< as given
};

/// Remembers failures. Not thread-safe.
class PickPolicy {
 public:
  /// @throws std::invalid_argument  a field out of its range: key, value, allowed
  explicit PickPolicy(const PickParams& params);

  /// @param candidates  best first
  /// @param bin         nothing: walls are not looked at
  /// Failures whose scene has changed are forgotten.
  PickPlan plan(const std::vector<PickCandidate>& candidates, const std::optional<PickBin>& bin);

  void fail(const PickCandidate& candidate);
  /// A part has gone: what failed below or beside it shows it by its changed surroundings.
  void succeed(const PickCandidate& candidate);

  const PickParams& params() const { return params_; }

 private:
  struct Failure {
    std::string part;
    Eigen::Vector3d center;
    cv::Mat surroundings;
    int count;
  };
  Failure* find(const PickCandidate& candidate);
  /// How often picks failed there in the scene as it is; forgets them where it has changed.
  int recall(const PickCandidate& candidate);
  /// Leaves out picks at which the tool would touch the bin's wall or what covers the part.
  /// @return  why none is left, if so
  std::optional<Refused> dropBarred(const PickCandidate& candidate,
                                    const std::optional<PickBin>& bin,
                                    PickPlan::Offer* offer) const;
  std::optional<Refused> refusal(const PickCandidate& candidate,
                                 const PickPlan::Offer& offer) const;
  /// The part's own, and what it does not say from the parameters.
  PickTool toolOf(const PickCandidate& candidate) const;

  PickParams params_;
  std::vector<Failure> failures_;
};

/// A small picture of a part and what lies about it: CV_32F, its mean taken away, so that the
/// lamp's brightness does not count. Empty where the part is not wholly in the image.
/// @param center, radius  of the part's outline, part frame, metres
cv::Mat cutSurroundings(const cv::Mat& grey, const Camera& camera,
                        const Eigen::Isometry3d& T_camera_part, const Eigen::Vector3d& center,
                        double radius);

/// What to do when parts were found and none can be offered, from the most frequent reason.
std::string deadlockHint(const std::vector<Refused>& refused);

}  // namespace planar_bin_picking
