// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/display.h"

#include "planar_bin_picking/show/solid.h"
#include "shared/convert.h"
#include "shared/marker_values.h"

#include <algorithm>
#include <cassert>
#include <cstdio>
#include <map>
#include <string>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::Face;
using planar_bin_picking::LocatedPart;
using planar_bin_picking::Loop;
using planar_bin_picking::PartModel;
using visualization_msgs::Marker;

namespace {

using Corners = std::vector<geometry_msgs::Point>;

/// The first in rank is green, the last one blue.
std_msgs::ColorRGBA color(const std::size_t rank, const std::size_t count) {
  const float share = count > 1 ? static_cast<float>(rank) / (count - 1) : 0.0f;
  return colorOf(0.1f, 1.0f - 0.7f * share, 0.2f + 0.8f * share);
}

/// z of the visible face, or of what lies so far above it.
double visibleZ(const LocatedPart& located, const PartModel& part, const double above) {
  const bool front = located.face == LocatedPart::FRONT;
  return part.faceZ(front ? Face::kFront : Face::kBack) + (front ? above : -above);
}

Marker makeOutline(Marker marker, const LocatedPart& located, const PartModel& part) {
  constexpr double kLineWidth = 0.001;
  marker.type = Marker::LINE_LIST;
  marker.pose = located.pose.pose;
  marker.scale.x = kLineWidth;
  constexpr double kAbove = 0.0005;  // metres: half of a line would be hidden in the body
  const double z = visibleZ(located, part, kAbove);
  for (const Loop& loop : part.file().drawing.loops) {
    const std::size_t count = loop.points.size();
    for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < count; ++i) {
      for (const std::size_t k : {i, (i + 1) % count})
        marker.points.push_back(toPointMsg({loop.points[k].x(), loop.points[k].y(), z}));
    }
  }
  return marker;
}

Marker makeText(Marker marker, const LocatedPart& located, const PartModel& part,
                const std::string& text) {
  constexpr double kHeightPerRadius = 0.25;
  marker.type = Marker::TEXT_VIEW_FACING;
  const double height = kHeightPerRadius * part.radius();
  // So far above the face that the body does not hide it.
  const Eigen::Vector3d center(part.center().x(), part.center().y(),
                               visibleZ(located, part, height));
  marker.pose = toPoseMsg(fromMsg(located.pose.pose) * Eigen::Translation3d(center));
  marker.scale.z = height;
  marker.text = text;
  return marker;
}

Marker makeSolid(Marker marker, const LocatedPart& located, const Corners& corners) {
  marker.type = Marker::TRIANGLE_LIST;
  marker.pose = located.pose.pose;
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  marker.points = corners;
  return marker;
}

/// From where the tool comes, with its point at the contact.
Marker makePick(Marker marker, const Eigen::Isometry3d& T_header_pick) {
  constexpr double kLength = 0.04, kShaft = 0.003, kHead = 0.008, kHeadLength = 0.012;  // metres
  marker.type = Marker::ARROW;
  marker.pose = toPoseMsg(T_header_pick);
  marker.points = {toPointMsg({0.0, 0.0, -kLength}), toPointMsg({0.0, 0.0, 0.0})};
  marker.scale.x = kShaft;
  marker.scale.y = kHead;
  marker.scale.z = kHeadLength;
  return marker;
}

Marker makeTool(Marker marker, const Eigen::Isometry3d& T_header_pick, const double radius) {
  constexpr double kHeight = 0.01;  // metres; of the cup, say
  marker.type = Marker::CYLINDER;
  marker.pose = toPoseMsg(T_header_pick * Eigen::Translation3d(0.0, 0.0, -0.5 * kHeight));
  marker.scale.x = marker.scale.y = 2.0 * radius;
  marker.scale.z = kHeight;
  return marker;
}

/// Fingers, cups: what pick/tool_boxes and tool_cylinders say of the tool, at a pick pose.
Marker makeBodies(Marker marker, const Eigen::Isometry3d& T_header_pick,
                  const std::vector<planar_bin_picking::ToolBody>& bodies) {
  marker.type = Marker::TRIANGLE_LIST;
  marker.pose = toPoseMsg(T_header_pick);
  marker.scale.x = marker.scale.y = marker.scale.z = 1.0;
  const auto add = [&](const Eigen::Vector2d& p, const double z) {
    marker.points.push_back(toPointMsg({p.x(), p.y(), z}));
  };
  for (const auto& body : bodies) {
    const auto& ring = body.footprint;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d &a = ring[i], &b = ring[(i + 1) % ring.size()];
      add(a, body.low), add(b, body.low), add(b, body.high);
      add(a, body.low), add(b, body.high), add(a, body.high);
      if (i == 0 || i + 1 == ring.size()) continue;
      add(ring[0], body.high), add(a, body.high), add(b, body.high);
      add(ring[0], body.low), add(b, body.low), add(a, body.low);
    }
  }
  return marker;
}

/// Adds one marker after the other, numbered within each namespace.
class Shown {
 public:
  explicit Shown(const Display& display) : display_(display) {
    array_.markers.emplace_back();
    array_.markers.back().header.frame_id = display.header.frame_id;
    array_.markers.back().action = Marker::DELETEALL;
  }

  void offered(const std::size_t rank) {
    const LocatedPart& located = display_.located[rank];
    const PartModel& part = partOf(located);
    const auto rgba = color(rank, display_.located.size());
    char text[40];
    std::snprintf(text, sizeof text, " %.2f", located.score);
    add(makeSolid(marker("solid"), located, cornersOf(part)), rgba);
    add(makeOutline(marker("outline"), located, part), kEdge);
    add(makeText(marker("name"), located, part,
                 std::to_string(rank + 1) + ": " + located.child_frame + text),
        kWord);
    const double radius = part.file().tool.radius.value_or(display_.tool_radius);
    for (const auto& pick : located.picks) add(makePick(marker("pick"), fromMsg(pick.pose)), kPick);
    if (located.picks.empty()) return;
    const Eigen::Isometry3d T_header_pick = fromMsg(located.picks.front().pose);
    if (radius > 0.0) add(makeTool(marker("tool"), T_header_pick, radius), kTool);
    if (!display_.tool_bodies.empty())
      add(makeBodies(marker("tool_bodies"), T_header_pick, display_.tool_bodies), kTool);
  }

  void refused(const planar_bin_picking::RefusedPart& refused) {
    const LocatedPart& located = refused.located;
    const PartModel& part = partOf(located);
    add(makeSolid(marker("refused"), located, cornersOf(part)), kGrey);
    add(makeOutline(marker("refused_outline"), located, part), kGreyEdge);
    add(makeText(marker("reason"), located, part, nameOfReason(refused.reason)), kGreyWord);
  }

  visualization_msgs::MarkerArray&& take() { return std::move(array_); }

 private:
  static constexpr float kEdge[4] = {0.05f, 0.05f, 0.05f, 1.0f},
                         kWord[4] = {1.0f, 1.0f, 1.0f, 1.0f};
  static constexpr float kPick[4] = {1.0f, 0.2f, 1.0f, 1.0f}, kTool[4] = {1.0f, 0.2f, 1.0f, 0.4f};
  static constexpr float kGrey[4] = {0.5f, 0.5f, 0.5f, 0.6f};
  static constexpr float kGreyEdge[4] = {0.25f, 0.25f, 0.25f, 1.0f};
  static constexpr float kGreyWord[4] = {0.75f, 0.75f, 0.75f, 1.0f};

  Marker marker(const char* ns) {
    Marker marker;
    // Stamp zero: rviz shows it at any later time, too, when tf no longer reaches back to the
    // image.
    marker.header.frame_id = display_.header.frame_id;
    marker.ns = ns;
    marker.id = count_[ns]++;
    marker.action = Marker::ADD;
    return marker;
  }

  void add(Marker marker, const std_msgs::ColorRGBA& rgba) {
    marker.color = rgba;
    array_.markers.push_back(std::move(marker));
  }
  void add(Marker marker, const float (&rgba)[4]) {
    std_msgs::ColorRGBA color;
    color.r = rgba[0];
    color.g = rgba[1];
    color.b = rgba[2];
    color.a = rgba[3];
    add(std::move(marker), color);
  }

  const PartModel& partOf(const LocatedPart& located) const {
    const auto part =
        std::find_if(display_.parts.begin(), display_.parts.end(),
                     [&](const auto& candidate) { return candidate->name() == located.part; });
    assert(part != display_.parts.end());
    return **part;
  }

  const Corners& cornersOf(const PartModel& part) {
    Corners& corners = corners_[part.name()];
    if (corners.empty()) {
      for (const Eigen::Vector3d& p : planar_bin_picking::solidTriangles(part))
        corners.push_back(toPointMsg(p));
    }
    return corners;
  }

  const Display& display_;
  visualization_msgs::MarkerArray array_;
  std::map<std::string, int> count_;
  std::map<std::string, Corners> corners_;  ///< by part
};

}  // namespace

visualization_msgs::MarkerArray makeMarkers(const Display& display) {
  Shown shown(display);
  for (std::size_t rank = 0; rank < display.located.size(); ++rank) shown.offered(rank);
  for (const auto& refused : display.refused) shown.refused(refused);
  return shown.take();
}

}  // namespace planar_bin_picking_ros
