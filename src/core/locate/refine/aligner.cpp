// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/aligner.h"

#include "locate/align/field_alignment.h"
#include "locate/evidence/inlier_score.h"
#include "locate/evidence/print_evidence.h"
#include "locate/evidence/wall_bands.h"
#include "locate/evidence/wall_evidence.h"
#include "part/part_extent.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Reach in pixels, twice what a wide alignment leaves; and the sigma of a sharp edge.
constexpr SearchProfile kNarrow{4, true, 0.8};
/// Tukey's widths, pixels: below the reach, so that what lies at its end weighs little.
constexpr std::array<double, 2> kNarrowTukey{3.0, 2.0};
/// The same for the wide alignment and the search: in shares of the reach, and at last the reach of
/// the narrow alignment, pixels. What others follow needs few points.
constexpr std::array<double, 2> kWideTukey{1.0, 0.7}, kSearchTukey{1.0, 0.5};
constexpr double kWideTukeyLast = 4.0;
constexpr double kWideSigma = 1.2;  // pixels: noise counts less than exactness
/// What the field leaves: this share of the part's radius, and pixels, between these.
constexpr double kWideShare = 0.03;
constexpr int kWideLeast = 6, kWideMost = 14;
/// Pixels off the outline from which on an edge is no inlier: what a wide alignment leaves.
constexpr double kInlierReachPx = 2.0;
/// In the field: a share of its reach at the end, since candidates are compared before they are
/// aligned to sub-pixel edges; and field pixels, to compare poses that are.
constexpr double kFieldInlierReach = 1.5, kFieldCompareReachPx = 2.0;

/// Starts of the search: relative distance, half a step of the vote (hough/distance_step), since
/// the next step has a candidate of its own; turns about the part's x and y, rad: where it lies at
/// 15 to 30 degrees these move its rim as far.
constexpr std::array<std::array<double, 3>, 6> kSearch = {
    {{0.03, 0, 0}, {-0.03, 0, 0}, {0, 0.12, 0}, {0, -0.12, 0}, {0, 0, 0.12}, {0, 0, -0.12}}};

/// Starts along the slides of an outline and of its turns, the best of all.
constexpr std::size_t kSlideStarts = 4;

/// An outline is long whose points spread along one axis by more than this times the other.
constexpr double kLong = 1.5;

std::array<double, 2> timesReach(const std::array<double, 2>& shares, int reach) {
  return {shares[0] * reach, shares[1] * reach};
}

/// PartOutline::other_tilts of an outline.
std::vector<Eigen::Matrix2d> otherTiltsOf(const std::vector<LocalPoint>& points) {
  std::vector<Eigen::Matrix2d> out{-Eigen::Matrix2d::Identity()};
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const LocalPoint& p : points) mean += Eigen::Vector2d(p.x, p.y);
  mean /= static_cast<double>(points.size());
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  for (const LocalPoint& p : points) {
    const Eigen::Vector2d off = Eigen::Vector2d(p.x, p.y) - mean;
    spread += off * off.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(spread);
  if (axes.eigenvalues()(1) < kLong * kLong * axes.eigenvalues()(0)) return out;
  for (const int k : {0, 1}) {
    const Eigen::Vector2d axis = axes.eigenvectors().col(k);
    out.push_back(Eigen::Matrix2d::Identity() - 2.0 * axis * axis.transpose());
  }
  return out;
}

}  // namespace

Aligner::Aligner(const EdgeMap& edges, const Camera& camera, const RefineParams& params,
                 const std::vector<std::shared_ptr<const PartModel>>& parts)
    : edges_(edges), camera_(camera), params_(params) {
  const auto is_print = [](const OutlinePoint& p) { return p.kind == LoopKind::kPrint; };
  for (const auto& part : parts) {
    const auto shapePoints = [&part](int count) {
      return localPointsAt(*part, shapeIndices(*part, count));
    };
    const FaceOutline face{shapePoints(params.wide_points / 2), shapePoints(params.wide_points),
                           shapePoints(params.image_points)};
    outlines_.push_back({part.get(),
                         grainOf(*part),
                         shapePoints(params.field_points),
                         localPoints(*part, params.wide_points, is_print),
                         {face, face},
                         Slides(shapePoints(params.image_points)),
                         otherTiltsOf(shapePoints(params.wide_points))});
  }
}

PoseHypothesis Aligner::alignInFieldFrom(const Eigen::Isometry3d& T_camera_centre, std::size_t part,
                                         Face face, double reach_radii) const {
  const PartOutline& outline = outlines_[part];
  const double radius = outline.part->radius();
  const Field& field = edges_.fieldOf(part);
  const double reach_px = reach_radii * field.focal * radius / T_camera_centre.translation().z();
  const Eigen::Isometry3d T =
      alignInField(field, outline.field, radius, T_camera_centre, reach_px, params_);
  PoseHypothesis out;
  out.part = part;
  out.face = face;
  out.T_camera_part = T * centreOf(*outline.part, face).inverse();
  out.inlier_score = fieldInlierScore(field, outline.field, radius, T,
                                      kFieldInlierReach * params_.field_reach_end_px);
  return out;
}

PoseHypothesis Aligner::alignToField(const Candidate& candidate) const {
  const PartModel& part = *outlines_[candidate.part].part;
  return alignInFieldFrom(candidate.T_camera_part * centreOf(part, candidate.face), candidate.part,
                          candidate.face, params_.field_reach_radii);
}

std::vector<SlidPose> Aligner::slidesOf(const PoseHypothesis& pose) const {
  const PartOutline& outline = outlineOf(pose);
  if (outline.slides.empty()) return {};
  std::vector<Eigen::Isometry3d> turned{pose.T_camera_part};
  for (const auto& other : outline.part->nearSymmetries())
    if (!other.flips && !other.exact) turned.push_back(pose.T_camera_part * other.T_part_turned);
  std::vector<SlidPose> out;
  for (const Eigen::Isometry3d& T_camera_part : turned) {
    const auto peaks =
        outline.slides.peaks(edges_.fieldOf(pose.part), outline.part->radius(),
                             T_camera_part * centreOf(*outline.part, pose.face), kSlideStarts);
    out.insert(out.end(), peaks.begin(), peaks.end());
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const SlidPose& a, const SlidPose& b) { return a.score > b.score; });
  if (out.size() > kSlideStarts) out.resize(kSlideStarts);
  return out;
}

template <std::size_t N>
ImagePose Aligner::steps(const std::vector<LocalPoint>& points, const SearchProfile& profile,
                         const std::array<double, N>& tukey_px, const Solid& solid,
                         const Eigen::Isometry3d& T_camera_centre) const {
  ImagePose out;
  out.T_camera_centre = T_camera_centre;
  for (const double tukey : tukey_px)
    out = stepInImage(edges_, camera_, points, solid, out.T_camera_centre, profile, tukey);
  return out;
}

void Aligner::set(const ImagePose& image, const std::vector<LocalPoint>& points,
                  PoseHypothesis* pose) const {
  pose->image = image;
  pose->T_camera_part =
      image.T_camera_centre * centreOf(*outlineOf(*pose).part, pose->face).inverse();
  pose->inlier_score = inlierScoreOf(*pose, points);
}

int Aligner::wideReach(const PoseHypothesis& pose) const {
  const PartModel& part = *outlineOf(pose).part;
  const Eigen::Vector3d centre = pose.T_camera_part * centreOf(part, pose.face).translation();
  const double radius_px = focal() * part.radius() / centre.z();
  return std::clamp(static_cast<int>(std::lround(kWideShare * radius_px)), kWideLeast, kWideMost);
}

void Aligner::alignWide(PoseHypothesis* pose) const {
  const PartModel& part = *outlineOf(*pose).part;
  const FaceOutline& outline = outlineOf(*pose).of(pose->face);
  const Solid solid = solidOf(part, pose->face);
  const int reach = wideReach(*pose);
  const SearchProfile profile{reach, false, kWideSigma};
  const ImagePose near = steps(outline.coarse, profile, timesReach(kWideTukey, reach), solid,
                               pose->T_camera_part * centreOf(part, pose->face));
  set(stepInImage(edges_, camera_, outline.wide, solid, near.T_camera_centre, profile,
                  kWideTukeyLast),
      outline.wide, pose);
}

void Aligner::alignNarrow(PoseHypothesis* pose) const {
  const PartModel& part = *outlineOf(*pose).part;
  const auto& points = outlineOf(*pose).of(pose->face).fine;
  const Solid solid = solidOf(part, pose->face);
  const ImagePose near =
      stepInImage(edges_, camera_, points, solid, pose->T_camera_part * centreOf(part, pose->face),
                  kNarrow, kNarrowTukey.front());
  set(alignInImage(edges_, camera_, points, solid, near.T_camera_centre, kNarrow,
                   kNarrowTukey.back()),
      points, pose);
}

void Aligner::alignNarrowFromAfar(PoseHypothesis* pose) const {
  const PartModel& part = *outlineOf(*pose).part;
  const Eigen::Isometry3d T_part_centre = centreOf(part, pose->face);
  const ImagePose halfway = steps(outlineOf(*pose).of(pose->face).fine, kNarrow, kNarrowTukey,
                                  solidOf(part, pose->face), pose->T_camera_part * T_part_centre);
  pose->T_camera_part = halfway.T_camera_centre * T_part_centre.inverse();
  alignNarrow(pose);
}

void Aligner::look(PoseHypothesis* pose) const {
  const PartModel& part = *outlineOf(*pose).part;
  const auto& points = outlineOf(*pose).of(pose->face).fine;
  const Eigen::Isometry3d T = pose->T_camera_part * centreOf(part, pose->face);
  pose->image = lookInImage(edges_, camera_, points, solidOf(part, pose->face), T, kNarrow,
                            kNarrowTukey.back());
  pose->inlier_score = inlierScoreOf(*pose, points);
}

std::vector<Eigen::Isometry3d> Aligner::startsAround(const PoseHypothesis& pose) const {
  const Eigen::Isometry3d T = pose.T_camera_part * centreOf(*outlineOf(pose).part, pose.face);
  std::vector<Eigen::Isometry3d> out;
  if (pose.inlier_score <= params_.search_below) {
    for (const auto& [farther, about_x, about_y] : kSearch) {
      Eigen::Isometry3d start = T;
      start.translation() *= 1.0 + farther;
      start.linear() = T.linear() * (Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX()) *
                                     Eigen::AngleAxisd(about_y, Eigen::Vector3d::UnitY()))
                                        .toRotationMatrix();
      out.push_back(start);
    }
  }
  for (const SlidPose& slid : slidesOf(pose)) out.push_back(slid.T_camera_centre);
  return out;
}

void Aligner::searchAround(PoseHypothesis* pose) const {
  if (pose->searched) return;
  const auto starts = startsAround(*pose);
  if (starts.empty()) return;
  const PartModel& part = *outlineOf(*pose).part;
  const auto& points = outlineOf(*pose).of(pose->face).coarse;
  const Solid solid = solidOf(part, pose->face);
  const Eigen::Isometry3d T_centre_part = centreOf(part, pose->face).inverse();
  PoseHypothesis best = *pose;
  best.inlier_score = inlierScoreOf(*pose, points);
  for (const Eigen::Isometry3d& start : starts) {
    PoseHypothesis other = *pose;
    other.T_camera_part = start * T_centre_part;
    const int reach = wideReach(other);
    set(steps(points, {reach, false, kWideSigma}, timesReach(kSearchTukey, reach), solid, start),
        points, &other);
    if (other.inlier_score > best.inlier_score) best = other;
  }
  alignWide(&best);
  pose->searched = best.inlier_score <= pose->inlier_score;
  if (!pose->searched) *pose = best;
}

double Aligner::inlierScoreOf(const PoseHypothesis& pose,
                              const std::vector<LocalPoint>& points) const {
  std::vector<EdgeHit> hits;
  const PartModel& part = *outlineOf(pose).part;
  findHits(edges_, camera_, points, solidOf(part, pose.face),
           pose.T_camera_part * centreOf(part, pose.face), kNarrow, &hits);
  return inlierScore(hits, kInlierReachPx);
}

double Aligner::fieldInlierScoreOf(const PoseHypothesis& pose,
                                   const std::vector<LocalPoint>& points) const {
  const PartModel& part = *outlineOf(pose).part;
  return fieldInlierScore(edges_.fieldOf(pose.part), points, part.radius(),
                          pose.T_camera_part * centreOf(part, pose.face), kFieldCompareReachPx);
}

std::optional<double> Aligner::wallScoreOf(const PoseHypothesis& pose) const {
  const PartOutline& outline = outlineOf(pose);
  return wallScore(edges_, camera_, outline.of(pose.face).fine, solidOf(*outline.part, pose.face),
                   pose.T_camera_part * centreOf(*outline.part, pose.face));
}

double Aligner::wallBandsOf(const PoseHypothesis& pose, const PoseHypothesis& other) const {
  const PartOutline& outline = outlineOf(pose);
  const Eigen::Isometry3d T_part_centre = centreOf(*outline.part, pose.face);
  return wallBands(edges_, camera_, outline.of(pose.face).fine, solidOf(*outline.part, pose.face),
                   pose.T_camera_part * T_part_centre, other.T_camera_part * T_part_centre);
}

double Aligner::printScoreOf(const PoseHypothesis& pose) const {
  const PartOutline& outline = outlineOf(pose);
  return printScore(edges_, camera_, outline.print, outline.part->radius(),
                    pose.T_camera_part * centreOf(*outline.part, pose.face));
}

}  // namespace planar_bin_picking
