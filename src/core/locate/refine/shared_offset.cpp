// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/shared_offset.h"

#include "base/parallel.h"
#include "locate/prior/common_normal.h"
#include "locate/refine/edge_offset.h"
#include "locate/refine/suppression.h"
#include "locate/refine/tilt_curve.h"
#include "part/part_extent.h"
#include "part/visible_face.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace planar_bin_picking {
namespace {

/// Inlier scores from which on a pose may tell, and how far below the best one of its part: what is
/// seen whole tells more than what lies along the edges of others.
constexpr double kTells = 0.7, kBelowBest = 0.1;
/// Cosine between an outline's normal and the length from which on it faces an end.
constexpr double kFacesTheEnd = 0.7;
/// Lengths of two poses at one place that differ by less than this (12 degrees) are of one copy.
constexpr double kOneWay = 0.2;
/// Offsets that are tried, metres.
constexpr double kOffsetLeast = -0.2e-3, kOffsetMost = 0.5e-3, kOffsetStep = 0.01e-3;
/// Standard deviations of the copies' offsets that are tried, metres (edge_offset.cpp).
constexpr std::array<double, 3> kSpreads{0.01e-3, 0.025e-3, 0.05e-3};
/// One copy in ten is none, or its edges are those of others.
constexpr double kShareWrong = 0.1;
constexpr double kUnlikely = 1e-6;  // trials of which nothing is left
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
/// Where the tilt that looks along the line of sight is less likely than this share of the
/// likeliest, the tilts to its two sides are two answers, and the likelier one is given.
constexpr double kValley = 0.3;

/// One copy: the likelihood of tilt and offset, and the prior of its tilt.
struct Copy {
  bool tells;  // of the offset
  TiltCurve curve;
  std::vector<double> log_prior;  // of each tilt of the curve
};

/// Offset of all copies and its spread from copy to copy that are tried together, metres.
struct Trial {
  double offset, spread;
};

std::vector<Trial> trials() {
  std::vector<Trial> out;
  const int n = static_cast<int>(std::lround((kOffsetMost - kOffsetLeast) / kOffsetStep));
  for (const double spread : kSpreads)
    for (int i = 0; i <= n; ++i) out.push_back({kOffsetLeast + i * kOffsetStep, spread});
  return out;
}

/// Logarithm of one tilt's likelihood and prior.
double logAt(const Copy& copy, std::size_t tilt, const Trial& trial) {
  const TiltPoint& p = copy.curve.points()[tilt];
  const double own = p.offset_sigma * p.offset_sigma, variance = own + trial.spread * trial.spread;
  const double off = trial.offset - p.offset;
  // At its best offset a tilt has its misfit; the spread costs what any width costs.
  return copy.log_prior[tilt] - p.misfit - 0.5 * off * off / variance +
         0.5 * std::log(own / variance);
}

double logSum(const std::vector<double>& logs) {
  const double most = *std::max_element(logs.begin(), logs.end());
  double sum = 0.0;
  for (const double l : logs) sum += std::exp(l - most);
  return most + std::log(sum);
}

/// Logarithm of each trial's likelihood by one copy, over all of its tilts.
std::vector<double> logLikelihoods(const Copy& copy, const std::vector<Trial>& tried) {
  std::vector<double> out, logs(copy.log_prior.size());
  for (const Trial& trial : tried) {
    for (std::size_t k = 0; k < logs.size(); ++k) logs[k] = logAt(copy, k, trial);
    out.push_back(logSum(logs));
  }
  // A copy that is none may have any offset.
  const double any = logSum(out) - std::log(static_cast<double>(tried.size()));
  for (double& l : out) l = logSum({l + std::log(1.0 - kShareWrong), any + std::log(kShareWrong)});
  return out;
}

/// Normalized, of its logarithm.
std::vector<double> probabilities(std::vector<double> logs) {
  const double all = logSum(logs);
  for (double& l : logs) l = std::exp(l - all);
  return logs;
}

struct Moments {
  double mean = 0.0, variance = 0.0;
};

template <class At>
Moments momentsOf(const std::vector<double>& p, std::size_t from, std::size_t to, At&& at) {
  double sum = 0.0;
  Moments out;
  for (std::size_t k = from; k < to; ++k) {
    sum += p[k];
    out.mean += p[k] * at(k);
  }
  out.mean /= sum;
  for (std::size_t k = from; k < to; ++k)
    out.variance += p[k] * std::pow(at(k) - out.mean, 2) / sum;
  return out;
}

/// What the copies of one face of a part say together.
struct SharedOffset {
  Moments offset;
  double spread = 0.0;
  std::vector<Moments> tilts;  // of each copy
};

/// Mean and variance of a tilt; where both sides of the line of sight are two answers, of the
/// likelier one.
Moments tiltOf(const std::vector<double>& p) {
  const auto tilt = [](std::size_t k) { return TiltCurve::tiltOf(k); };
  const std::size_t middle = p.size() / 2;
  const double most = *std::max_element(p.begin(), p.end());
  const double valley = *std::max_element(p.begin() + middle - 1, p.begin() + middle + 2);
  if (valley > kValley * most) return momentsOf(p, 0, p.size(), tilt);
  double left = 0.0, right = 0.0;
  for (std::size_t k = 0; k < middle; ++k) left += p[k];
  for (std::size_t k = middle + 1; k < p.size(); ++k) right += p[k];
  return left > right ? momentsOf(p, 0, middle, tilt) : momentsOf(p, middle + 1, p.size(), tilt);
}

/// Of each tilt of a copy, by what the others say of the offset.
std::vector<double> tiltsOf(const Copy& copy, const std::vector<Trial>& trials,
                            const std::vector<double>& others) {
  std::vector<double> tilts, logs;
  const auto p = probabilities(others);
  for (std::size_t k = 0; k < copy.log_prior.size(); ++k) {
    logs.clear();
    for (std::size_t j = 0; j < trials.size(); ++j)
      if (p[j] > kUnlikely) logs.push_back(std::log(p[j]) + logAt(copy, k, trials[j]));
    tilts.push_back(logSum(logs));
  }
  return probabilities(tilts);
}

SharedOffset estimate(const std::vector<std::optional<Copy>>& copies) {
  const std::vector<Trial> tried = trials();
  std::vector<double> all;
  for (const Trial& trial : tried) all.push_back(logOffsetPrior(trial.offset));
  std::vector<std::vector<double>> by_copy;
  for (const auto& copy : copies) {
    by_copy.push_back(copy->tells ? logLikelihoods(*copy, tried)
                                  : std::vector<double>(tried.size(), 0.0));
    for (std::size_t j = 0; j < all.size(); ++j) all[j] += by_copy.back()[j];
  }
  SharedOffset out;
  const auto p = probabilities(all);
  out.offset = momentsOf(p, 0, p.size(), [&](std::size_t j) { return tried[j].offset; });
  out.spread = std::sqrt(
      momentsOf(p, 0, p.size(), [&](std::size_t j) { return std::pow(tried[j].spread, 2); }).mean);
  for (std::size_t c = 0; c < copies.size(); ++c) {
    std::vector<double> others = all;
    for (std::size_t j = 0; j < all.size(); ++j) others[j] -= by_copy[c][j];
    out.tilts.push_back(tiltOf(tiltsOf(*copies[c], tried, others)));
  }
  return out;
}

/// Whether the ends of a slender part are seen: the two long sides alone lie along any two edges.
bool endsAreSeen(const Aligner& aligner, const PoseHypothesis& pose,
                 const Eigen::Vector2d& length) {
  std::vector<LocalPoint> ends;
  for (const LocalPoint& p : aligner.outlineOf(pose).of(pose.face).fine)
    if (std::abs(length.x() * p.ty - length.y() * p.tx) > kFacesTheEnd) ends.push_back(p);
  return aligner.inlierScoreOf(pose, ends) > kTells;
}

/// Middle of the visible face, in the camera's frame.
Eigen::Vector3d middleOf(const Aligner& aligner, const PoseHypothesis& pose) {
  return pose.T_camera_part * centreOf(*aligner.outlineOf(pose).part, pose.face).translation();
}

/// Of all poses about one place the best.
std::vector<std::size_t> bestOfPlaces(const Aligner& aligner,
                                      const std::vector<PoseHypothesis>& poses) {
  std::vector<Eigen::Vector3d> middles;
  for (const PoseHypothesis& p : poses) middles.push_back(middleOf(aligner, p));
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double score = poses[i].inlier_score;
    if (score < kTells || poses[i].image.status != AlignmentStatus::kAligned) continue;
    const double grain = aligner.outlineOf(poses[i]).grain;
    bool is_best = true;
    for (std::size_t j = 0; j < poses.size() && is_best; ++j) {
      const double other = poses[j].inlier_score;
      is_best = other < score || (other == score && j >= i) ||
                (middles[j] - middles[i]).head<2>().norm() > grain;
    }
    if (is_best) out.push_back(i);
  }
  return out;
}

/// Without those that are a held copy at another tilt: each of its tilts has been weighed.
void dropOtherTilts(const Aligner& aligner, const Eigen::Vector2d& length,
                    const std::vector<std::size_t>& held, std::size_t part,
                    std::vector<PoseHypothesis>* poses) {
  const Eigen::Vector3d axis(length.x(), length.y(), 0.0);
  const auto isOther = [&](std::size_t i) {
    const PoseHypothesis& p = (*poses)[i];
    if (p.part != part || std::count(held.begin(), held.end(), i) > 0) return false;
    return std::any_of(held.begin(), held.end(), [&](std::size_t h) {
      const PoseHypothesis& of = (*poses)[h];
      const Eigen::Vector3d off = middleOf(aligner, p) - middleOf(aligner, of);
      const Eigen::Vector3d way = p.T_camera_part.linear() * axis;
      return off.head<2>().norm() < aligner.outlineOf(p).grain &&
             way.cross(of.T_camera_part.linear() * axis).norm() < kOneWay;
    });
  };
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < poses->size(); ++i)
    if (!isOther(i)) kept.push_back(i);
  keepOnly(kept, poses);
}

/// The image's pose with its tilt held at what all copies say of it.
void holdTilt(const Aligner& aligner, const Copy& copy, const Moments& tilt, PoseHypothesis* pose) {
  const PartOutline& outline = aligner.outlineOf(*pose);
  const FaceOutline& of_face = outline.of(pose->face);
  const double radius = outline.part->radius();
  const Eigen::Isometry3d T = copy.curve.poseAt(tilt.mean, of_face.offset);
  pose->T_camera_part = T * centreOf(*outline.part, pose->face).inverse();
  aligner.look(pose);
  ImagePose& image = pose->image;
  if (image.status != AlignmentStatus::kAligned) return;
  Vector6d axis = Vector6d::Zero();
  axis.tail<3>() = copy.curve.axis();
  const Vector6d follows = image.covariance * axis / axis.dot(image.covariance * axis);
  const double own = axis.dot(image.covariance * axis);
  image.covariance += (tilt.variance - own) * follows * follows.transpose();
  image.per_offset -= axis.dot(image.per_offset) * follows;
  const auto& points = copy.curve.points();
  const std::size_t k = copy.curve.nearest(tilt.mean);
  image.offset = (points[k].offset - of_face.offset) / radius;
  image.offset_sigma = points[k].offset_sigma / radius;
}

/// What of a picture tells how its parts lie, before any tilt changes.
struct Scene {
  std::vector<std::size_t> best;        // poses, each the best of its place
  std::vector<bool> tells;              // each of these
  std::vector<MeasuredNormal> normals;  // of those that tell
  std::vector<std::size_t> normal_of;   // each of best: index of its normal, or none
};

Scene sceneOf(const Aligner& aligner, const std::vector<PoseHypothesis>& poses,
              const std::vector<std::optional<Eigen::Vector2d>>& lengths) {
  Scene out;
  out.best = bestOfPlaces(aligner, poses);
  std::vector<double> scores(aligner.outlines().size(), 0.0);
  for (const PoseHypothesis& p : poses) scores[p.part] = std::max(scores[p.part], p.inlier_score);
  for (const std::size_t i : out.best) {
    const PoseHypothesis& p = poses[i];
    const auto& length = lengths[p.part];
    const bool tells = p.inlier_score > scores[p.part] - kBelowBest &&
                       (!length || endsAreSeen(aligner, p, *length));
    out.tells.push_back(tells);
    out.normal_of.push_back(tells ? out.normals.size() : kNone);
    if (tells)
      out.normals.push_back(measuredNormal(p.T_camera_part, p.face,
                                           p.image.covariance.bottomRightCorner<3, 3>(), length));
  }
  return out;
}

Copy copyOf(const Scene& scene, std::size_t k, const Aligner& aligner, const PoseHypothesis& pose,
            const Eigen::Vector2d& length) {
  Copy copy{scene.tells[k],
            TiltCurve(aligner.edges(), aligner.camera(), pose, aligner.outlineOf(pose), length),
            {}};
  const CommonNormal common = commonNormal(scene.normals, scene.normal_of[k]);
  const double up = pose.face == Face::kFront ? 1.0 : -1.0;
  const Eigen::Vector3d across = copy.curve.axis().cross(Eigen::Vector3d::UnitZ());
  for (std::size_t j = 0; j < copy.curve.points().size(); ++j) {
    const Eigen::Matrix3d R = copy.curve.points()[j].T_camera_centre.linear();
    copy.log_prior.push_back(logTiltPrior(common, up * R.col(2), R * across, TiltCurve::tiltOf(j)));
  }
  return copy;
}

/// Offset and tilts of all copies that show one face.
/// @return  poses whose tilts are held from now on
std::vector<std::size_t> shareOffset(const Scene& scene, std::size_t part, Face face,
                                     const Eigen::Vector2d& length, int threads, Aligner* aligner,
                                     std::vector<PoseHypothesis>* poses) {
  const auto isOfFace = [&](const PoseHypothesis& p) { return p.part == part && p.face == face; };
  std::vector<std::size_t> of_face, held;  // into scene.best, and poses
  bool tell = false;
  for (std::size_t k = 0; k < scene.best.size(); ++k) {
    if (!isOfFace((*poses)[scene.best[k]])) continue;
    of_face.push_back(k);
    held.push_back(scene.best[k]);
    tell = tell || scene.tells[k];
  }
  if (!tell) return {};
  std::vector<std::optional<Copy>> copies(of_face.size());
  parallelFor(static_cast<int>(of_face.size()), threads, [&](int i) {
    copies[i] = copyOf(scene, of_face[i], *aligner, (*poses)[held[i]], length);
  });
  const SharedOffset shared = estimate(copies);
  setEdgeOffset(shared.offset.mean, std::sqrt(shared.offset.variance), shared.spread, face,
                &aligner->outlines()[part]);
  parallelFor(static_cast<int>(poses->size()), threads, [&](int i) {
    PoseHypothesis& p = (*poses)[i];
    if (isOfFace(p) && !std::count(held.begin(), held.end(), i)) aligner->alignNarrow(&p);
  });
  for (std::size_t c = 0; c < copies.size(); ++c)
    holdTilt(*aligner, *copies[c], shared.tilts[c], &(*poses)[held[c]]);
  return held;
}

}  // namespace

void shareOffsets(Aligner* aligner, std::vector<PoseHypothesis>* poses, int threads) {
  std::vector<std::optional<Eigen::Vector2d>> lengths;
  for (const PartOutline& outline : aligner->outlines())
    lengths.push_back(lengthOfSlender(*outline.part));
  for (std::size_t part = 0; part < lengths.size(); ++part) {
    if (!lengths[part]) continue;
    const Scene scene = sceneOf(*aligner, *poses, lengths);
    std::vector<std::size_t> held;
    for (const Face face : {Face::kFront, Face::kBack}) {
      const auto more = shareOffset(scene, part, face, *lengths[part], threads, aligner, poses);
      held.insert(held.end(), more.begin(), more.end());
    }
    dropOtherTilts(*aligner, *lengths[part], held, part, poses);
  }
}

}  // namespace planar_bin_picking
