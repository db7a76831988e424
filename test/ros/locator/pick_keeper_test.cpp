// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "offered.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace planar_bin_picking_ros {
namespace {

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

/// Where something lies on the first, the better confirmed one of the rest comes first.
TEST(PickKeeper, OrdersByWhatEdgesConfirm) {
  PickKeeper keeper{PickParams()};
  Answer answer = answerWith({lying(0, 0), lying(0.15, 0), lying(-0.15, 0)}, 1.0);
  auto& found = answer.result.detections;
  found[0].visible_fraction = 0.8;
  found[1].evidence.edges = 0.8, found[1].score = 0.99;
  found[2].evidence.edges = 0.9, found[2].score = 0.98;
  const auto parts = offer(&keeper, answer).offered.parts;
  ASSERT_EQ(parts.size(), 3u);
  EXPECT_EQ(parts[0].score, 0.98);
  EXPECT_EQ(parts[1].score, 0.99);
}

/// The robot has dragged it by 10 mm: another instance, and likely to fail once more.
TEST(PickKeeper, WhatMovedSinceItsPickFailedComesAfterOthers) {
  PickKeeper keeper{PickParams()};
  offer(&keeper, answerWith({lying(0, 0), lying(0.15, 0)}, 1.0));
  report(&keeper, 1.0, "hinge_1", false);
  Answer next = answerWith({lying(0.01, 0), lying(0.15, 0)}, 2.0);
  ASSERT_EQ(offer(&keeper, next).offered.parts.size(), 2u);
  EXPECT_NEAR(offer(&keeper, next).offered.parts[0].pose.pose.position.x, 0.15, 1e-9);
  next.result.detections[1].visible_fraction = 0.9;  // and may be held down
  auto parts = offer(&keeper, next).offered.parts;
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_NEAR(parts[0].pose.pose.position.x, 0.15, 1e-9);
  // Nothing has failed there before.
  PickKeeper fresh{PickParams()};
  parts = offer(&fresh, next).offered.parts;
  EXPECT_NEAR(parts.at(0).pose.pose.position.x, 0.01, 1e-9);
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

}  // namespace
}  // namespace planar_bin_picking_ros
