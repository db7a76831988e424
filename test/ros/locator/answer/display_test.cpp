// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/display.h"

#include "shared/convert.h"

#include <gtest/gtest.h>

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

TEST(Display, NothingLocatedClearsTheViewer) {
  const auto array = makeMarkers(base(), {}, {makePart()});
  ASSERT_EQ(array.markers.size(), 1u);
  EXPECT_EQ(array.markers[0].action, Marker::DELETEALL);
}

TEST(Display, OutlineAndNameOfEachPart) {
  const auto array = makeMarkers(base(), {makeLocated(LocatedPart::BACK)}, {makePart()});
  ASSERT_EQ(array.markers.size(), 3u);
  const Marker& outline = array.markers[1];
  EXPECT_EQ(outline.header.frame_id, "base");
  EXPECT_TRUE(outline.header.stamp.isZero());      // to be seen at any later time
  ASSERT_EQ(outline.points.size(), 2u * (4 + 1));  // closed loop and open line, two ends a segment
  EXPECT_EQ(outline.points[7].x, 0.0);             // the loop ends where it begins
  EXPECT_EQ(outline.points[7].y, 0.0);
  EXPECT_EQ(outline.points[0].z, -0.005);  // the back is the visible face
  const Marker& name = array.markers[2];
  EXPECT_EQ(name.text, "square_1 0.91");
  EXPECT_NEAR(name.pose.position.x, 0.05, 1e-9);
  EXPECT_NEAR(name.pose.position.z, 0.895, 1e-9);
}

TEST(Display, FrontIsAtTheDrawingsPlane) {
  const auto array = makeMarkers(base(), {makeLocated(LocatedPart::FRONT)}, {makePart()});
  EXPECT_EQ(array.markers[1].points[0].z, 0.0);
}

}  // namespace
}  // namespace planar_bin_picking_ros
