// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/plan_markers.h"

#include "shared/convert.h"

#include <gtest/gtest.h>
#include <ros/time.h>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::HandEyeResult;
using planar_bin_picking::Mounting;
using planar_bin_picking::PlannedPose;
using State = PlannedPose::State;
using visualization_msgs::Marker;

class PlanMarkers : public testing::Test {
 protected:
  PlanMarkers() {
    ros::Time::init();
    for (const State state : {State::kSeen, State::kRefused, State::kLost, State::kPlanned}) {
      PlannedPose pose;
      pose.T_base_flange.translation().x() = 0.1 * static_cast<double>(poses_.size());
      pose.state = state;
      poses_.push_back(pose);
    }
    solution_.T_mount_camera.translation() = Eigen::Vector3d(0.0, 0.2, 0.05);
    solution_.camera.width = 800;
    solution_.camera.height = 600;
    solution_.camera.fx = solution_.camera.fy = 1000.0;
    solution_.camera.cx = 400.0;
    solution_.camera.cy = 300.0;
  }
  std::vector<Marker> make(Mounting mounting, const HandEyeResult* solution) const {
    return makePlanMarkers("base", mounting, poses_, solution).markers;
  }
  std::vector<PlannedPose> poses_;
  HandEyeResult solution_;
};

TEST_F(PlanMarkers, StandOnTheFlangeWhileTheCameraIsUnknown) {
  const auto markers = make(Mounting::kEyeInHand, nullptr);
  ASSERT_EQ(markers.size(), 5u);
  EXPECT_EQ(markers[0].action, Marker::DELETEALL);
  const float expected[][3] = {{0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 1}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Marker& marker = markers[i + 1];
    EXPECT_EQ(marker.header.frame_id, "base");
    EXPECT_EQ(marker.pose.position.x, poses_[i].T_base_flange.translation().x());
    EXPECT_EQ(marker.pose.position.y, 0.0);
    EXPECT_EQ(marker.color.r, expected[i][0]) << i;
    EXPECT_EQ(marker.color.g, expected[i][1]) << i;
    EXPECT_EQ(marker.color.b, expected[i][2]) << i;
  }
}

TEST_F(PlanMarkers, AreWhatACameraOnTheFlangeSees) {
  const auto markers = make(Mounting::kEyeInHand, &solution_);
  ASSERT_EQ(markers.size(), 5u);
  const Marker& marker = markers[2];
  EXPECT_NEAR(marker.pose.position.x, 0.1, 1e-12);
  EXPECT_NEAR(marker.pose.position.y, 0.2, 1e-12);
  EXPECT_NEAR(marker.pose.position.z, 0.05, 1e-12);
  // Half the image's width over the focal length.
  ASSERT_EQ(marker.points.size(), 16u);
  EXPECT_NEAR(marker.points[1].x / marker.points[1].z, -0.4, 1e-12);
  EXPECT_NEAR(marker.points[1].y / marker.points[1].z, -0.3, 1e-12);
}

TEST_F(PlanMarkers, ShowAFixedCameraWhereItStands) {
  const auto markers = make(Mounting::kEyeToHand, &solution_);
  ASSERT_EQ(markers.size(), 6u);
  EXPECT_EQ(markers[2].pose.position.y, 0.0);
  EXPECT_NEAR(markers[5].pose.position.y, 0.2, 1e-12);
  EXPECT_EQ(markers[5].id, 5);
}

TEST_F(PlanMarkers, AreCounted) {
  EXPECT_EQ(summarize(poses_), "4 poses: 1 seen, 1 refused, 1 board lost, 1 planned");
}

TEST_F(PlanMarkers, WayToTheNextPose) {
  visualization_msgs::MarkerArray array;
  std::vector<Eigen::Isometry3d> way(1, Eigen::Isometry3d::Identity());
  addWay("base", way, &array);
  EXPECT_TRUE(array.markers.empty());  // it stands there
  EXPECT_EQ(describeWay(way), "");
  Eigen::Isometry3d there = Eigen::Isometry3d::Identity();
  there.translation() = Eigen::Vector3d(0.0, 0.3, 0.4);
  there.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX()));
  way.push_back(there);
  EXPECT_EQ(describeWay(way), "to [  0 0.3 0.4] m: 0.5 m and 28.6 deg in 1 move");
  way.insert(way.begin() + 1, Eigen::Isometry3d::Identity());
  EXPECT_NE(describeWay(way).find("in 2 moves"), std::string::npos);
  addWay("base", way, &array);
  ASSERT_EQ(array.markers.size(), 2u);
  EXPECT_EQ(array.markers[0].points.size(), 3u);
  EXPECT_DOUBLE_EQ(array.markers[0].points[2].y, 0.3);
  EXPECT_EQ(array.markers[1].header.frame_id, "base");
  EXPECT_DOUBLE_EQ(array.markers[1].pose.position.z, 0.4);
  EXPECT_NE(array.markers[0].id, array.markers[1].id);
}

}  // namespace
}  // namespace planar_bin_picking_ros
