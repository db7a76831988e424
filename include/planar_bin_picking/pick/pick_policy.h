// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Detections -> what the robot is offered, in which order, and why the rest is refused.
///
/// An instance at which a pick failed is not offered first again until the scene around it has
/// changed, or the robot would try the same in vain for ever (pick_failures.h). One that has moved
/// since is another instance; but where the robot dragged it aside, what held it down, or what is
/// wrong of its pose, is often so still: it has fewer points. Frame `target` is that of the
/// answers.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/part/part_file.h"
#include "planar_bin_picking/pick/pick_failures.h"
#include "planar_bin_picking/pick/pick_order.h"
#include "planar_bin_picking/pick/surroundings.h"
#include "planar_bin_picking/pick/tool_room.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct PickParams {
  double score_min = 0.0;      ///< parts below are refused, over and above the score's threshold
  double visible_min = 0.0;    ///< share of the visible face
  double tilt_max_deg = 90.0;  ///< of the face against the bin's floor, or against the image plane
  /// Standard deviations of a pose that is offered; 0 = whatever they are. One more look lowers
  /// them.
  double depth_sigma_max = 0.0;  ///< metres, along the line of sight
  double tilt_sigma_max = 0.0;   ///< rad, about the worst axis in the face
  /// Of the tool, where the part's file names no other: metres; 0 = neither walls nor what covers
  /// the part are looked at.
  double tool_radius = 0.0;
  double tool_height = 0.0;     ///< metres over the contact that are so wide; 0 = no end
  double wall_clearance = 0.0;  ///< metres between tool and wall on top of it
  /// A tool of several bodies, as toolBodies has them; both empty = the cylinder above is all.
  std::vector<double> tool_boxes, tool_cylinders;
  double tool_clearance = 0.0;  ///< metres between these and other parts
  double tool_edges = 0.005;    ///< metres of edges that nobody explains below them; 0 = whatever
  int max_parts = 0;            ///< that are offered, whatever a call asks for; 0 = all
  int failures_max = 2;         ///< at one instance in an unchanged scene; then it is refused
  double same_place = 0.003;    ///< metres within which a detection is the instance that failed
  double changed_grey = 12.0;   ///< grey levels, mean over its surroundings, that are a change

  PickOrder order;  ///< of what is offered, instead of that of the rank

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("score_min", self.score_min, 0.0, 1.0);
    visit("visible_min", self.visible_min, 0.0, 1.0);
    visit("tilt_max_deg", self.tilt_max_deg, 0.0, 90.0);
    visit("depth_sigma_max", self.depth_sigma_max, 0.0, 1.0);
    visit("tilt_sigma_max", self.tilt_sigma_max, 0.0, 1.0);
    visit("tool_radius", self.tool_radius, 0.0, 1.0);
    visit("tool_height", self.tool_height, 0.0, 10.0);
    visit("wall_clearance", self.wall_clearance, 0.0, 1.0);
    visit("tool_boxes", self.tool_boxes);
    visit("tool_cylinders", self.tool_cylinders);
    visit("tool_clearance", self.tool_clearance, 0.0, 0.1);
    visit("tool_edges", self.tool_edges, 0.0, 1.0);
    visit("max_parts", self.max_parts, 0, 100000);
    visit("failures_max", self.failures_max, 1, 1000);
    visit("same_place", self.same_place, 0.0, 1.0);
    visit("changed_grey", self.changed_grey, 0.0, 255.0);
    visit("order_height", self.order.height, 0.0, 1000.0);
    visit("order_near", self.order.near, 0.0, 1000.0);
    visit("near_x", self.order.near_x, -100.0, 100.0);
    visit("near_y", self.order.near_y, -100.0, 100.0);
    visit("near_z", self.order.near_z, -100.0, 100.0);
    visit("order_walls", self.order.walls, 0.0, 1000.0);
    visit("order_clockwise", self.order.clockwise, 0.0, 1000.0);
  }
};

enum class PickRefusal {
  kLowScore,        ///< score below score_min
  kOccluded,        ///< visible share below visible_min, or no pick pose that nothing covers
  kTilt,            ///< steeper than tilt_max_deg
  kWall,            ///< at each of its pick poses the tool would touch the bin's wall
  kNoRoom,          ///< at each of them it would touch another part, this one, or what nobody knows
  kFailedBefore,    ///< failures_max picks failed, and nothing has changed about it since
  kOutside,         ///< outside of the asked distances or of the bin's box
  kNoPickPose,      ///< its file has pick poses, none of them for the face that is up
  kWrongFace,       ///< the other face is up than was asked for
  kNeedsView,       ///< less sure than depth_sigma_max or tilt_sigma_max asks for
  kContradicted,    ///< a second camera shows that it is not there
  kBeyondMaxParts,  ///< would be offered, but for the number that was asked for
};

/// The face of a part that is up, and what is seen to cover it (src/core/locate/judge/occlusion.h).
struct PickFace {
  Eigen::Isometry3d T_target_part = Eigen::Isometry3d::Identity();
  Face up = Face::kFront;
  std::vector<Eigen::Vector2d> covered;  ///< middles of the cells that something covers, part frame
  double cell_size = 0.0;                ///< metres
};

/// What the policy has to know about one detection.
struct PickCandidate {
  std::string part;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of the visible face, target frame
  /// Of `center`, m^2, target frame: how far out of the bin's box it may seem to lie by chance.
  Eigen::Matrix3d center_covariance = Eigen::Matrix3d::Zero();
  /// Why it is not to be offered whatever the policy says: found, and not what was asked for.
  std::optional<PickRefusal> withheld;
  std::string withheld_text;  ///< the numbers behind it
  double score = 0.0, visible_fraction = 0.0;
  double confirmed = 0.0;  ///< how well edges confirm it: PoseEvidence::edges, for the order
  double tilt_deg = 0.0;
  double depth_sigma = 0.0, tilt_sigma = 0.0;  ///< as in PickParams
  /// Origin = contact, z = stroke of the tool, into the part. May be empty: nothing to check.
  std::vector<Eigen::Isometry3d> T_target_pick;
  /// Where its file has pick poses and none fits the face that is up: which there are; else "".
  std::string other_picks;
  PickFace face;
  double approach = 0.0;  ///< metres before the contact, against z, from where the tool comes
  PickTool tool;          ///< in place of the parameters', where it says something
  Surroundings surroundings;
  std::shared_ptr<const PartModel> model;  ///< what others bump into; may be null
  /// For each pick pose metres of edges below the tool that no part explains; may be empty.
  std::vector<double> strange_edges;
};

struct Refused {
  std::size_t candidate = 0;
  PickRefusal reason = PickRefusal::kLowScore;
  std::string text;  ///< the numbers behind it
};

struct PickPlan {
  struct Offer {
    std::size_t candidate = 0;
    /// Of its pick poses, those at which the tool touches neither the bin's wall nor what covers
    /// the part.
    std::vector<std::size_t> picks;
    int failures = 0;
  };
  /// By PickParams::order, or else as given, but for those on which something lies, as the picture
  /// shows or the other parts' poses, and those that have moved since a pick failed; what failed
  /// where it is comes last.
  std::vector<Offer> offers;
  std::vector<Refused> refused;  ///< as given; those beyond the number asked for at the end
};

/// How far out of the bin's box a face's centre may seem to lie along one of its axes: where the
/// box stands is known to so much, and on top of it the position to three sigmas, within limits.
/// @param sigma  of the centre along that axis, metres
double boxMargin(double sigma);

/// Remembers failures. Not thread-safe.
class PickPolicy {
 public:
  /// @throws std::invalid_argument  a field out of its range: key, value, allowed
  explicit PickPolicy(const PickParams& params);

  /// Other parameters from now on; failures stay remembered.
  /// @throws std::invalid_argument  as the constructor; then nothing has changed
  void use(const PickParams& params);

  /// The first rule that a candidate breaks is its reason: withheld, outside of the bin, no pick
  /// pose, then the parameters, and last the number of parts.
  /// @param candidates  best first
  /// @param bin         nothing: neither the box nor its walls are looked at
  /// @param max_parts   offered at most; 0 = all
  /// Failures whose scene has changed are forgotten.
  PickPlan plan(std::vector<PickCandidate> candidates, const std::optional<PickBin>& bin,
                std::size_t max_parts = 0);

  void fail(const PickCandidate& candidate);
  /// A part has gone: what failed below or beside it shows it by its changed surroundings.
  void succeed(const PickCandidate& candidate);

  const PickParams& params() const { return params_; }
  const std::vector<ToolBody>& bodies() const { return bodies_; }

 private:
  /// Leaves out picks at which the tool would touch the bin, what covers the part, or others.
  /// @return  why none is left, if so
  std::optional<Refused> dropBarred(const std::vector<PickCandidate>& candidates,
                                    const std::optional<PickBin>& bin,
                                    PickPlan::Offer* offer) const;
  struct Bar {
    PickRefusal reason;  ///< kWall, kOccluded or kNoRoom
    std::string text;
  };
  /// Why the tool cannot go to a pick pose, if so.
  std::optional<Bar> barAt(const std::vector<PickCandidate>& candidates,
                           const std::optional<PickBin>& bin, std::size_t candidate,
                           std::size_t pick) const;
  /// @param barred  of dropBarred()
  std::optional<Refused> refusal(const PickCandidate& candidate, const std::optional<PickBin>& bin,
                                 const PickPlan::Offer& offer,
                                 const std::optional<Refused>& barred) const;
  /// The part's own, and what it does not say from the parameters.
  PickTool toolOf(const PickCandidate& candidate) const;

  PickParams params_;
  std::vector<ToolBody> bodies_;
  PickFailures failures_;
};

/// Of the face's normal, about the worst axis in the face, rad.
/// @param covariance  as RefinedPose::covariance
double tiltSigma(const Matrix6d& covariance);

/// What to do when parts were found and none can be offered: each reason's, the most frequent
/// first.
std::string deadlockHint(const std::vector<Refused>& refused);

}  // namespace planar_bin_picking
