// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/edge_offset.h"

#include "base/scatter.h"
#include "locate/prior/linear_prior.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

/// What is known of a part's mean offset before anything is seen: bevels and roundings of cut edges
/// take away, and never add. (Where holes and outline tell, rendered parts have -0.03 to 0.10 mm,
/// photographed ones 0.01 to 0.08, simulated ones 0.15. A polygon whose sides are equally far from
/// one point tells nothing: its offset looks like its distance.)
constexpr double kMean = 0.05e-3, kMeanSigma = 0.1e-3;
/// Inlier scores from which on poses tell where edges lie; of others a side may have been aligned
/// to a neighbour's edge.
constexpr double kWellAligned = 0.7;
/// Spread of the copies, metres, where fewer than these tell it, and what it is at least: a third
/// and a seventh of the above, the tools that cut the copies being the same.
constexpr double kSpreadUnknown = 0.05e-3, kSpreadLeast = 0.02e-3;
constexpr std::size_t kFew = 4;
/// Radii of the part: the standard deviation of an offset that the image does not tell.
constexpr double kOpen = 1.0;
/// Standard deviation of a pose in pixels at least, whatever the edges say: what lens model and
/// interpolation leave of a sub-pixel edge's error over a whole outline.
constexpr double kFloorPx = 0.02;

struct Measured {
  double offset, variance;
};

/// Variance of the true offsets: what the measured ones scatter beyond their errors.
double spreadOf(const std::vector<Measured>& measured) {
  if (measured.size() < kFew) return kSpreadUnknown * kSpreadUnknown;
  std::vector<double> values, squares, variances;
  for (const auto& m : measured) values.push_back(m.offset);
  const double middle = median(values);
  for (const auto& m : measured) {
    squares.push_back((m.offset - middle) * (m.offset - middle));
    variances.push_back(m.variance);
  }
  return scatterBeyond(squares, kVarianceOfOne, variances, kSpreadLeast);
}

void estimateOffset(const std::vector<PoseHypothesis>& poses, std::size_t part, Face face,
                    PartOutline* outline) {
  const FaceOutline& of_face = outline->of(face);
  const double radius = outline->part->radius();
  std::vector<Measured> measured;
  for (const auto& p : poses) {
    if (p.part != part || p.face != face || p.inlier_score < kWellAligned) continue;
    if (!std::isfinite(p.image.offset_sigma)) continue;
    measured.push_back(
        {of_face.offset + radius * p.image.offset, std::pow(radius * p.image.offset_sigma, 2)});
  }
  const double spread = spreadOf(measured);
  double weight = 1.0 / (kMeanSigma * kMeanSigma), sum = weight * kMean;
  for (const auto& m : measured) {
    sum += m.offset / (m.variance + spread);
    weight += 1.0 / (m.variance + spread);
  }
  setEdgeOffset(sum / weight, std::sqrt(1.0 / weight), std::sqrt(spread), face, outline);
}

}  // namespace

double logOffsetPrior(double offset) { return -0.5 * std::pow((offset - kMean) / kMeanSigma, 2); }

void setEdgeOffset(double offset, double sigma, double spread, Face face, PartOutline* outline) {
  FaceOutline& of_face = outline->of(face);
  for (auto* points : {&of_face.coarse, &of_face.wide, &of_face.fine})
    moveInward((offset - of_face.offset) / outline->part->radius(), points);
  of_face.offset = offset;
  of_face.offset_sigma = sigma;
  of_face.offset_spread = spread;
}

void estimateEdgeOffsets(const std::vector<PoseHypothesis>& poses,
                         std::vector<PartOutline>* outlines) {
  for (std::size_t part = 0; part < outlines->size(); ++part) {
    for (const Face face : {Face::kFront, Face::kBack})
      estimateOffset(poses, part, face, &(*outlines)[part]);
  }
}

RefinedPose withOwnOffset(const PoseHypothesis& pose, const PartOutline& outline, double focal_px) {
  const PartModel& part = *outline.part;
  const FaceOutline& of_face = outline.of(pose.face);
  const double r = part.radius();
  const ImagePose& image = pose.image;
  // Seven unknowns: xi and the offset beyond the mean, in radii and radians. The image tells xi
  // for a given offset, and the offset; the other copies tell the offset, too.
  Estimate<7> seen;
  Eigen::Matrix<double, 7, 1> follows;
  follows << image.per_offset, 1.0;
  const bool told = std::isfinite(image.offset_sigma);
  const double own_sigma = told ? image.offset_sigma : kOpen;
  seen.mean = follows * (told ? image.offset : 0.0);
  seen.covariance = own_sigma * own_sigma * follows * follows.transpose();
  seen.covariance.topLeftCorner<6, 6>() += image.covariance;
  LinearPrior<7, 1> copies;
  copies.jacobian << 0, 0, 0, 0, 0, 0, 1;
  copies.residual << 0.0;
  copies.covariance << std::pow(of_face.offset_spread / r, 2);
  const Estimate<7> both = fuse(seen, copies);
  // The mean of the copies is not known exactly either, and moves all of them alike.
  const double copies_share =
      own_sigma * own_sigma / (own_sigma * own_sigma + copies.covariance(0, 0));
  const double mean_sigma = copies_share * of_face.offset_sigma / r;
  const double floor = kFloorPx * image.T_camera_centre.translation().z() / (focal_px * r);

  RefinedPose out;
  out.part = pose.part;
  out.face = pose.face;
  out.residual_px = image.residual_px;
  out.edge_offset = of_face.offset + r * both.mean(6);
  out.T_camera_part =
      stepped(image.T_camera_centre, both.mean.head<6>(), r) * centreOf(part, pose.face).inverse();
  Matrix6d covariance = both.covariance.topLeftCorner<6, 6>() +
                        mean_sigma * mean_sigma * image.per_offset * image.per_offset.transpose();
  covariance.diagonal().array() += floor * floor;
  Vector6d unit;
  unit << r, r, r, 1.0, 1.0, 1.0;
  out.covariance = unit.asDiagonal() * covariance * unit.asDiagonal();
  return out;
}

}  // namespace planar_bin_picking
