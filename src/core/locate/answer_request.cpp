// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/answer_request.h"

#include "part/outline_view.h"
#include "part/part_extent.h"
#include "part/visible_face.h"
#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <cmath>
#include <locale>
#include <optional>
#include <sstream>
#include <string>

namespace planar_bin_picking {
namespace {

constexpr double kDegrees = EIGEN_PI / 180.0;
/// A pose may be beyond the tilt limit by so many of its standard deviations, since noise should
/// not decide, but by no more than so many degrees.
constexpr double kSigmas = 3.0, kTiltMostDeg = 2.0;
constexpr double kSineLeast = 1e-6;  // of a tilt, against a division by zero

/// xi in T * exp(xi) for the frame that T_here_there leads to.
Matrix6d moved(const Matrix6d& covariance, const Eigen::Isometry3d& T_here_there) {
  const Eigen::Matrix3d R = T_here_there.linear().transpose();
  Matrix6d to_there = Matrix6d::Zero();
  to_there.topLeftCorner<3, 3>() = to_there.bottomRightCorner<3, 3>() = R;
  to_there.topRightCorner<3, 3>() = -R * skew<double>(T_here_there.translation());
  return to_there * covariance * to_there.transpose();
}

/// Turn by half a circle about the mirror axis, halfway through the part.
Eigen::Isometry3d turnOver(const PartModel& part) {
  const Symmetry& symmetry = part.symmetry();
  const Eigen::Vector3d axis(std::cos(symmetry.mirror_axis), std::sin(symmetry.mirror_axis), 0.0);
  const Eigen::Translation3d middle(symmetry.center.x(), symmetry.center.y(),
                                    -0.5 * part.thickness());
  return Eigen::Isometry3d(middle * Eigen::AngleAxisd(EIGEN_PI, axis) * middle.inverse());
}

bool hasEqualFaces(const PartModel& part) { return part.symmetry().mirror && !part.hasPrint(); }

bool isWanted(Face face, FaceFilter wanted) {
  return wanted == FaceFilter::kAny || (wanted == FaceFilter::kFront) == (face == Face::kFront);
}

bool isBeyondTilt(const Detection& d, double limit_deg) {
  const Eigen::Vector3d z_part = d.T_camera_part.linear().row(2);  // the optical axis
  const double side = std::max(kSineLeast, std::hypot(z_part.x(), z_part.y()));
  const Eigen::Vector2d about(-z_part.y() / side, z_part.x() / side);
  const double variance = about.dot(d.covariance.block<2, 2>(3, 3) * about);
  const double margin =
      std::min(kSigmas * std::sqrt(std::max(0.0, variance)), kTiltMostDeg * kDegrees);
  return tiltOf(d.T_camera_part, d.face) > limit_deg * kDegrees + margin;
}

/// For each part, the distance beyond which it has too few pixels.
std::vector<double> farthestOf(const LocateRequest& request, const Camera& camera) {
  const double focal_px = std::min(camera.model().fx, camera.model().fy);
  std::vector<double> farthest;
  for (const auto& part : request.parts)
    farthest.push_back(farthestSeen(extentOf(*part), focal_px));
  return farthest;
}

/// Why the pose lies outside of the distances, if it does.
std::optional<std::string> outside(const Detection& d, const PartModel& part, double farthest,
                                   const LocateRequest& request) {
  const Eigen::Isometry3d T_camera_centre = d.T_camera_part * centreOf(part, d.face);
  const double depth = T_camera_centre.translation().z();
  const double margin = distanceMargin(d, depth);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  if (depth < request.distance_min - margin || depth > request.distance_max + margin) {
    text << "it lies at " << depth << " m, outside of " << request.distance_min << " .. "
         << request.distance_max << " m (give or take " << 1e3 * margin << " mm)";
    return text.str();
  }
  if (depth > farthest) {
    text << "it lies at " << depth << " m, and beyond " << farthest
         << " m it has too few pixels to be told from chance";
    return text.str();
  }
  return std::nullopt;
}

}  // namespace

Detection turnedOver(const Detection& detection, const PartModel& part) {
  const Eigen::Isometry3d T_part_turned = turnOver(part);
  Detection out = detection;
  out.face = detection.face == Face::kFront ? Face::kBack : Face::kFront;
  out.T_camera_part = detection.T_camera_part * T_part_turned;
  out.covariance = moved(detection.covariance, centreOf(part, detection.face).inverse() *
                                                   T_part_turned * centreOf(part, out.face));
  // A cell is covered where the one that was in its place is.
  const FaceGrid& grid = part.faceGrid();
  out.covered.clear();
  for (std::size_t i = 0; i < grid.cells().size(); ++i) {
    const Eigen::Vector3d p(grid.cells()[i].x(), grid.cells()[i].y(), 0.0);
    const Eigen::Vector2d before = (T_part_turned * p).head<2>();
    const auto& covered = detection.covered;
    if (std::find(covered.begin(), covered.end(), grid.cellNear(before)) != covered.end()) {
      out.covered.push_back(static_cast<int>(i));
    }
  }
  return out;
}

void answerRequest(const std::vector<Detection>& ranked, const LocateRequest& request,
                   const Camera& camera, double tilt_limit_deg, LocateResult* out) {
  const std::vector<double> farthest = farthestOf(request, camera);
  for (Detection d : ranked) {
    const PartModel& part = *request.parts[d.part];
    if (isBeyondTilt(d, tilt_limit_deg)) continue;
    if (!isWanted(d.face, request.face)) {
      if (!hasEqualFaces(part)) {
        const std::string up = d.face == Face::kFront ? "front" : "back";
        out->withheld.push_back({d, Withheld::kWrongFace, "its " + up + " is up"});
        continue;
      }
      d = turnedOver(d, part);
    }
    if (const auto why = outside(d, part, farthest[d.part], request)) {
      out->withheld.push_back({d, Withheld::kOutside, *why});
    } else if (request.max_parts == 0 || out->detections.size() < request.max_parts) {
      out->detections.push_back(d);
    }
  }
}

}  // namespace planar_bin_picking
