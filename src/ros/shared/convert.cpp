// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "shared/convert.h"

#include "planar_bin_picking/base/se3.h"

#include <iterator>

namespace planar_bin_picking_ros {

using planar_bin_picking::Detection;
using planar_bin_picking::Face;
using planar_bin_picking::FaceFilter;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::Matrix6d;
using planar_bin_picking::PartModel;
using planar_bin_picking::PickPose;

namespace {

template <class Vector>
Eigen::Isometry3d isometry(const Vector& t, const geometry_msgs::Quaternion& q) {
  // Normalized: robots publish quaternions rounded to a few digits.
  return Eigen::Translation3d(t.x, t.y, t.z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

bool fits(const PickPose& pick, const Face face) {
  return pick.face == FaceFilter::kAny ||
         (pick.face == FaceFilter::kFront) == (face == Face::kFront);
}

}  // namespace

Eigen::Isometry3d fromMsg(const geometry_msgs::Transform& transform) {
  return isometry(transform.translation, transform.rotation);
}

Eigen::Isometry3d fromMsg(const geometry_msgs::Pose& pose) {
  return isometry(pose.position, pose.orientation);
}

geometry_msgs::Pose toPoseMsg(const Eigen::Isometry3d& T_header_child) {
  const geometry_msgs::Transform transform = toTransformMsg(T_header_child);
  geometry_msgs::Pose pose;
  pose.position.x = transform.translation.x;
  pose.position.y = transform.translation.y;
  pose.position.z = transform.translation.z;
  pose.orientation = transform.rotation;
  return pose;
}

geometry_msgs::Transform toTransformMsg(const Eigen::Isometry3d& T_header_child) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(T_header_child.linear()).normalized();
  geometry_msgs::Transform transform;
  transform.translation.x = T_header_child.translation().x();
  transform.translation.y = T_header_child.translation().y();
  transform.translation.z = T_header_child.translation().z();
  transform.rotation.x = q.x();
  transform.rotation.y = q.y();
  transform.rotation.z = q.z();
  transform.rotation.w = q.w();
  return transform;
}

Matrix6d fixedAxesCovariance(const Matrix6d& covariance, const Eigen::Matrix3d& R_header_part,
                             const Eigen::Vector3d& center) {
  // T' = T exp(t, w): the rotation turns by R w about the header's axes; the part's origin, which
  // lies at -center in the frame of the centre, moves by R (t + w x (-center)).
  Matrix6d jacobian = Matrix6d::Zero();
  jacobian.topLeftCorner<3, 3>() = R_header_part;
  jacobian.topRightCorner<3, 3>() = R_header_part * planar_bin_picking::skew<double>(center);
  jacobian.bottomRightCorner<3, 3>() = R_header_part;
  return jacobian * covariance * jacobian.transpose();
}

LocatedPart toMsg(const Detection& detection, const PartModel& part,
                  const Eigen::Isometry3d& T_header_camera) {
  const Eigen::Isometry3d T_header_part = T_header_camera * detection.T_camera_part;
  const Eigen::Vector3d center(part.center().x(), part.center().y(), part.faceZ(detection.face));
  const Matrix6d covariance =
      fixedAxesCovariance(detection.covariance, T_header_part.linear(), center);

  LocatedPart message;
  message.part = part.name();
  message.face = detection.face == Face::kFront ? LocatedPart::FRONT : LocatedPart::BACK;
  message.pose.pose = toPoseMsg(T_header_part);
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(message.pose.covariance.data()) =
      covariance;
  message.score = detection.score;
  message.visible_fraction = detection.visible_fraction;
  message.views = static_cast<std::uint32_t>(detection.views);
  for (const auto& pick : part.pickPoses()) {
    if (!fits(pick, detection.face)) continue;
    message.picks.emplace_back();
    message.picks.back().name = pick.name;
    message.picks.back().pose = toPoseMsg(T_header_part * pick.T_part_pick);
    message.picks.back().approach = message.picks.back().retreat = message.picks.back().pose;
  }
  message.part_number = static_cast<std::uint32_t>(part.file().robot.part_number);
  message.tool_number = static_cast<std::uint32_t>(part.file().robot.tool_number);
  return message;
}

const char* nameOfReason(const std::uint8_t reason) {
  constexpr const char* kNames[] = {"LOW_SCORE",        "OCCLUDED",   "TILT",         "WALL",
                                    "FAILED_BEFORE",    "OUTSIDE",    "NO_PICK_POSE", "WRONG_FACE",
                                    "BEYOND_MAX_PARTS", "NEEDS_VIEW", "CONTRADICTED", "NO_ROOM"};
  return reason < std::size(kNames) ? kNames[reason] : "?";
}

}  // namespace planar_bin_picking_ros
