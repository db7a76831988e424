// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/plan_markers.h"

#include "shared/convert.h"
#include "shared/marker_values.h"

#include <ros/time.h>

#include <algorithm>
#include <locale>
#include <sstream>

namespace planar_bin_picking_ros {

using planar_bin_picking::HandEyeResult;
using planar_bin_picking::Mounting;
using planar_bin_picking::PlannedPose;
using visualization_msgs::Marker;

namespace {

constexpr double kLong = 0.04;  // metres from a pyramid's tip to its base

/// The corners of a pyramid's base, its tip at zero and its height along z.
std::vector<Eigen::Vector3d> flangeCorners() {
  constexpr double kWide = 0.015;
  return {{-kWide, -kWide, kLong},
          {kWide, -kWide, kLong},
          {kWide, kWide, kLong},
          {-kWide, kWide, kLong}};
}

std::vector<Eigen::Vector3d> imageCorners(const planar_bin_picking::Camera::Model& c) {
  std::vector<Eigen::Vector3d> corners;
  for (const auto& [u, v] : {std::pair(0, 0), {c.width, 0}, {c.width, c.height}, {0, c.height}}) {
    corners.emplace_back(kLong * (u - c.cx) / c.fx, kLong * (v - c.cy) / c.fy, kLong);
  }
  return corners;
}

void setPyramid(const std::vector<Eigen::Vector3d>& corners, Marker* marker) {
  marker->points.clear();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto at = toPointMsg(corners[i]);
    marker->points.push_back(toPointMsg(Eigen::Vector3d::Zero()));
    marker->points.push_back(at);
    marker->points.push_back(at);
    marker->points.push_back(toPointMsg(corners[(i + 1) % corners.size()]));
  }
}

void setColour(float r, float g, float b, Marker* marker) {
  marker->color.r = r;
  marker->color.g = g;
  marker->color.b = b;
  marker->color.a = 1.0F;
}

void setColour(PlannedPose::State state, Marker* marker) {
  switch (state) {
    case PlannedPose::State::kPlanned:
      return setColour(0.0F, 0.0F, 1.0F, marker);
    case PlannedPose::State::kSeen:
      return setColour(0.0F, 1.0F, 0.0F, marker);
    case PlannedPose::State::kRefused:
      return setColour(1.0F, 0.0F, 0.0F, marker);
    case PlannedPose::State::kLost:
      return setColour(1.0F, 1.0F, 0.0F, marker);
  }
}

}  // namespace

visualization_msgs::MarkerArray makePlanMarkers(const std::string& base_frame, Mounting mounting,
                                                const std::vector<PlannedPose>& poses,
                                                const HandEyeResult* solution) {
  visualization_msgs::MarkerArray array;
  Marker marker;
  marker.header.frame_id = base_frame;
  marker.header.stamp = ros::Time::now();
  marker.ns = "plan";
  marker.action = Marker::DELETEALL;
  array.markers.push_back(marker);
  marker.action = Marker::ADD;
  marker.type = Marker::LINE_LIST;
  marker.scale.x = 0.002;
  const bool on_flange = solution != nullptr && mounting == Mounting::kEyeInHand;
  setPyramid(on_flange ? imageCorners(solution->camera) : flangeCorners(), &marker);
  for (const PlannedPose& pose : poses) {
    ++marker.id;
    marker.pose =
        toPoseMsg(on_flange ? pose.T_base_flange * solution->T_mount_camera : pose.T_base_flange);
    setColour(pose.state, &marker);
    array.markers.push_back(marker);
  }
  if (solution != nullptr && mounting == Mounting::kEyeToHand) {
    ++marker.id;
    marker.pose = toPoseMsg(solution->T_mount_camera);
    setPyramid(imageCorners(solution->camera), &marker);
    setColour(1.0F, 1.0F, 1.0F, &marker);
    array.markers.push_back(marker);
  }
  return array;
}

void addWay(const std::string& base_frame, const std::vector<Eigen::Isometry3d>& way,
            visualization_msgs::MarkerArray* array) {
  if (way.size() < 2) return;
  Marker marker;
  marker.header.frame_id = base_frame;
  marker.header.stamp = ros::Time::now();
  marker.ns = "next";
  marker.action = Marker::ADD;
  marker.type = Marker::LINE_STRIP;
  marker.scale.x = 0.003;
  marker.pose.orientation.w = 1.0;
  setColour(1.0F, 1.0F, 1.0F, &marker);
  for (const Eigen::Isometry3d& pose : way) marker.points.push_back(toPointMsg(pose.translation()));
  array->markers.push_back(marker);
  ++marker.id;
  marker.type = Marker::LINE_LIST;
  setPyramid(flangeCorners(), &marker);
  marker.pose = toPoseMsg(way.back());
  array->markers.push_back(marker);
}

std::string describeWay(const std::vector<Eigen::Isometry3d>& way) {
  if (way.size() < 2) return "";
  constexpr double kDegrees = 180.0 / 3.14159265358979323846;
  const Eigen::Isometry3d between = way.front().inverse() * way.back();
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  text << "to [" << way.back().translation().transpose() << "] m: " << between.translation().norm()
       << " m and " << kDegrees * planar_bin_picking::rotationAngle(between.linear()) << " deg in "
       << way.size() - 1 << (way.size() == 2 ? " move" : " moves");
  return text.str();
}

std::string summarize(const std::vector<PlannedPose>& poses) {
  const auto count = [&poses](PlannedPose::State state) {
    return std::to_string(std::count_if(
        poses.begin(), poses.end(), [state](const PlannedPose& p) { return p.state == state; }));
  };
  using State = PlannedPose::State;
  return std::to_string(poses.size()) + " poses: " + count(State::kSeen) + " seen, " +
         count(State::kRefused) + " refused, " + count(State::kLost) + " board lost, " +
         count(State::kPlanned) + " planned";
}

}  // namespace planar_bin_picking_ros
