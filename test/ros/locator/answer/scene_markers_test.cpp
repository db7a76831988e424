// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/scene_markers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking_ros {
namespace {

using visualization_msgs::Marker;

TEST(SceneMarkers, TheBinIsABoxWithAFloorToClickOn) {
  const Markers bin = binMarkers("bin", Eigen::Isometry3d(Eigen::Translation3d(0.0, 0.5, 0.0)),
                                 {-0.2, -0.1, 0.01}, {0.2, 0.3, 0.11});
  ASSERT_EQ(bin.size(), 2u);
  EXPECT_EQ(bin[0].header.frame_id, "bin");
  EXPECT_EQ(bin[0].points.size(), 2u * 12);
  EXPECT_DOUBLE_EQ(bin[1].scale.x, 0.4);
  EXPECT_DOUBLE_EQ(bin[1].scale.y, 0.4);
  EXPECT_DOUBLE_EQ(bin[0].pose.position.y, 0.5);
  EXPECT_DOUBLE_EQ(bin[1].pose.position.y, 0.6);
  EXPECT_NEAR(bin[1].pose.position.z + 0.5 * bin[1].scale.z, 0.01, 1e-12);
}

TEST(SceneMarkers, PointsThatCannotBeSavedAreRed) {
  const planar_bin_picking::RegionOutline square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  // A bin that was found elsewhere, and its region with it.
  const Eigen::Isometry3d there(Eigen::Translation3d(0.0, 0.5, 0.0));
  EXPECT_TRUE(regionMarkers("bin", there, {}, {}, true).empty());
  EXPECT_EQ(regionMarkers("bin", there, square, {}, true).size(), 1u);
  const Markers taught = regionMarkers("bin", there, square, square, true);
  const Markers wrong = regionMarkers("bin", there, square, square, false);
  ASSERT_EQ(taught.size(), 3u);
  EXPECT_EQ(taught[1].points.size(), 4u);
  EXPECT_EQ(taught[2].points.size(), 8u);
  EXPECT_GT(taught[1].color.g, 0.9f);
  EXPECT_LT(wrong[1].color.g, 0.5f);
  for (const auto& marker : taught) EXPECT_EQ(marker.pose.position.y, 0.5);
}

TEST(SceneMarkers, TheFrustumEndsWhereThePictureDoes) {
  planar_bin_picking::Camera::Model model;
  model.width = 1001, model.height = 801;
  model.fx = model.fy = 1000.0, model.cx = 500.0, model.cy = 400.0;
  const planar_bin_picking::Camera camera(model);
  const Markers shown = cameraMarkers({"camera",
                                       "cam",
                                       Eigen::Isometry3d::Identity(),
                                       camera,
                                       2.0,
                                       {{0, 0}, {500, 400}, {0, 400}},
                                       "x"});
  ASSERT_EQ(shown.size(), 4u);
  EXPECT_EQ(shown[0].points.size(), 2u * 8);
  EXPECT_NEAR(shown[0].points[0].x, -1.0, 1e-9);
  EXPECT_NEAR(shown[0].points[0].y, -0.8, 1e-9);
  EXPECT_NEAR(shown[0].points[0].z, 2.0, 1e-9);
  EXPECT_EQ(shown[2].ns, "region_px");
  EXPECT_NEAR(shown[2].points[1].x, 0.0, 1e-9);
  EXPECT_EQ(shown[3].text, "x");
  EXPECT_EQ(planeMarkers("belt").front().header.frame_id, "belt");
}

}  // namespace
}  // namespace planar_bin_picking_ros
