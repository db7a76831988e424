// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "offered.h"

namespace planar_bin_picking_ros {
namespace {

TEST(RefusedPicks, TellsOfWhatTheLocatorWithheld) {
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

TEST(RefusedPicks, RefusesAPartWithoutAPickPoseForTheFaceThatIsUp) {
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

TEST(RefusedPicks, TellsWhyItRefuses) {
  PickParams params;
  params.tool_radius = 0.015;
  PickKeeper keeper(params);
  Answer answer = answerWith({lying(0.045, 0)}, 1.0);
  planar_bin_picking::PartFile file = answer.parts[0]->file();
  file.pick_poses.resize(1);  // that in the middle, 5 mm from the wall
  answer.parts = {std::make_shared<const PartModel>(file)};
  Sent sent = offer(&keeper, answer, binUpTo(0.1));
  EXPECT_TRUE(sent.offered.parts.empty());
  ASSERT_EQ(sent.offered.refused.size(), 1u);
  EXPECT_EQ(sent.offered.refused[0].reason, RefusedPart::WALL);
  EXPECT_EQ(sent.offered.refused[0].located.part, "hinge");
  EXPECT_NE(sent.offered.hint.find("wall"), std::string::npos);
  // The left one is farther inside.
  sent = offer(&keeper, answerWith({lying(0.045, 0)}, 2.0), binUpTo(0.1));
  ASSERT_EQ(sent.offered.parts.size(), 1u);
  EXPECT_EQ(sent.offered.parts[0].picks.at(0).name.substr(0, 4), "left");
  sent = offer(&keeper, answerWith({lying(0.0, 0)}, 3.0), binUpTo(0.1));
  EXPECT_TRUE(sent.offered.refused.empty());
}

// The hinge's centre is 50 mm and 25 mm from its origin; the covariance is that of the centre.
TEST(RefusedPicks, RefusesWhatLiesOutsideOfTheBin) {
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

TEST(RefusedPicks, HoldsScoreAndVisibilityAgainstTheLimits) {
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

TEST(RefusedPicks, TiltIsAgainstTheFloorOrTheImagePlane) {
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

TEST(RefusedPicks, LeavesOutPicksThatSomethingCovers) {
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
