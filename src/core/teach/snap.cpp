// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/teach/snap.h"

#include "base/polygon.h"

#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

/// Tools that lie flatter than this meet the face nowhere near.
constexpr double kFlat = 0.1;

double faceZ(Face face, double thickness) { return face == Face::kFront ? 0.0 : -thickness; }

Eigen::Vector3d inward(Face face) { return {0.0, 0.0, face == Face::kFront ? -1.0 : 1.0}; }

PickPose movedOver(PickPose pose, const Eigen::Vector2d& place) {
  pose.T_part_pick.translation().head<2>() = place;
  return pose;
}

Eigen::Vector2d centroidOf(const Loop& loop) {
  return signedMoment(loop.points) / signedArea(loop.points);
}

}  // namespace

Face faceFor(const PickPose& pose) {
  return pose.face == FaceFilter::kBack ? Face::kBack : Face::kFront;
}

PickPose snappedToNormal(PickPose pose, double thickness) {
  const Face face = faceFor(pose);
  Eigen::Vector3d p = pose.T_part_pick.translation();
  const Eigen::Vector3d z = pose.T_part_pick.linear().col(2);
  const double off = faceZ(face, thickness) - p.z();
  p += std::abs(z.z()) > kFlat ? Eigen::Vector3d(off / z.z() * z) : Eigen::Vector3d(0.0, 0.0, off);
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(z, inward(face));
  const Eigen::Quaterniond rotation(turn * Eigen::Quaterniond(pose.T_part_pick.linear()));
  pose.T_part_pick.linear() = rotation.normalized().toRotationMatrix();
  pose.T_part_pick.translation() = p;
  return pose;
}

PickPose snappedToCentroid(PickPose pose, const Drawing& drawing) {
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  double area = 0.0;
  for (const Loop& loop : drawing.loops) {  // holes run the other way, and are subtracted so
    if (loop.kind == LoopKind::kPrint) continue;
    moment += signedMoment(loop.points);
    area += signedArea(loop.points);
  }
  return movedOver(std::move(pose), moment / area);
}

std::optional<PickPose> snappedToHole(PickPose pose, const Drawing& drawing) {
  const Eigen::Vector2d from = pose.T_part_pick.translation().head<2>();
  double nearest = std::numeric_limits<double>::infinity();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Loop& loop : drawing.loops) {
    if (loop.kind != LoopKind::kHole) continue;
    const Eigen::Vector2d candidate = centroidOf(loop);
    const double distance = (candidate - from).norm();
    if (distance < nearest) nearest = distance, middle = candidate;
  }
  if (std::isinf(nearest)) return std::nullopt;
  return movedOver(std::move(pose), middle);
}

PickPose turned(PickPose pose, double angle) {
  pose.T_part_pick.rotate(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  return pose;
}

PickPose forOtherFace(PickPose pose, double thickness) {
  const Face face = faceFor(pose);
  const Face other = face == Face::kFront ? Face::kBack : Face::kFront;
  Eigen::Vector3d p = pose.T_part_pick.translation();
  // Depths below the two faces run against one another.
  p.z() = faceZ(other, thickness) - (p.z() - faceZ(face, thickness));
  pose.T_part_pick.translation() = p;
  pose.T_part_pick.rotate(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
  pose.face = other == Face::kFront ? FaceFilter::kFront : FaceFilter::kBack;
  return pose;
}

}  // namespace planar_bin_picking
