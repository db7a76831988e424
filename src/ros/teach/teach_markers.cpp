// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "teach/teach_markers.h"

#include "planar_bin_picking/show/solid.h"
#include "planar_bin_picking/teach/snap.h"
#include "shared/convert.h"
#include "shared/marker_values.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <sstream>
#include <vector>

namespace planar_bin_picking_ros {

using planar_bin_picking::Face;
using planar_bin_picking::Loop;
using planar_bin_picking::LoopKind;
using planar_bin_picking::PartModel;
using planar_bin_picking::PickPose;
using planar_bin_picking::TaughtPart;
using visualization_msgs::InteractiveMarker;
using visualization_msgs::InteractiveMarkerControl;
using visualization_msgs::Marker;

namespace {

constexpr double kToolRadius = 0.005;  // metres; drawn where the file says nothing of the tool
constexpr double kLine = 0.0005;       // width of a contour
constexpr double kOverFace = 1e-4;     // so that a contour is not drawn within the face
// In radii of the part.
constexpr double kText = 0.06, kAxis = 0.25, kHandle = 0.3;
constexpr double kFaultText = 0.045;
/// Of a text's height: rviz puts its middle where it is told, and its lines as far apart as this
/// twice.
constexpr double kHalfLine = 1.6;
constexpr std::size_t kTextWidth = 70, kFaultWidth = 80;  // letters

/// What is about x is then about the axis.
geometry_msgs::Quaternion xToward(const Eigen::Vector3d& axis) {
  const auto turn = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitX(), axis);
  return toPoseMsg(Eigen::Isometry3d(turn)).orientation;
}

const std_msgs::ColorRGBA kRed = colorOf(1.0f, 0.1f, 0.1f);

Marker makeMarker(const int type, const std_msgs::ColorRGBA& rgba, const Eigen::Vector3d& at,
                  const Eigen::Vector3d& scale) {
  Marker marker;
  marker.type = type;
  marker.color = rgba;
  marker.pose = toPoseMsg(Eigen::Isometry3d(Eigen::Translation3d(at)));
  marker.scale.x = scale.x();
  marker.scale.y = scale.y();
  marker.scale.z = scale.z();
  return marker;
}

Marker makeText(const std::string& text, const std_msgs::ColorRGBA& rgba, const Eigen::Vector3d& at,
                const double height) {
  Marker marker = makeMarker(Marker::TEXT_VIEW_FACING, rgba, at, {0.0, 0.0, height});
  marker.text = text;
  return marker;
}

double linesBelowFirst(const std::string& text) {
  return static_cast<double>(std::count(text.begin(), text.end(), '\n'));
}

/// In lines that stay beside the part.
std::string wrapped(const std::string& text, const std::size_t width) {
  std::istringstream in(text);
  std::string lines, word;
  std::size_t column = 0;
  while (in >> word) {
    const bool fits = column + word.size() <= width;
    lines += (lines.empty() ? "" : fits ? " " : "\n") + word;
    column = fits ? column + word.size() + 1 : word.size();
  }
  return lines;
}

Marker body(const PartModel& part) {
  Marker solid = makeMarker(Marker::TRIANGLE_LIST, colorOf(0.45f, 0.47f, 0.5f),
                            Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones());
  for (const Eigen::Vector3d& corner : planar_bin_picking::solidTriangles(part))
    solid.points.push_back(toPointMsg(corner));
  return solid;
}

/// None where the part has no such contours: rviz reports lines without points as errors.
void addContours(const PartModel& part, const LoopKind kind, const std_msgs::ColorRGBA& rgba,
                 std::vector<Marker>* markers) {
  Marker lines = makeMarker(Marker::LINE_LIST, rgba, Eigen::Vector3d::Zero(), {kLine, 0.0, 0.0});
  for (const Loop& loop : part.file().drawing.loops) {
    if (loop.kind != kind) continue;
    for (const Face face : {Face::kFront, Face::kBack}) {
      if (face == Face::kBack && kind == LoopKind::kPrint) continue;
      const double z = part.faceZ(face) + (face == Face::kFront ? kOverFace : -kOverFace);
      for (std::size_t i = 0; i + (loop.closed ? 0 : 1) < loop.points.size(); ++i) {
        for (const auto& p : {loop.points[i], loop.points[(i + 1) % loop.points.size()]})
          lines.points.push_back(toPointMsg({p.x(), p.y(), z}));
      }
    }
  }
  if (!lines.points.empty()) markers->push_back(lines);
}

void addAxes(const double length, std::vector<Marker>* markers) {
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d end = length * Eigen::Vector3d::Unit(axis);
    Marker arrow = makeMarker(Marker::ARROW, colorOf(axis == 0, 0.8f * (axis == 1), axis == 2),
                              Eigen::Vector3d::Zero(), {0.04 * length, 0.1 * length, 0.2 * length});
    arrow.points = {toPointMsg({0.0, 0.0, 0.0}), toPointMsg({end.x(), end.y(), end.z()})};
    markers->push_back(arrow);
  }
}

InteractiveMarker marker(const std::string& name, const double scale) {
  InteractiveMarker made;
  made.header.frame_id = kTaughtFrame;
  made.name = name;
  made.scale = static_cast<float>(scale);
  made.pose.orientation.w = 1.0;
  return made;
}

InteractiveMarkerControl handle(const std::string& name, const std::uint8_t mode,
                                const Eigen::Vector3d& axis) {
  InteractiveMarkerControl control;
  control.name = name;
  control.interaction_mode = mode;
  control.orientation = xToward(axis);
  return control;
}

}  // namespace

InteractiveMarker partMarker(const TaughtPart& taught, const std::string& news) {
  const PartModel& part = taught.part();
  InteractiveMarker made = marker(kPartMarker, part.radius());
  InteractiveMarkerControl control =
      handle("menu", InteractiveMarkerControl::MENU, Eigen::Vector3d::UnitX());
  control.always_visible = true;
  control.markers = {body(part)};
  addContours(part, LoopKind::kOuter, colorOf(1.0f, 1.0f, 1.0f), &control.markers);
  addContours(part, LoopKind::kHole, colorOf(0.3f, 0.8f, 1.0f), &control.markers);
  addContours(part, LoopKind::kPrint, colorOf(0.2f, 0.4f, 1.0f), &control.markers);
  addAxes(kAxis * part.radius(), &control.markers);
  Eigen::AlignedBox2d box;
  for (const auto& p : part.file().drawing.loops.front().points) box.extend(p);
  const std::size_t count = taught.poses().size();
  std::string text = part.name() + ": " + std::to_string(count) + " pick pose" +
                     (count == 1 ? "" : "s") + (taught.isChanged() ? ", not saved" : "");
  if (count > 0 && !part.file().tool.radius)
    text += "\n" +
            wrapped("no tool_radius_mm in its file: only the disk's middle is checked", kTextWidth);
  if (!news.empty()) text += "\n" + wrapped(news, kTextWidth);
  const double above = 0.25 + kHalfLine * kText * linesBelowFirst(text);
  control.markers.push_back(makeText(text, colorOf(1.0f, 1.0f, 1.0f),
                                     {box.center().x(), box.max().y() + above * part.radius(), 0.0},
                                     kText * part.radius()));
  // Below the part, where no handles are in the way.
  std::string faults;
  for (const PickPose& pose : taught.poses()) {
    const std::string fault = taught.faultOf(pose);
    if (!fault.empty())
      faults += (faults.empty() ? "" : "\n") + wrapped(pose.name + ": " + fault, kFaultWidth);
  }
  if (!faults.empty()) {
    const double below = 0.4 + kHalfLine * kFaultText * linesBelowFirst(faults);
    control.markers.push_back(
        makeText(faults, kRed, {box.center().x(), box.min().y() - below * part.radius(), 0.0},
                 kFaultText * part.radius()));
  }
  made.controls.push_back(control);
  return made;
}

InteractiveMarker poseMarker(const TaughtPart& taught, const PickPose& pose) {
  const double radius = taught.part().radius();
  const double tool = taught.part().file().tool.radius.value_or(kToolRadius);
  const double length = std::max(2.0 * tool, kHandle * radius);
  InteractiveMarker made = marker(pose.name, std::max(2.4 * tool, kHandle * radius));
  made.pose = toPoseMsg(pose.T_part_pick);
  const std::string fault = taught.faultOf(pose);
  const std_msgs::ColorRGBA rgba = !fault.empty()                  ? colorOf(1.0f, 0.1f, 0.1f)
                                   : faceFor(pose) == Face::kFront ? colorOf(0.1f, 0.8f, 0.2f)
                                                                   : colorOf(1.0f, 0.55f, 0.0f);
  // All of it follows the pose: the footprint is what one drags in the tool's plane.
  InteractiveMarkerControl drag =
      handle("move", InteractiveMarkerControl::MOVE_PLANE, Eigen::Vector3d::UnitZ());
  drag.always_visible = true;
  std_msgs::ColorRGBA clear = rgba;
  clear.a = 0.6f;
  drag.markers = {
      makeMarker(Marker::CYLINDER, clear, {0.0, 0.0, -0.0005}, {2.0 * tool, 2.0 * tool, 0.001}),
      makeMarker(Marker::CUBE, colorOf(1.0f, 1.0f, 1.0f), {0.5 * tool, 0.0, -0.0012},
                 {tool, 0.12 * tool, 0.0006}),
      makeText(pose.name, rgba, {0.0, 0.0, -1.3 * length}, kText * radius)};
  Marker axis = makeMarker(Marker::ARROW, rgba, Eigen::Vector3d::Zero(),
                           {0.06 * length, 0.14 * length, 0.2 * length});
  axis.points = {toPointMsg({0.0, 0.0, -length}), toPointMsg({0.0, 0.0, 0.0})};
  drag.markers.push_back(axis);
  made.controls = {
      drag, handle("depth", InteractiveMarkerControl::MOVE_AXIS, Eigen::Vector3d::UnitZ()),
      handle("turn", InteractiveMarkerControl::ROTATE_AXIS, Eigen::Vector3d::UnitZ()),
      handle("tilt x", InteractiveMarkerControl::ROTATE_AXIS, Eigen::Vector3d::UnitX()),
      handle("tilt y", InteractiveMarkerControl::ROTATE_AXIS, Eigen::Vector3d::UnitY())};
  return made;
}

}  // namespace planar_bin_picking_ros
