// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "pick_keeper.h"

#include "convert.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::Detection;
using planar_bin_picking::PickBin;
using planar_bin_picking::PickParams;
using planar_bin_picking::RefusedPart;
using Request = planar_bin_picking::ReportPick::Request;
using Response = planar_bin_picking::ReportPick::Response;

/// Camera and target frame alike: z down. Parts lie 0.8 m below, front up.
Eigen::Isometry3d lying(double x, double y) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, 0.8);
  T.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

Answer answerWith(const std::vector<Eigen::Isometry3d>& poses, double stamp, int grey = 90) {
  planar_bin_picking::Camera::Model model;
  model.width = 1280, model.height = 1024, model.fx = model.fy = 1500.0, model.cx = 640.0,
  model.cy = 512.0;
  const auto part = std::make_shared<const planar_bin_picking::PartModel>(
      planar_bin_picking::loadPartFile(std::string(PACKAGE_DIR) + "/test/data/parts/hinge.yaml"));
  Answer answer{{part},
                {},
                cv::Mat(1024, 1280, CV_8U, cv::Scalar(grey)),
                planar_bin_picking::Camera(model),
                {},
                {},
                {}};
  answer.header.stamp = ros::Time(stamp);
  answer.header.frame_id = "camera";
  for (const auto& T : poses) {
    Detection detection;
    detection.T_camera_part = T;
    detection.score = 0.9;
    detection.visible_fraction = 1.0;
    detection.part_name = "hinge";
    answer.result.detections.push_back(detection);
    answer.located.push_back(toMsg(detection, *part, Eigen::Isometry3d::Identity()));
    answer.located.back().header = answer.header;
  }
  return answer;
}

/// Sorts and keeps the answer, its frames named as the publisher would name them.
Answer offer(PickKeeper* keeper, Answer answer, const PickKeeper::Frames& frames = {}) {
  const auto sorted = keeper->sort(&answer, frames);
  for (std::size_t i = 0; i < answer.located.size(); ++i)
    answer.located[i].child_frame = "hinge_" + std::to_string(i + 1);
  keeper->keep(answer.located, sorted.offered);
  return answer;
}

Response report(PickKeeper* keeper, double stamp, const std::string& frame, bool success) {
  Request request;
  request.stamp = ros::Time(stamp);
  request.child_frame = frame;
  request.success = success;
  Response response;
  keeper->report(request, &response);
  return response;
}

TEST(PickKeeper, GivesTheNextInRankAfterAFailure) {
  PickKeeper keeper{PickParams()};
  const Answer answer = offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  Response response = report(&keeper, 1.0, "hinge_1", false);
  EXPECT_EQ(response.status, Response::NEXT);
  EXPECT_EQ(response.next.child_frame, "hinge_2");
  EXPECT_EQ(response.next.picks.size(), answer.located[1].picks.size());
  response = report(&keeper, 1.0, "hinge_2", false);
  EXPECT_EQ(response.status, Response::LOCATE);
}

TEST(PickKeeper, AsksForANewImageAfterASuccess) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", true).status, Response::LOCATE);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_2", true).status, Response::UNKNOWN_PART);
}

TEST(PickKeeper, KnowsThePartsOfTheLatestAnswerAlone) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0)}, 1.0));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_7", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 2.0, "hinge_1", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::LOCATE);
}

TEST(PickKeeper, OffersAFailedInstanceLastUntilTheSceneHasChanged) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  report(&keeper, 1.0, "hinge_1", false);
  Answer answer = offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 2.0));
  ASSERT_EQ(answer.located.size(), 2u);
  EXPECT_NEAR(answer.located[0].pose.pose.position.x, 0.15, 1e-9);
  EXPECT_NEAR(answer.result.detections[0].T_camera_part.translation().x(), 0.15, 1e-9);
  Answer changed = answerWith({lying(0, 0), lying(0.15, 0)}, 3.0);
  cv::rectangle(changed.grey, {640, 300}, {860, 512}, cv::Scalar(255), cv::FILLED);
  answer = offer(&keeper, changed);
  EXPECT_NEAR(answer.located[0].pose.pose.position.x, 0.0, 1e-9);
}

TEST(PickKeeper, TellsWhyItRefuses) {
  PickParams params;
  params.tool_radius = 0.015;
  PickKeeper keeper(params);
  PickKeeper::Frames frames;
  frames.bin = PickBin();
  frames.bin->min = Eigen::Vector3d(-0.2, -0.2, -0.81);  // the bin's z is up, the camera's down
  frames.bin->max = Eigen::Vector3d(0.1, 0.2, -0.7);
  frames.bin->T_bin_target.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  Answer answer = answerWith({lying(0.045, 0)}, 1.0);  // its pick pose is 5 mm from the wall
  const auto sorted = keeper.sort(&answer, frames);
  EXPECT_TRUE(answer.located.empty());
  ASSERT_EQ(sorted.refused.size(), 1u);
  EXPECT_EQ(sorted.refused[0].reason, RefusedPart::WALL);
  EXPECT_EQ(sorted.refused[0].located.part, "hinge");
  EXPECT_NE(sorted.hint.find("wall"), std::string::npos);
  answer = answerWith({lying(0.0, 0)}, 1.0);
  EXPECT_TRUE(keeper.sort(&answer, frames).refused.empty());
}

}  // namespace
}  // namespace planar_bin_picking_ros
