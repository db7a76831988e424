// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "plan_markers.h"

#include "convert.h"

#include <ros/time.h>

namespace planar_bin_picking_ros {

using planar_bin_picking::PlannedPose;

visualization_msgs::MarkerArray makePlanMarkers(const std::string& base_frame,
                                                const std::vector<PlannedPose>& poses) {
  visualization_msgs::MarkerArray array;
  visualization_msgs::Marker marker;
  marker.header.frame_id = base_frame;
  marker.header.stamp = ros::Time::now();
  marker.ns = "plan";
  marker.action = visualization_msgs::Marker::DELETEALL;
  array.markers.push_back(marker);
  marker.action = visualization_msgs::Marker::ADD;
  marker.type = visualization_msgs::Marker::LINE_LIST;
  marker.scale.x = 0.002;
  marker.color.a = 1.0F;
  for (const PlannedPose& pose : poses) {
    ++marker.id;
    marker.pose = toPoseMsg(pose.T_base_flange);
    marker.color.r = pose.state == PlannedPose::State::kRefused ? 1.0F : 0.0F;
    marker.color.g = pose.state == PlannedPose::State::kSeen ? 1.0F : 0.0F;
    marker.color.b = pose.state == PlannedPose::State::kPlanned ? 1.0F : 0.0F;
    marker.points.clear();
    // A pyramid that opens along the flange's z axis.
    constexpr double kWide = 0.015, kLong = 0.04;
    const double corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    const auto point = [](double x, double y, double z) {
      geometry_msgs::Point p;
      p.x = x;
      p.y = y;
      p.z = z;
      return p;
    };
    for (int i = 0; i < 4; ++i) {
      const auto& a = corners[i];
      const auto& b = corners[(i + 1) % 4];
      const auto at = point(kWide * a[0], kWide * a[1], kLong);
      marker.points.push_back(point(0.0, 0.0, 0.0));
      marker.points.push_back(at);
      marker.points.push_back(at);
      marker.points.push_back(point(kWide * b[0], kWide * b[1], kLong));
    }
    array.markers.push_back(marker);
  }
  return array;
}

}  // namespace planar_bin_picking_ros
