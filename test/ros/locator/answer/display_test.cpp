// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/display.h"

#include "shared/convert.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::LocatedPart;
using planar_bin_picking::Loop;
using planar_bin_picking::PartModel;
using visualization_msgs::Marker;

/// A square of 0.1 m with an open scratch printed on it, 5 mm thick.
planar_bin_picking::PartPtr makePart() {
  planar_bin_picking::PartFile file;
  file.name = "square";
  file.thickness = 0.005;
  Loop outer, print;
  outer.points = {{0.0, 0.0}, {0.1, 0.0}, {0.1, 0.1}, {0.0, 0.1}};
  print.kind = planar_bin_picking::LoopKind::kPrint;
  print.closed = false;
  print.points = {{0.02, 0.05}, {0.08, 0.05}};
  file.drawing.loops = {outer, print};
  return std::make_shared<const PartModel>(file);
}

LocatedPart makeLocated(const std::uint8_t face) {
  LocatedPart located;
  located.part = "square";
  located.child_frame = "square_1";
  located.face = face;
  located.score = 0.914;
  located.pose.pose.position.z = 0.9;
  located.pose.pose.orientation.w = 1.0;
  return located;
}

std_msgs::Header base() {
  std_msgs::Header header;
  header.frame_id = "base";
  header.stamp = ros::Time(5.0);
  return header;
}

std::vector<Marker> of(const std::string& ns, const visualization_msgs::MarkerArray& array) {
  std::vector<Marker> found;
  for (const Marker& marker : array.markers)
    if (marker.ns == ns) found.push_back(marker);
  return found;
}

TEST(Display, NothingLocatedClearsTheViewer) {
  const auto array = makeMarkers({base(), {}, {}, {makePart()}, 0.0});
  ASSERT_EQ(array.markers.size(), 1u);
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

TEST(Display, BodyOutlineAndNameOfEachPart) {
  const auto array = makeMarkers({base(), {makeLocated(LocatedPart::BACK)}, {}, {makePart()}, 0.0});
  EXPECT_EQ(array.markers.size(), 4u);
  ASSERT_EQ(of("outline", array).size(), 1u);
  const Marker outline = of("outline", array).front();
  EXPECT_EQ(outline.header.frame_id, "base");
  EXPECT_TRUE(outline.header.stamp.isZero());      // to be seen at any later time
  ASSERT_EQ(outline.points.size(), 2u * (4 + 1));  // closed loop and open line, two ends a segment
  EXPECT_EQ(outline.points[7].x, 0.0);             // the loop ends where it begins
  EXPECT_EQ(outline.points[7].y, 0.0);
  EXPECT_NEAR(outline.points[0].z, -0.005, 1e-3);  // the back is the visible face
  EXPECT_LT(outline.points[0].z, -0.005);          // and the body does not hide its lines
  ASSERT_EQ(of("name", array).size(), 1u);
  const Marker name = of("name", array).front();
  EXPECT_EQ(name.text, "1: square_1 0.91");
  EXPECT_NEAR(name.pose.position.x, 0.05, 1e-9);
  EXPECT_NEAR(name.pose.position.z, 0.895 - name.scale.z, 1e-9);  // away from the body
  ASSERT_EQ(of("solid", array).size(), 1u);
  const Marker solid = of("solid", array).front();
  EXPECT_EQ(solid.type, Marker::TRIANGLE_LIST);
  EXPECT_EQ(solid.points.size(), 3u * (2 + 2 + 8));  // two faces, four walls
  EXPECT_EQ(solid.scale.x, 1.0);
  EXPECT_GT(solid.color.g, solid.color.b);
}

TEST(Display, FrontIsAtTheDrawingsPlane) {
  const auto array =
      makeMarkers({base(), {makeLocated(LocatedPart::FRONT)}, {}, {makePart()}, 0.0});
  EXPECT_NEAR(of("outline", array).front().points[0].z, 0.0, 1e-3);
  EXPECT_GT(of("outline", array).front().points[0].z, 0.0);
}

TEST(Display, WhatIsRefusedIsGreyAndSaysWhy) {
  planar_bin_picking::RefusedPart refused;
  refused.reason = planar_bin_picking::RefusedPart::NEEDS_VIEW;
  refused.located = makeLocated(LocatedPart::FRONT);
  const auto array = makeMarkers({base(), {}, {refused, refused}, {makePart()}, 0.0});
  ASSERT_EQ(of("refused", array).size(), 2u);
  const Marker solid = of("refused", array).back();
  EXPECT_EQ(solid.color.r, solid.color.g);
  EXPECT_EQ(solid.color.r, solid.color.b);
  EXPECT_EQ(solid.id, 1);  // rviz tells them apart by it
  ASSERT_EQ(of("reason", array).size(), 2u);
  EXPECT_EQ(of("reason", array).front().text, "NEEDS_VIEW");
  EXPECT_EQ(of("refused_outline", array).size(), 2u);
  EXPECT_TRUE(of("solid", array).empty());
}

TEST(Display, ToolsStandAtThePickPoses) {
  LocatedPart located = makeLocated(LocatedPart::FRONT);
  located.picks.resize(2);
  for (auto& pick : located.picks) pick.pose.orientation.x = 1.0;  // z down
  located.picks[0].pose.position.z = 0.9;
  const auto array = makeMarkers({base(), {located}, {}, {makePart()}, 0.02});
  ASSERT_EQ(of("pick", array).size(), 2u);
  const Marker arrow = of("pick", array).front();
  EXPECT_EQ(arrow.points.back().z, 0.0);  // the point is at the contact, the tool comes from above
  EXPECT_LT(arrow.points.front().z, 0.0);
  ASSERT_EQ(of("tool", array).size(), 1u);
  EXPECT_DOUBLE_EQ(of("tool", array).front().scale.x, 0.04);
  EXPECT_GT(of("tool", array).front().pose.position.z, 0.9);
  EXPECT_TRUE(of("tool", makeMarkers({base(), {located}, {}, {makePart()}, 0.0})).empty());
  EXPECT_TRUE(of("tool_bodies", array).empty());
  // A finger as a body: four walls and two ends, in the tool's frame.
  const auto bodies = planar_bin_picking::toolBodies({0.01, 0.0, -0.05, 0.02, 0.01, 0.005}, {});
  const auto fingers =
      of("tool_bodies", makeMarkers({base(), {located}, {}, {makePart()}, 0.0, bodies}));
  ASSERT_EQ(fingers.size(), 1u);
  EXPECT_EQ(fingers[0].points.size(), 3u * (4 * 2 + 2 * 2));
  EXPECT_NEAR(fingers[0].pose.position.z, 0.9, 1e-9);
  for (const auto& p : fingers[0].points) {
    EXPECT_TRUE(p.x == 0.01 || p.x == 0.02);
    EXPECT_TRUE(p.z == -0.05 || p.z == 0.005);
  }
}

}  // namespace
}  // namespace planar_bin_picking_ros
