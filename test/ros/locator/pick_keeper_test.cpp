// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/pick_keeper.h"

#include "shared/convert.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::Detection;
using planar_bin_picking::PartModel;
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

std::shared_ptr<const PartModel> load(const std::string& name) {
  return std::make_shared<const PartModel>(planar_bin_picking::loadPartFile(
      std::string(PACKAGE_DIR) + "/test/data/parts/" + name + ".yaml"));
}

Detection detectionAt(const Eigen::Isometry3d& T_camera_part, const std::string& name) {
  Detection detection;
  detection.T_camera_part = T_camera_part;
  detection.score = 0.9;
  detection.evidence.edges = 0.9;
  detection.visible_fraction = 1.0;
  detection.part_name = name;
  return detection;
}

Answer answerWith(const std::vector<Eigen::Isometry3d>& poses, double stamp, int grey = 90,
                  const std::string& name = "hinge") {
  planar_bin_picking::Camera::Model model;
  model.width = 1280, model.height = 1024, model.fx = model.fy = 1500.0, model.cx = 640.0,
  model.cy = 512.0;
  Answer answer{{load(name)},
                {},
                cv::Mat(1024, 1280, CV_8U, cv::Scalar(grey)),
                planar_bin_picking::Camera(model),
                {},
                {},
                {}};
  answer.frame.received = std::chrono::steady_clock::now();
  answer.header.stamp = ros::Time(stamp);
  answer.header.frame_id = "camera";
  for (const auto& T : poses) answer.result.detections.push_back(detectionAt(T, name));
  return answer;
}

/// What went out: the answer and what was said of it.
struct Sent {
  Answer answer;
  PickKeeper::Offered offered;
};

/// Offers the answer, its frames named as the publisher would name them.
Sent offer(PickKeeper* keeper, const Answer& answer, const PickKeeper::Frames& frames = {},
           const PickKeeper::Call& call = {"/robot", 0}) {
  Sent sent{answer, {}};
  sent.offered = keeper->offer(answer, frames, call, [&](Answer out) {
    for (std::size_t i = 0; i < out.located.size(); ++i)
      out.located[i].child_frame = out.located[i].part + "_" + std::to_string(i + 1);
    sent.answer = out;
    return out.located;
  });
  EXPECT_EQ(sent.answer.located.size(), sent.answer.result.detections.size());
  return sent;
}

Response report(PickKeeper* keeper, double stamp, const std::string& frame, bool success,
                const std::string& caller = "/robot") {
  Request request;
  request.stamp = ros::Time(stamp);
  request.child_frame = frame;
  request.success = success;
  Response response;
  keeper->report(caller, request, &response);
  return response;
}

TEST(PickKeeper, GivesTheNextInRankAfterAFailure) {
  PickKeeper keeper{PickParams()};
  const Sent sent = offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  ASSERT_EQ(sent.offered.parts.size(), 2u);
  EXPECT_EQ(sent.offered.parts[0].header.stamp, ros::Time(1.0));
  EXPECT_FALSE(sent.offered.parts[0].picks.empty());
  Response response = report(&keeper, 1.0, "hinge_1", false);
  EXPECT_EQ(response.status, Response::NEXT);
  EXPECT_EQ(response.next.child_frame, "hinge_2");
  EXPECT_EQ(response.message, "failed; next in rank: hinge_2");
  EXPECT_EQ(response.next.picks.size(), sent.offered.parts[1].picks.size());
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::UNKNOWN_PART);
  response = report(&keeper, 1.0, "hinge_2", false);
  EXPECT_EQ(response.status, Response::LOCATE);
  EXPECT_NE(response.message.find("nothing else was offered"), std::string::npos);
}

TEST(PickKeeper, AsksForANewImageAfterASuccess) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", true).status, Response::LOCATE);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_2", true).status, Response::UNKNOWN_PART);
}

TEST(PickKeeper, KnowsThePartsOfAnswersThatHoldAlone) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0)}, 1.0));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_7", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 2.0, "hinge_1", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::LOCATE);
}

// One program, two kinds of parts: the second answer says nothing of the first one's parts.
TEST(PickKeeper, AnAnswerHoldsUntilItsPartIsAskedForAgain) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  offer(&keeper, answerWith({lying(0, 0.1)}, 2.0, 90, "bracket"));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::NEXT);
  offer(&keeper, answerWith({lying(0, 0)}, 3.0));
  EXPECT_EQ(report(&keeper, 1.0, "hinge_2", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 2.0, "bracket_1", false).status, Response::LOCATE);
  EXPECT_EQ(report(&keeper, 3.0, "hinge_1", false).status, Response::LOCATE);
  // Asked for again and not found: that, too, is an answer.
  offer(&keeper, answerWith({lying(0, 0)}, 4.0));
  offer(&keeper, answerWith({}, 5.0));
  EXPECT_EQ(report(&keeper, 4.0, "hinge_1", false).status, Response::UNKNOWN_PART);
}

TEST(PickKeeper, KeepsEachCallersAnswers) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0), {}, {"/left", 0});
  offer(&keeper, answerWith({lying(0.15, 0)}, 1.0), {}, {"/right", 0});
  // Both have a hinge_1 of that stamp, and each means its own.
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false, "/left").next.child_frame, "hinge_2");
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false, "/right").status, Response::LOCATE);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_2", false, "/left").status, Response::LOCATE);
}

// rosservice has another name at each call; what is reported is named well enough all the same.
TEST(PickKeeper, AnybodyMayReport) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0)}, 1.0), {}, {"/rosservice_1", 0});
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 2.0), {}, {"/rosservice_2", 0});
  EXPECT_EQ(report(&keeper, 2.0, "hinge_1", false, "/rosservice_3").status, Response::NEXT);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false, "/rosservice_4").status, Response::LOCATE);
}

TEST(PickKeeper, ForgetsTheOldestOfVeryManyAnswers) {
  PickKeeper keeper{PickParams()};
  const Answer answer = answerWith({lying(0, 0)}, 1.0);
  for (int i = 0; i < 101; ++i) offer(&keeper, answer, {}, {"/caller_" + std::to_string(i), 0});
  for (int i = 0; i < 100; ++i) {
    const std::string caller = "/caller_" + std::to_string(100 - i);
    EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false, caller).status, Response::LOCATE);
  }
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::UNKNOWN_PART);
}

// One has picked: what the other one was offered out of an older image may lie elsewhere.
TEST(PickKeeper, ASuccessEndsOffersOutOfOlderImages) {
  PickKeeper keeper{PickParams()};
  const Answer before = answerWith({lying(0.15, 0), lying(0, 0.1)}, 1.0);
  offer(&keeper, before, {}, {"/left", 0});
  offer(&keeper, answerWith({lying(0, 0)}, 1.5, 90, "bracket"), {}, {"/right", 0});
  EXPECT_EQ(report(&keeper, 1.5, "bracket_1", true, "/right").status, Response::LOCATE);
  const Response response = report(&keeper, 1.0, "hinge_1", false, "/left");
  EXPECT_EQ(response.status, Response::LOCATE);
  EXPECT_NE(response.message.find("changed since the image"), std::string::npos);
  // Its failure was noted all the same.
  const Sent after =
      offer(&keeper, answerWith({lying(0.15, 0), lying(0, 0.1)}, 2.0), {}, {"/left", 0});
  EXPECT_NEAR(after.offered.parts.at(0).pose.pose.position.x, 0.0, 1e-9);
  EXPECT_EQ(report(&keeper, 2.0, "hinge_1", false, "/left").status, Response::NEXT);
}

TEST(PickKeeper, OffersAFailedInstanceLastUntilTheSceneHasChanged) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  report(&keeper, 1.0, "hinge_1", false);
  Sent sent = offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 2.0));
  ASSERT_EQ(sent.offered.parts.size(), 2u);
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.15, 1e-9);
  EXPECT_NEAR(sent.answer.result.detections[0].T_camera_part.translation().x(), 0.15, 1e-9);
  Answer changed = answerWith({lying(0, 0), lying(0.15, 0)}, 3.0);
  cv::rectangle(changed.grey, {640, 300}, {860, 512}, cv::Scalar(255), cv::FILLED);
  sent = offer(&keeper, changed);
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.0, 1e-9);
}

// The surroundings look different from elsewhere, which must not pass for a change of the scene.
TEST(PickKeeper, RemembersAFailureByTheFirstPicture) {
  PickKeeper keeper{PickParams()};
  const Answer home = answerWith({lying(0, 0), lying(0.15, 0)}, 2.0);
  Answer refined = answerWith({lying(0, 0), lying(0.15, 0)}, 1.0, 200);
  refined.first = FirstPicture{home.grey, home.camera, Eigen::Isometry3d::Identity()};
  offer(&keeper, refined);
  report(&keeper, 1.0, "hinge_1", false);
  const Sent sent = offer(&keeper, home);
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.15, 1e-9);
}

TEST(PickKeeper, ARefinedPartTakesItsOwnPlaceAlone) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  Answer refined = answerWith({lying(0, 0)}, 2.0);
  refined.former = std::vector<FormerPart>{{ros::Time(1.0), "hinge_1"}};
  offer(&keeper, refined);
  EXPECT_EQ(report(&keeper, 1.0, "hinge_1", false).status, Response::UNKNOWN_PART);
  EXPECT_EQ(report(&keeper, 2.0, "hinge_1", false).next.header.stamp, ros::Time(1.0));
}

TEST(PickKeeper, SeesChangesInTwelveBits) {
  PickKeeper keeper{PickParams()};
  const auto deep = [](Answer answer) {
    answer.grey.convertTo(answer.grey, CV_16U, 16.0);
    answer.grey.at<std::uint16_t>(0, 0) = 4095;
    return answer;
  };
  offer(&keeper, deep(answerWith({lying(0, 0), lying(0.15, 0)}, 1.0)));
  report(&keeper, 1.0, "hinge_1", false);
  Answer changed = answerWith({lying(0, 0), lying(0.15, 0)}, 3.0);
  Sent sent = offer(&keeper, deep(changed));
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.15, 1e-9);
  cv::rectangle(changed.grey, {640, 300}, {860, 512}, cv::Scalar(255), cv::FILLED);
  sent = offer(&keeper, deep(changed));
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.0, 1e-9);
}

// The first in rank failed twice: the one that was asked for is the next, and no deadlock.
TEST(PickKeeper, CutsAfterThePolicy) {
  PickKeeper keeper{PickParams()};
  const std::vector<Eigen::Isometry3d> poses = {lying(0, 0), lying(0.15, 0), lying(-0.15, 0)};
  for (const double stamp : {1.0, 2.0}) {
    const Sent sent = offer(&keeper, answerWith(poses, stamp));
    const auto& parts = sent.offered.parts;
    const auto first = std::find_if(parts.begin(), parts.end(), [](const auto& part) {
      return std::abs(part.pose.pose.position.x) < 1e-9;
    });
    ASSERT_NE(first, parts.end());
    report(&keeper, stamp, first->child_frame, false);
  }
  const Sent sent = offer(&keeper, answerWith(poses, 3.0), {}, {"/robot", 1});
  ASSERT_EQ(sent.offered.parts.size(), 1u);
  EXPECT_NEAR(sent.offered.parts[0].pose.pose.position.x, 0.15, 1e-9);
  ASSERT_EQ(sent.offered.refused.size(), 2u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::FAILED_BEFORE);
  EXPECT_EQ(sent.offered.refused[1].reason, RefusedPart::BEYOND_MAX_PARTS);
  EXPECT_NEAR(sent.offered.refused[1].located.pose.pose.position.x, -0.15, 1e-9);
}

TEST(PickKeeper, TellsOfWhatTheLocatorWithheld) {
  PickKeeper keeper{PickParams()};
  Answer answer = answerWith({}, 1.0);
  answer.result.withheld = {
      {detectionAt(lying(0, 0), "hinge"), planar_bin_picking::Withheld::kOutside, "too far"},
      {detectionAt(lying(0.15, 0), "hinge"), planar_bin_picking::Withheld::kWrongFace, "its back"}};
  const Sent sent = offer(&keeper, answer);
  EXPECT_TRUE(sent.offered.parts.empty());
  ASSERT_EQ(sent.offered.refused.size(), 2u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::OUTSIDE);
  EXPECT_EQ(sent.offered.refused[0].text, "too far");
  EXPECT_EQ(sent.offered.refused[1].reason, RefusedPart::WRONG_FACE);
  EXPECT_NEAR(sent.offered.refused[1].located.pose.pose.position.x, 0.15, 1e-9);
  EXPECT_NE(sent.offered.hint.find("1 of 2 lie outside"), std::string::npos) << sent.offered.hint;
  EXPECT_NE(sent.offered.hint.find("other face"), std::string::npos) << sent.offered.hint;
}

TEST(PickKeeper, RefusesAPartWithoutAPickPoseForTheFaceThatIsUp) {
  PickKeeper keeper{PickParams()};
  planar_bin_picking::PartFile file = load("bracket")->file();
  file.pick_poses.resize(1);  // that for the front
  Answer answer = answerWith({lying(0, 0), lying(0.15, 0)}, 1.0, 90, "bracket");
  answer.parts = {std::make_shared<const PartModel>(file)};
  Detection& turned = answer.result.detections[0];
  turned.face = planar_bin_picking::Face::kBack;
  turned.T_camera_part.linear() = Eigen::Matrix3d::Identity();
  Sent sent = offer(&keeper, answer);
  ASSERT_EQ(sent.offered.parts.size(), 1u);
  EXPECT_EQ(sent.offered.parts[0].picks.size(), 1u);
  ASSERT_EQ(sent.offered.refused.size(), 1u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::NO_PICK_POSE);
  EXPECT_NE(sent.offered.refused[0].text.find("elbow (front)"), std::string::npos)
      << sent.offered.refused[0].text;
  file.pick_poses.clear();  // none at all: the program knows where to pick
  answer.parts = {std::make_shared<const PartModel>(file)};
  sent = offer(&keeper, answer);
  EXPECT_EQ(sent.offered.parts.size(), 2u);
}

/// The bin's z is up, the camera's down.
PickKeeper::Frames binUpTo(double x_max) {
  PickKeeper::Frames frames;
  frames.bin = PickBin();
  frames.bin->min = Eigen::Vector3d(-0.2, -0.2, -0.81);
  frames.bin->max = Eigen::Vector3d(x_max, 0.2, -0.7);
  frames.bin->T_bin_target.linear() =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return frames;
}

TEST(PickKeeper, TellsWhyItRefuses) {
  PickParams params;
  params.tool_radius = 0.015;
  PickKeeper keeper(params);
  // Its pick pose is 5 mm from the wall.
  Sent sent = offer(&keeper, answerWith({lying(0.045, 0)}, 1.0), binUpTo(0.1));
  EXPECT_TRUE(sent.offered.parts.empty());
  ASSERT_EQ(sent.offered.refused.size(), 1u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::WALL);
  EXPECT_EQ(sent.offered.refused[0].located.part, "hinge");
  EXPECT_NE(sent.offered.hint.find("wall"), std::string::npos);
  sent = offer(&keeper, answerWith({lying(0.0, 0)}, 1.0), binUpTo(0.1));
  EXPECT_TRUE(sent.offered.refused.empty());
}

// The hinge's centre is 50 mm and 25 mm from its origin; the covariance is that of the centre.
TEST(PickKeeper, RefusesWhatLiesOutsideOfTheBin) {
  PickKeeper keeper{PickParams()};
  Answer answer = answerWith({lying(0.06, 0)}, 1.0);
  Sent sent = offer(&keeper, answer, binUpTo(0.1));
  ASSERT_EQ(sent.offered.refused.size(), 1u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::OUTSIDE);
  EXPECT_NE(sent.offered.refused[0].text.find("0.010 m outside"), std::string::npos)
      << sent.offered.refused[0].text;
  answer.result.detections[0].covariance(0, 0) = 4e-6;  // 2 mm
  EXPECT_TRUE(offer(&keeper, answer, binUpTo(0.1)).offered.refused.empty());
  EXPECT_TRUE(offer(&keeper, answerWith({lying(0.06, 0)}, 1.0)).offered.refused.empty());
}

TEST(PickKeeper, HoldsScoreAndVisibilityAgainstTheLimits) {
  PickParams params;
  params.score_min = 0.8, params.visible_min = 0.7;
  PickKeeper keeper(params);
  Answer answer = answerWith({lying(0, 0), lying(0.15, 0), lying(-0.15, 0)}, 1.0);
  answer.result.detections[0].score = 0.75;
  answer.result.detections[1].visible_fraction = 0.65;
  const auto offered = offer(&keeper, answer).offered;
  EXPECT_EQ(offered.parts.size(), 1u);
  ASSERT_EQ(offered.refused.size(), 2u);
  EXPECT_EQ(offered.refused[0].text, "score 0.75, at least 0.80");
  EXPECT_EQ(offered.refused[1].text, "0.65 of it visible, at least 0.70");
}

TEST(PickKeeper, TiltIsAgainstTheFloorOrTheImagePlane) {
  PickParams params;
  params.tilt_max_deg = 20.0;
  PickKeeper keeper(params);
  Eigen::Isometry3d leaning = lying(0, 0);
  leaning.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()) * leaning.linear();
  Sent sent = offer(&keeper, answerWith({leaning}, 1.0));
  ASSERT_EQ(sent.offered.refused.size(), 1u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::TILT);
  EXPECT_EQ(sent.offered.refused[0].text, "tilted by 28.6 degrees, at most 20.0");
  PickKeeper::Frames frames = binUpTo(9.0);  // a bin that leans as much
  frames.bin->min = Eigen::Vector3d(-9, -9, -9);
  frames.bin->max = Eigen::Vector3d(9, 9, 9);
  frames.bin->T_bin_target.linear() = (Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()) *
                                       Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                                          .toRotationMatrix()
                                          .transpose();
  EXPECT_TRUE(offer(&keeper, answerWith({leaning}, 1.0), frames).offered.refused.empty());
}

TEST(PickKeeper, LeavesOutPicksThatSomethingCovers) {
  PickParams params;
  params.tool_radius = 0.005;
  PickKeeper keeper(params);
  Answer answer = answerWith({lying(0, 0)}, 1.0, 90, "linkarm");
  const auto& cells = answer.parts[0]->faceGrid().cells();
  for (std::size_t i = 0; i < cells.size(); ++i)
    if ((cells[i] - Eigen::Vector2d(0.028, 0.0)).norm() < 0.004)
      answer.result.detections[0].covered.push_back(static_cast<int>(i));
  ASSERT_FALSE(answer.result.detections[0].covered.empty());
  const Sent sent = offer(&keeper, answer);
  ASSERT_EQ(sent.offered.parts.size(), 1u);
  EXPECT_GT(sent.offered.parts[0].picks.size(), 0u);
  for (const auto& pick : sent.offered.parts[0].picks) EXPECT_NE(pick.name, "near_eye");
  EXPECT_EQ(sent.answer.located[0].picks.size(), sent.offered.parts[0].picks.size());
}

}  // namespace
}  // namespace planar_bin_picking_ros
