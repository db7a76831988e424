// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/hypotheses.h"

#include "locate/prior/scene_normals.h"
#include "locate/refine/edge_offset.h"
#include "part/visible_face.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Standard deviations of the differences that chance makes between two hypotheses, all as mean
/// scores of 0..1: over the whole outline, whose points mostly find the same edges; over the walls'
/// lower edges, often lost in a shadow; over the print, of which chance confirms 0.1 to 0.3
/// (print_evidence.h).
constexpr double kOutlineSigma = 0.015, kWallSigma = 0.075, kPrintSigma = 0.1;
/// Score of walls' lower edges that chance gives: of 142 pairs of tilts whose better score was
/// below 0.4 that one was right in 83, of 71 above in 70.
constexpr double kWallChance = 0.3;
/// The same for two tilts, which differ by less than a pixel, so that hardly an edge is lost. Their
/// residuals tell them apart: so many edges err independently of one another, by Gaussians of
/// unknown width, of this many pixels at least. Residuals as large as kAliensPx come from edges of
/// something else as often as from a wrong tilt. (Of 384 pairs of tilts in rendered scenes and 119
/// in simulated heaps the smaller residual was right in 279 of the 284 that differ by more than a
/// quarter and have one below 0.4 pixels, in 14 of 19 of those that have none.)
constexpr double kTiltSigma = 0.05, kResiduals = 10.0, kLeastResidualPx = 0.05, kAliensPx = 0.4;
/// Log odds of a tilt all of whose narrow walls are seen, and none of the other's, fitted to 558
/// pairs of tilts in 47 rendered scenes, 397 of them of small tabs and washers: 541 were decided
/// rightly without the walls' bands and 551 with them.
constexpr double kBandOdds = 12.0;
/// Share of the print that is confirmed from which on the front is likelier up than the back:
/// halfway from what chance gives to what a print in view has.
constexpr double kPrintEven = 0.5;

/// Two starts whose normals are nearer than this (4 degrees) are aligned to the same pose ...
constexpr double kTiltsApart = 0.07;
/// ... and two aligned poses whose normals are nearer than this (3 degrees) are one pose.
constexpr double kTiltsAligned = 0.05;
/// The start may be this far beyond the tilt limit: the alignment may turn it to within.
constexpr double kTiltSlackDeg = 10.0;
/// The narrow alignment raises an inlier score by less than this; and one that is worse by more
/// after it competes no more.
constexpr double kHopeless = 0.1;
/// Where two poses differ in few points, the shadow of one tooth may outweigh these. So the inlier
/// score of the whole outline may not fall by more than this.
constexpr double kOutlineWorse = 0.02;
/// The same for the inlier scores in the field, of a few points each: alignment gains less.
constexpr double kHopelessInField = -0.3;
/// Inlier scores from which on a pose tells how parts lie: of lower ones many are none.
constexpr double kTells = 0.7;
/// Radii within which the centres of two poses are one place: a bar lies in a picture of bars in
/// many ways along the edges of the others, and all but one of them are none.
constexpr double kOnePlace = 0.5;
/// How exactly a bin's floor is known, radians, and as how many parts it counts.
constexpr double kFloorSigma = 0.02, kFloorParts = 2.0;
/// What is decided of the others tells more of each.
constexpr int kTiltRounds = 3;
constexpr int kRivalRounds = 3;          // of near-symmetries, which end where none is better
constexpr std::size_t kMostAligned = 8;  // near-symmetries of one pose, the best in the field: time
constexpr std::size_t kEnoughPoints = 64;  // to compare two poses by: time

/// The pose as the near-symmetry of the part; what the image said was about the pose itself.
PoseHypothesis moved(const PoseHypothesis& pose, const NearSymmetry& other) {
  PoseHypothesis out = pose;
  out.T_camera_part = pose.T_camera_part * other.T_part_turned;
  out.image = {};
  out.searched = false;
  if (other.flips) out.face = pose.face == Face::kFront ? Face::kBack : Face::kFront;
  return out;
}

std::vector<LocalPoint> pointsAt(const PartModel& part, const std::vector<int>& indices) {
  const std::size_t stride = 1 + indices.size() / kEnoughPoints;
  std::vector<LocalPoint> points;
  for (std::size_t i = 0; i < indices.size(); i += stride)
    points.push_back(localPoint(part, indices[i]));
  return points;
}

Eigen::Vector3d normalOf(const PoseHypothesis& pose) {
  return planar_bin_picking::normalOf(pose.T_camera_part, pose.face);
}

/// Log odds of the face that is up, by the print.
double printOdds(const Aligner& aligner, const PoseHypothesis& pose) {
  if (pose.face == Face::kBack || aligner.outlineOf(pose).print.empty()) return 0.0;
  return (aligner.printScoreOf(pose) - kPrintEven) / kPrintSigma;
}

/// The poses that look nearly the same, likeliest first: tilted the other way about the line of
/// sight ([4]); and where the outline is long, about one of its axes only, since the edges of its
/// long sides hardly tell the tilts about either from one another.
std::vector<PoseHypothesis> otherTilts(const Aligner& aligner, const RefineParams& params,
                                       const PoseHypothesis& pose) {
  const PartOutline& outline = aligner.outlineOf(pose);
  const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, pose.face);
  const Eigen::Isometry3d T = pose.T_camera_part * T_part_centre;
  // The line of sight in the centre frame.
  const Eigen::Vector3d seen = T.linear().transpose() * T.translation().normalized();
  std::vector<PoseHypothesis> out;
  for (const Eigen::Matrix2d& turned : outline.other_tilts) {
    Eigen::Vector3d as_seen = seen;
    as_seen.head<2>() = turned * seen.head<2>();
    PoseHypothesis other = pose;
    Eigen::Isometry3d T_other = T;
    T_other.linear() *= Eigen::Quaterniond::FromTwoVectors(as_seen, seen).toRotationMatrix();
    const double tilt = std::acos(std::min(1.0, std::abs(T_other.linear()(2, 2))));
    if ((as_seen - seen).norm() < kTiltsApart ||
        tilt > (params.tilt_limit_deg + kTiltSlackDeg) * M_PI / 180.0)
      continue;
    other.T_camera_part = T_other * T_part_centre.inverse();
    out.push_back(other);
  }
  return out;
}

/// Robust standard deviation of the edges' offsets, with what interpolation adds to any, pixels.
double residualOf(const PoseHypothesis& pose) {
  return std::hypot(kLeastResidualPx, pose.image.residual_px);
}

/// Log odds of the first of two tilts over the second, by their residuals in pixels.
double residualLead(double one, double other) {
  const double least = std::min(one, other) / kAliensPx;
  return kResiduals * std::log(other / one) / (1.0 + least * least);
}

/// The likeliest other tilt that is another pose once aligned and may compete.
std::optional<PoseHypothesis> competingTilt(const Aligner& aligner, const RefineParams& params,
                                            const PoseHypothesis& pose) {
  const double least = pose.inlier_score - kHopeless;
  const auto isAnother = [&](const PoseHypothesis& other) {
    return (normalOf(other) - normalOf(pose)).norm() > kTiltsAligned;
  };
  for (const PoseHypothesis& start : otherTilts(aligner, params, pose)) {
    PoseHypothesis other = start;
    aligner.alignWide(&other);
    if (other.inlier_score >= least) {
      aligner.alignNarrowFromAfar(&other);
      if (isAnother(other)) return other;
    }
    // A wide alignment turns a small part's tilt back to where it came from, or loses it. About a
    // pose that is hardly seen a narrow one finds the edges of others.
    if (pose.inlier_score < kTells) continue;
    other = start;
    aligner.alignNarrowFromAfar(&other);
    if (other.inlier_score >= least && isAnother(other)) return other;
  }
  return std::nullopt;
}

void compareTilts(const Aligner& aligner, const RefineParams& params, ChosenPose* chosen) {
  auto other = competingTilt(aligner, params, chosen->pose);
  if (!other) return;
  double lead = (chosen->pose.inlier_score - other->inlier_score) / kTiltSigma +
                residualLead(residualOf(chosen->pose), residualOf(*other));
  const auto wall = aligner.wallScoreOf(chosen->pose), other_wall = aligner.wallScoreOf(*other);
  if (wall && other_wall)
    lead += (std::max(*wall, kWallChance) - std::max(*other_wall, kWallChance)) / kWallSigma;
  lead += kBandOdds * aligner.wallBandsOf(chosen->pose, *other);
  if (lead < 0.0) {
    std::swap(chosen->pose, *other);
    lead = -lead;
  }
  chosen->other_tilt = other;
  chosen->lead = lead;
}

/// A near-symmetry with the odds that it is the part's pose.
struct Rival {
  double odds;
  const NearSymmetry* other;
};

/// Those worth an alignment, by the points at which they differ. In the field these cost little.
std::vector<Rival> rivalsOf(const Aligner& aligner, const PoseHypothesis& pose) {
  const PartModel& part = *aligner.outlineOf(pose).part;
  std::vector<Rival> rivals;
  for (const auto& other : part.nearSymmetries()) {
    if (other.exact) continue;
    const double gain =
        aligner.fieldInlierScoreOf(moved(pose, other), pointsAt(part, other.only_turned)) -
        aligner.fieldInlierScoreOf(pose, pointsAt(part, other.only_part));
    if (gain > kHopelessInField) rivals.push_back({gain, &other});
  }
  std::stable_sort(rivals.begin(), rivals.end(),
                   [](const Rival& a, const Rival& b) { return a.odds > b.odds; });
  if (rivals.size() > kMostAligned) rivals.resize(kMostAligned);
  return rivals;
}

/// The best rival, over the points alone at which the two differ: the others find the same edges.
/// @return  whether there is a better one
bool compareNearSymmetries(const Aligner& aligner, ChosenPose* chosen) {
  const PoseHypothesis pose = chosen->pose;
  const PartModel& part = *aligner.outlineOf(pose).part;
  const auto rivals = rivalsOf(aligner, pose);
  if (rivals.empty()) return false;
  const double print = printOdds(aligner, pose);
  double best = 0.0;
  for (const auto& [gain, other] : rivals) {
    PoseHypothesis rival = moved(pose, *other);
    aligner.alignNarrow(&rival);
    const double share = 0.5 *
                         static_cast<double>(other->only_turned.size() + other->only_part.size()) /
                         static_cast<double>(part.outline().size());
    const double outline = aligner.inlierScoreOf(rival, pointsAt(part, other->only_turned)) -
                           aligner.inlierScoreOf(pose, pointsAt(part, other->only_part));
    const double odds =
        outline * std::sqrt(share) / kOutlineSigma + printOdds(aligner, rival) - print;
    if (odds <= best || rival.inlier_score < pose.inlier_score - kOutlineWorse) continue;
    best = odds;
    chosen->pose = rival;
  }
  return best > 0.0;
}

/// Symmetries that the print alone tells apart.
void comparePrint(const Aligner& aligner, ChosenPose* chosen) {
  const PartOutline& outline = aligner.outlineOf(chosen->pose);
  if (outline.print.empty()) return;
  double best = printOdds(aligner, chosen->pose);
  const NearSymmetry* other_best = nullptr;
  for (const auto& other : outline.part->nearSymmetries()) {
    if (!other.exact) continue;
    const double odds = printOdds(aligner, moved(chosen->pose, other));
    if (odds <= best) continue;
    best = odds;
    other_best = &other;
  }
  if (other_best == nullptr) return;
  chosen->pose = moved(chosen->pose, *other_best);
  aligner.alignNarrow(&chosen->pose);
}

/// Which poses tell how parts lie: of all about one place the best.
std::vector<std::size_t> tellingOf(const Aligner& aligner, const std::vector<ChosenPose>& poses) {
  std::vector<Eigen::Vector3d> centres;
  for (const ChosenPose& chosen : poses) {
    const PartModel& part = *aligner.outlineOf(chosen.pose).part;
    centres.push_back(chosen.pose.T_camera_part * centreOf(part, chosen.pose.face).translation());
  }
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double score = poses[i].pose.inlier_score;
    if (score < kTells) continue;
    const double radius = kOnePlace * aligner.outlineOf(poses[i].pose).part->radius();
    bool is_best = true;
    for (std::size_t j = 0; j < poses.size() && is_best; ++j) {
      const double other = poses[j].pose.inlier_score;
      is_best = (other < score || (other == score && j >= i)) ||
                (centres[j] - centres[i]).norm() > radius;
    }
    if (is_best) out.push_back(i);
  }
  return out;
}

/// Probability of the pose, by the log odds over the other tilt.
double sureOf(const ChosenPose& chosen, double odds) {
  return chosen.other_tilt ? 1.0 / (1.0 + std::exp(-odds)) : 1.0;
}

/// How the parts of a picture lie, as far as is known.
std::vector<SceneNormal> normalsOf(const std::vector<ChosenPose>& poses,
                                   const std::vector<std::size_t>& telling,
                                   const std::vector<double>& variances,
                                   const std::vector<double>& odds) {
  std::vector<SceneNormal> out;
  for (const std::size_t i : telling) {
    const ChosenPose& chosen = poses[i];
    const double sure = sureOf(chosen, odds[i]);
    out.push_back({normalOf(chosen.pose), variances[i], sure, i});
    if (chosen.other_tilt)
      out.push_back({normalOf(*chosen.other_tilt), variances[i], 1.0 - sure, i});
  }
  return out;
}

}  // namespace

ChosenPose chooseHypothesis(const Aligner& aligner, const RefineParams& params,
                            const PoseHypothesis& pose) {
  ChosenPose chosen{pose, std::nullopt, 0.0};
  // Each rival was compared with the pose, not yet with the other ones.
  for (int round = 0; round < kRivalRounds; ++round)
    if (!compareNearSymmetries(aligner, &chosen)) break;
  comparePrint(aligner, &chosen);
  compareTilts(aligner, params, &chosen);
  return chosen;
}

void decideTilts(const Aligner& aligner, const std::optional<Eigen::Vector3d>& floor_normal,
                 std::vector<ChosenPose>* poses) {
  std::vector<double> variances, odds;  // rad^2 per axis; log odds of pose over other_tilt
  for (const ChosenPose& chosen : *poses) {
    const Matrix6d covariance =
        withOwnOffset(chosen.pose, aligner.outlineOf(chosen.pose), aligner.focal()).covariance;
    variances.push_back(0.5 * (covariance(3, 3) + covariance(4, 4)));
    odds.push_back(chosen.lead);
  }
  const auto telling = tellingOf(aligner, *poses);
  for (int round = 0; round < kTiltRounds; ++round) {
    auto scene = normalsOf(*poses, telling, variances, odds);
    if (floor_normal)
      scene.push_back({*floor_normal, kFloorSigma * kFloorSigma, kFloorParts, poses->size()});
    for (std::size_t i = 0; i < poses->size(); ++i) {
      const ChosenPose& chosen = (*poses)[i];
      if (!chosen.other_tilt) continue;
      const auto density = [&](const PoseHypothesis& pose) {
        return logTiltDensity(scene, normalOf(pose), variances[i], i);
      };
      odds[i] = chosen.lead + density(chosen.pose) - density(*chosen.other_tilt);
    }
  }
  for (std::size_t i = 0; i < poses->size(); ++i) {
    ChosenPose& chosen = (*poses)[i];
    chosen.odds = std::isnan(odds[i]) ? 0.0 : std::abs(odds[i]);  // no number decides nothing
    if (!chosen.other_tilt || !(odds[i] < 0.0)) continue;
    std::swap(chosen.pose, *chosen.other_tilt);
    aligner.alignNarrow(&chosen.pose);
  }
}

Vector6d otherTiltOf(const Aligner& aligner, const ChosenPose& decided, const RefinedPose& pose) {
  if (!decided.other_tilt) return Vector6d::Zero();
  const Eigen::Isometry3d T_part_centre =
      centreOf(*aligner.outlineOf(decided.pose).part, pose.face);
  return std::sqrt(1.0 - sureOf(decided, decided.odds)) *
         log((pose.T_camera_part * T_part_centre).inverse() * decided.other_tilt->T_camera_part *
             T_part_centre);
}

}  // namespace planar_bin_picking
