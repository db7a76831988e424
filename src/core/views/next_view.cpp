// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/next_view.h"

#include "part/visible_face.h"
#include "views/camera_errors.h"
#include "views/joint_pose.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace planar_bin_picking {
namespace {

constexpr double kDegree = EIGEN_PI / 180.0;
/// Faces seen more from the side than this show thin edges and much of what stands before them.
constexpr double kGrazing = 0.45;  // cosine
constexpr double kBorder = 0.04;   // of the picture's width and height
/// Tukey's width of the narrow alignment.
constexpr double kTukeyPx = 2.0;
/// Candidates: tilts up to the cone, directions about it, distances within the focus.
constexpr int kTilts = 4, kDirections = 12, kDistances = 4;
/// A place as good as this much of the best one is as good: then the nearest is taken.
constexpr double kAsGood = 1.05;

/// Whether no wall of the bin stands between the camera and any point of the outline.
bool isOverTheWalls(const SeenPart& seen, const Eigen::Isometry3d& T_base_camera,
                    const Eigen::Isometry3d& T_base_centre, const ViewBin& bin) {
  const Eigen::Vector3d eye = bin.T_bin_base * T_base_camera.translation();
  if (eye.z() <= bin.max.z()) return false;
  for (const LocalPoint& p : seen.coarse) {
    const Eigen::Vector3d q =
        bin.T_bin_base * T_base_centre * (seen.solid.radius * Eigen::Vector3d(p.x, p.y, 0.0));
    if (q.z() >= bin.max.z()) continue;
    const double share = (bin.max.z() - q.z()) / (eye.z() - q.z());
    const Eigen::Vector3d at_rim = q + share * (eye - q);
    if (at_rim.x() < bin.min.x() || at_rim.x() > bin.max.x() || at_rim.y() < bin.min.y() ||
        at_rim.y() > bin.max.y())
      return false;
  }
  return true;
}

struct Place {
  Eigen::Isometry3d T_first_camera;
  double travel;  // metres
};

/// Looking at the point along a ray tilted by `tilt` against the first optical axis.
Place placeAt(const Eigen::Vector3d& x_first, double tilt, double direction, double distance) {
  const Eigen::Vector3d axis(std::cos(direction), std::sin(direction), 0.0);
  Place place{Eigen::Isometry3d::Identity(), 0.0};
  place.T_first_camera.linear() = Eigen::AngleAxisd(tilt, axis).toRotationMatrix();
  place.T_first_camera.translation() = x_first - distance * place.T_first_camera.linear().col(2);
  place.travel = place.T_first_camera.translation().norm();
  return place;
}

std::vector<Place> placesFor(const Eigen::Vector3d& centre, const NextViewLimits& limits) {
  std::vector<Place> places;
  for (int d = 0; d < kDistances; ++d) {
    const double share = (d + 0.5) / kDistances;
    const double distance = limits.focus.min + share * (limits.focus.max - limits.focus.min);
    for (int t = 1; t <= kTilts; ++t)
      for (int a = 0; a < kDirections; ++a)
        places.push_back(placeAt(centre, limits.cone_deg * kDegree * t / kTilts,
                                 2.0 * EIGEN_PI * a / kDirections, distance));
  }
  return places;
}

/// Whether the whole outline is in the picture, between the distances, and seen from above.
bool isInView(const SeenPart& seen, const Camera& camera, const Eigen::Isometry3d& T_view_centre,
              const std::optional<Distances>& focus) {
  const Camera::Model& model = camera.model();
  const double sign = seen.face == Face::kFront ? 1.0 : -1.0;
  const Eigen::Vector3d centre = T_view_centre.translation();
  if (centre.z() <= seen.solid.radius) return false;
  if (-sign * T_view_centre.linear().col(2).dot(centre.normalized()) < kGrazing) return false;
  for (const LocalPoint& p : seen.coarse) {
    const Eigen::Vector3d q = T_view_centre * (seen.solid.radius * Eigen::Vector3d(p.x, p.y, 0.0));
    if (focus && (q.z() < focus->min || q.z() > focus->max)) return false;
    const Eigen::Vector2d pixel = camera.project(q);
    if (pixel.x() < kBorder * model.width || pixel.x() > (1.0 - kBorder) * model.width ||
        pixel.y() < kBorder * model.height || pixel.y() > (1.0 - kBorder) * model.height)
      return false;
  }
  return true;
}

/// Of the part's points that nothing covered when it was located.
std::vector<AlignmentRow> expectedRows(const SeenPart& seen, const Detection& known,
                                       const Camera& camera,
                                       const Eigen::Isometry3d& T_view_centre) {
  constexpr double kReachPx = 4.0;
  constexpr double kScatterPx = 0.1;  // edges that scatter not at all would count as too few
  const FaceGrid& grid = seen.part->faceGrid();
  std::vector<AlignmentRow> rows;
  for (const LocalPoint& p : seen.fine) {
    const OutlinePoint& drawn = seen.part->outline()[static_cast<std::size_t>(p.index)];
    const int cell = grid.cellNear(drawn.position);
    if (std::binary_search(known.covered.begin(), known.covered.end(), cell)) continue;
    PosedPoint at;
    if (!posePoint(camera, p, seen.solid.radius, T_view_centre, &at)) continue;
    const double offset = rows.size() % 2 == 0 ? kScatterPx : -kScatterPx;
    rows.push_back({normalJacobian(p, at), offset, at.out_px,
                    trustOf(wallWidth(seen.solid, at.deep_px), kReachPx)});
  }
  return rows;
}

struct Units {
  explicit Units(double radius) { in_radii << Eigen::Vector3d::Constant(1.0 / radius), 1, 1, 1; }
  Vector6d in_radii;
  Matrix6d toRadii(const Matrix6d& C) const {
    return in_radii.asDiagonal() * C * in_radii.asDiagonal();
  }
  Matrix6d toMetres(const Matrix6d& C) const {
    const Vector6d back = in_radii.cwiseInverse();
    return back.asDiagonal() * C * back.asDiagonal();
  }
};

/// What a look along those rows says, where the camera may be off by `correction`.
std::optional<Matrix7d> informationOf(const std::vector<AlignmentRow>& rows, double radius,
                                      const Matrix6d& correction) {
  const Said said = saidBy(rows, Vector6d::Zero(), kTukeyPx, radius);
  if (!said.told) return std::nullopt;
  Matrix7d covariance = said.information.ldlt().solve(Matrix7d::Identity());
  covariance.topLeftCorner<6, 6>() += correction;
  return Matrix7d(covariance.ldlt().solve(Matrix7d::Identity()));
}

/// Covariance in radii and radians; nothing where too few edges would be seen. Unknowns: the pose,
/// and the edge offsets in the first and in the new view, which err alike.
std::optional<Matrix6d> predicted(const SeenPart& seen, const Detection& known,
                                  const Camera& camera, const Eigen::Isometry3d& T_first_camera,
                                  const ViewsParams& params) {
  const double radius = seen.solid.radius;
  const Eigen::Isometry3d T_first_centre = known.T_camera_part * seen.T_part_centre;
  const Eigen::Isometry3d T_view_centre = T_first_camera.inverse() * T_first_centre;
  const Matrix6d by_correction = stepByCorrection(T_view_centre, radius);
  const auto look = informationOf(
      expectedRows(seen, known, camera, T_view_centre), radius,
      by_correction * correctionCovariance({T_first_camera}, params, camera.model().fx) *
          by_correction.transpose());
  if (!look) return std::nullopt;
  Eigen::Matrix<double, 8, 8> H = Eigen::Matrix<double, 8, 8>::Zero();
  H.bottomRightCorner<2, 2>() = offsetInformation(2, radius);
  const auto add = [&H](const Matrix7d& information, int offset) {
    Eigen::Matrix<double, 7, 8> map = Eigen::Matrix<double, 7, 8>::Zero();  // to a view's own step
    map.topLeftCorner<6, 6>().setIdentity();
    map(6, offset) = 1.0;
    H += map.transpose() * information * map;
  };
  add(*look, 7);
  const auto first = known.views > 1
                         ? std::nullopt
                         : informationOf(expectedRows(seen, known, camera, T_first_centre), radius,
                                         Matrix6d::Zero());
  if (first) {
    add(*first, 6);
  } else {  // by several views already, or by fewer edges than would be expected
    H.topLeftCorner<6, 6>() +=
        Units(radius).toRadii(known.covariance).ldlt().solve(Matrix6d::Identity());
  }
  const Eigen::Matrix<double, 8, 8> covariance =
      H.ldlt().solve(Eigen::Matrix<double, 8, 8>::Identity());
  return Matrix6d(faceCovariance(covariance, 2, seen.face) +
                  leastCovariance(radius, T_first_centre.translation().z(), camera.model().fx));
}

}  // namespace

void validate(const NextViewLimits& limits) {
  if (!((limits.box_max - limits.box_min).array() > 0.0).all())
    throw std::invalid_argument(
        "the box of the camera's places is empty: each maximum must be "
        "greater than its minimum");
  if (!(limits.cone_deg > 0.0 && limits.cone_deg < 90.0))
    throw std::invalid_argument("the cone is " + std::to_string(limits.cone_deg) +
                                " degrees; give more than 0 and less than 90");
  if (!(limits.focus.min > 0.0 && limits.focus.max > limits.focus.min))
    throw std::invalid_argument("the focus range is " + std::to_string(limits.focus.min) + " .. " +
                                std::to_string(limits.focus.max) +
                                " m; give two distances, the smaller one first");
}

std::optional<Matrix6d> predictedCovariance(const Detection& known, const PartModel& part,
                                            const Camera& camera,
                                            const Eigen::Isometry3d& T_first_camera,
                                            const LocatorParams& params) {
  const SeenPart seen(part, known.face, params.refine);
  const Eigen::Isometry3d T_view_centre =
      T_first_camera.inverse() * known.T_camera_part * seen.T_part_centre;
  if (!isInView(seen, camera, T_view_centre, std::nullopt)) return std::nullopt;
  const auto out = predicted(seen, known, camera, T_first_camera, params.views);
  if (!out) return std::nullopt;
  return Units(part.radius()).toMetres(*out);
}

std::optional<ViewProposal> nextView(const Detection& known, const PartModel& part,
                                     const Camera& camera, const Eigen::Isometry3d& T_base_first,
                                     const NextViewLimits& limits, const LocatorParams& params) {
  validate(limits);
  const SeenPart seen(part, known.face, params.refine);
  const Eigen::Isometry3d T_first_centre = known.T_camera_part * seen.T_part_centre;
  struct Judged {
    Place place;
    Matrix6d covariance;
    double worst;  // standard deviation of the direction that is known least, radii
  };
  std::vector<Judged> judged;
  for (const Place& place : placesFor(T_first_centre.translation(), limits)) {
    const Eigen::Vector3d x_base = T_base_first * place.T_first_camera.translation();
    if ((x_base.array() < limits.box_min.array()).any() ||
        (x_base.array() > limits.box_max.array()).any())
      continue;
    const Eigen::Isometry3d T_view_centre = place.T_first_camera.inverse() * T_first_centre;
    if (!isInView(seen, camera, T_view_centre, limits.focus)) continue;
    if (limits.bin && !isOverTheWalls(seen, T_base_first * place.T_first_camera,
                                      T_base_first * T_first_centre, *limits.bin))
      continue;
    const auto covariance = predicted(seen, known, camera, place.T_first_camera, params.views);
    if (!covariance) continue;
    const double worst = std::sqrt(std::max(
        0.0, Eigen::SelfAdjointEigenSolver<Matrix6d>(*covariance).eigenvalues().maxCoeff()));
    judged.push_back({place, *covariance, worst});
  }
  if (judged.empty()) return std::nullopt;
  const double best =
      std::min_element(judged.begin(), judged.end(), [](const Judged& a, const Judged& b) {
        return a.worst < b.worst;
      })->worst;
  const Judged* chosen = nullptr;
  for (const Judged& j : judged) {
    if (j.worst > kAsGood * best) continue;
    if (chosen == nullptr || j.place.travel < chosen->place.travel) chosen = &j;
  }
  return ViewProposal{chosen->place.T_first_camera,
                      Units(part.radius()).toMetres(chosen->covariance)};
}

}  // namespace planar_bin_picking
