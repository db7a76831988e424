// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/display.h"

#include "shared/convert.h"

#include <algorithm>
#include <cassert>
#include <cstdio>

namespace planar_bin_picking_ros {

using planar_bin_picking::Face;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::Loop;
using planar_bin_picking::PartModel;
using visualization_msgs::Marker;

namespace {

geometry_msgs::Point point(const Eigen::Vector2d& position, const double z) {
  geometry_msgs::Point message;
  message.x = position.x();
  message.y = position.y();
  message.z = z;
  return message;
}

/// The first in rank is green, the last one blue.
std_msgs::ColorRGBA color(const std::size_t rank, const std::size_t count) {
  const float share = count > 1 ? static_cast<float>(rank) / (count - 1) : 0.0f;
  std_msgs::ColorRGBA rgba;
  rgba.r = 0.1f;
  rgba.g = 1.0f - 0.7f * share;
  rgba.b = 0.2f + 0.8f * share;
  rgba.a = 1.0f;
  return rgba;
}

Marker makeMarker(const std_msgs::Header& header, const char* ns, const std::size_t rank) {
  Marker marker;
  // Stamp zero: rviz shows it at any later time, too, when tf no longer reaches back to the image.
  marker.header.frame_id = header.frame_id;
  marker.ns = ns;
  marker.id = static_cast<int>(rank);
  marker.action = Marker::ADD;
  return marker;
}

double visibleZ(const LocatedPart& located, const PartModel& part) {
  return part.faceZ(located.face == LocatedPart::FRONT ? Face::kFront : Face::kBack);
}

Marker makeOutline(Marker marker, const LocatedPart& located, const PartModel& part) {
  constexpr double kLineWidth = 0.001;
  marker.type = Marker::LINE_LIST;
  marker.pose = located.pose.pose;
  marker.scale.x = kLineWidth;
  const double z = visibleZ(located, part);
  for (const Loop& loop : part.file().drawing.loops) {
    const std::size_t count = loop.points.size();
    for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < count; ++i) {
      marker.points.push_back(point(loop.points[i], z));
      marker.points.push_back(point(loop.points[(i + 1) % count], z));
    }
  }
  return marker;
}

Marker makeText(Marker marker, const LocatedPart& located, const PartModel& part) {
  constexpr double kHeightPerRadius = 0.25;
  marker.type = Marker::TEXT_VIEW_FACING;
  const Eigen::Vector3d center(part.center().x(), part.center().y(), visibleZ(located, part));
  marker.pose = toPoseMsg(fromMsg(located.pose.pose) * Eigen::Translation3d(center));
  marker.scale.z = kHeightPerRadius * part.radius();
  char score[16];
  std::snprintf(score, sizeof score, " %.2f", located.score);
  marker.text = located.child_frame + score;
  return marker;
}

}  // namespace

visualization_msgs::MarkerArray makeMarkers(const std_msgs::Header& header,
                                            const std::vector<LocatedPart>& located,
                                            const std::vector<planar_bin_picking::PartPtr>& parts) {
  visualization_msgs::MarkerArray array;
  array.markers.emplace_back();
  array.markers.back().header.frame_id = header.frame_id;
  array.markers.back().action = Marker::DELETEALL;
  for (std::size_t rank = 0; rank < located.size(); ++rank) {
    const auto part = std::find_if(parts.begin(), parts.end(), [&](const auto& candidate) {
      return candidate->name() == located[rank].part;
    });
    assert(part != parts.end());
    Marker outline = makeOutline(makeMarker(header, "outline", rank), located[rank], **part);
    Marker text = makeText(makeMarker(header, "name", rank), located[rank], **part);
    outline.color = text.color = color(rank, located.size());
    array.markers.push_back(std::move(outline));
    array.markers.push_back(std::move(text));
  }
  return array;
}

}  // namespace planar_bin_picking_ros
