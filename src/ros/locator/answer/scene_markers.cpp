// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/scene_markers.h"

#include "shared/convert.h"
#include "shared/marker_values.h"

#include <cstddef>

namespace planar_bin_picking_ros {

using planar_bin_picking::RegionOutline;
using visualization_msgs::Marker;

namespace {

constexpr double kLine = 0.002, kPoint = 0.012, kSheet = 0.001;  // metres

Marker make(const std::string& frame, const char* ns, const int type,
            const std_msgs::ColorRGBA& color) {
  Marker marker;
  marker.header.frame_id = frame;
  marker.ns = ns;
  marker.type = type;
  marker.action = Marker::ADD;
  marker.pose.orientation.w = 1.0;
  marker.scale.x = marker.scale.y = marker.scale.z = kLine;
  marker.color = color;
  return marker;
}

/// A thin box that is clicked on.
Marker sheet(Marker marker, const Eigen::Vector3d& center, const Eigen::Vector2d& size) {
  marker.pose.position = toPointMsg(center);
  marker.scale.x = size.x();
  marker.scale.y = size.y();
  marker.scale.z = kSheet;
  return marker;
}

void addRing(const std::vector<Eigen::Vector3d>& corners, Marker* marker) {
  for (std::size_t i = 0; i < corners.size(); ++i) {
    marker->points.push_back(toPointMsg(corners[i]));
    marker->points.push_back(toPointMsg(corners[(i + 1) % corners.size()]));
  }
}

std::vector<Eigen::Vector3d> atHeight(const RegionOutline& outline, const double z) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& p : outline) points.emplace_back(p.x(), p.y(), z);
  return points;
}

}  // namespace

Markers binMarkers(const std::string& frame, const Eigen::Isometry3d& T_frame_bin,
                   const Eigen::Vector3d& min, const Eigen::Vector3d& max) {
  Marker edges = make(frame, "bin", Marker::LINE_LIST, colorOf(0.9f, 0.8f, 0.3f));
  std::vector<Eigen::Vector3d> low, high;
  for (const auto& [x, y] :
       {std::pair{min.x(), min.y()}, {max.x(), min.y()}, {max.x(), max.y()}, {min.x(), max.y()}}) {
    low.emplace_back(x, y, min.z());
    high.emplace_back(x, y, max.z());
  }
  addRing(low, &edges);
  addRing(high, &edges);
  for (std::size_t i = 0; i < low.size(); ++i) {
    edges.points.push_back(toPointMsg(low[i]));
    edges.points.push_back(toPointMsg(high[i]));
  }
  const Eigen::Vector3d middle = 0.5 * (min + max), size = max - min;
  edges.pose = toPoseMsg(T_frame_bin);
  Marker floor = sheet(make(frame, "bin_floor", Marker::CUBE, colorOf(0.45f, 0.42f, 0.3f)),
                       Eigen::Vector3d::Zero(), size.head<2>());
  floor.pose =
      toPoseMsg(T_frame_bin * Eigen::Translation3d(middle.x(), middle.y(), min.z() - 0.5 * kSheet));
  return {edges, floor};
}

Markers regionMarkers(const std::string& frame, const Eigen::Isometry3d& T_frame_region,
                      const RegionOutline& region, const RegionOutline& points, const bool good) {
  constexpr double kAbove = 0.002;  // metres; not hidden by what it lies on
  Markers markers;
  if (!region.empty()) {
    markers.push_back(make(frame, "region", Marker::LINE_LIST, colorOf(0.3f, 0.9f, 1.0f)));
    addRing(atHeight(region, kAbove), &markers.back());
  }
  const auto placed = [&](Markers all) {
    for (Marker& marker : all) marker.pose = toPoseMsg(T_frame_region);
    return all;
  };
  if (points.empty()) return placed(markers);
  const auto color = good ? colorOf(1.0f, 1.0f, 0.2f) : colorOf(1.0f, 0.2f, 0.2f);
  Marker corners = make(frame, "region_points", Marker::SPHERE_LIST, color);
  corners.scale.x = corners.scale.y = corners.scale.z = kPoint;
  Marker lines = make(frame, "region_taught", Marker::LINE_LIST, color);
  for (const Eigen::Vector3d& p : atHeight(points, kAbove)) corners.points.push_back(toPointMsg(p));
  addRing(atHeight(points, kAbove), &lines);
  markers.push_back(corners);
  markers.push_back(lines);
  return placed(markers);
}

Markers cameraMarkers(const ShownCamera& shown) {
  constexpr double kBody = 0.03, kText = 0.015;  // metres
  const auto& model = shown.camera.model();
  const auto seen = [&](const Eigen::Vector2d& pixel) {
    const Eigen::Vector2d ideal = shown.camera.undistort(pixel);
    return Eigen::Vector3d(shown.distance * Eigen::Vector3d(ideal.x(), ideal.y(), 1.0));
  };
  std::vector<Eigen::Vector3d> corners;
  const double right = model.width - 1.0, below = model.height - 1.0;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {right, 0.0}, {right, below}, {0.0, below}})
    corners.push_back(seen({u, v}));
  Marker frustum = make(shown.frame, shown.ns, Marker::LINE_LIST, colorOf(0.7f, 0.7f, 0.9f, 0.6f));
  frustum.scale.x = 0.5 * kLine;
  frustum.pose = toPoseMsg(shown.T_frame_camera);
  addRing(corners, &frustum);
  for (const Eigen::Vector3d& corner : corners) {
    frustum.points.push_back(toPointMsg(Eigen::Vector3d::Zero()));
    frustum.points.push_back(toPointMsg(corner));
  }
  Marker body = make(shown.frame, shown.ns, Marker::CUBE, colorOf(0.2f, 0.2f, 0.3f));
  body.id = 1;
  body.pose = toPoseMsg(shown.T_frame_camera * Eigen::Translation3d(0.0, 0.0, -0.5 * kBody));
  body.scale.x = body.scale.y = body.scale.z = kBody;
  Markers markers{frustum, body};
  if (!shown.region.empty()) {
    Marker region = make(shown.frame, "region_px", Marker::LINE_LIST, colorOf(0.3f, 0.9f, 1.0f));
    region.pose = frustum.pose;
    std::vector<Eigen::Vector3d> ring;
    for (const Eigen::Vector2d& pixel : shown.region) ring.push_back(seen(pixel));
    addRing(ring, &region);
    markers.push_back(region);
  }
  if (!shown.text.empty()) {
    Marker text = make(shown.frame, shown.ns, Marker::TEXT_VIEW_FACING, colorOf(1, 1, 1));
    text.id = 2;
    text.pose = frustum.pose;
    text.scale.z = kText;
    text.text = shown.text;
    markers.push_back(text);
  }
  return markers;
}

Markers planeMarkers(const std::string& frame) {
  constexpr double kSide = 1.0;  // metres
  return {sheet(make(frame, "plane", Marker::CUBE, colorOf(0.3f, 0.5f, 0.4f, 0.4f)),
                {0.0, 0.0, -0.5 * kSheet}, {kSide, kSide})};
}

}  // namespace planar_bin_picking_ros
