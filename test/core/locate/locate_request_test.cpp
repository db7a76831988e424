// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// What is asked for holds for what is answered.

#include "planar_bin_picking/locate/locator.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace planar_bin_picking {
namespace {

LocateRequest requestFor(const Parts& parts) {
  LocateRequest request;
  request.parts = parts;
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  return request;
}

/// Two brackets of either face, a wheel and a slender plate.
sim::Scene threeKinds() {
  sim::Scene scene;
  scene.plates.push_back({bracketPlate(), sim::poseOf({-110, -80, 600, 20, 8, 30})});
  scene.plates.push_back({bracketPlate(), sim::poseOf({100, -70, 590, 120, 12, 100, false})});
  scene.plates.push_back({wheelPlate(15, true), sim::poseOf({-70, 80, 610, 3, 6})});
  scene.plates.push_back({slenderPlate(), sim::poseOf({90, 90, 620, 40})});
  return scene;
}

TEST(LocateRequest, TheFaceAskedForIsAnswered) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  for (const Face face : {Face::kFront, Face::kBack}) {
    LocateRequest request = requestFor(parts);
    request.face = face == Face::kFront ? FaceFilter::kFront : FaceFilter::kBack;
    for (const std::size_t max_parts : {0, 1}) {
      request.max_parts = max_parts;
      const auto result = Locator().locate(image, makeCamera(kPinhole), request);
      ASSERT_EQ(result.detections.size(), 1u);
      EXPECT_EQ(result.detections[0].face, face);
      ASSERT_EQ(result.withheld.size(), 1u);
      EXPECT_NE(result.withheld[0].detection.face, face);
      EXPECT_EQ(result.withheld[0].reason, Withheld::kWrongFace);
    }
  }
}

/// Its mirror image differs by one small hole alone: a pose with the other face up scores well at
/// the same place.
TEST(LocateRequest, NoSecondChoiceOfTheOtherFaceSlipsIn) {
  sim::Plate plate{rectangle(-40, -25, 40, 25), {}, {}, 0.0};
  plate.holes = {circle(-25, 10, 4, true), circle(25, 0, 8, true)};
  const Parts parts = {makePart("plate", plate)};
  for (const bool front : {true, false}) {
    LocateRequest request = requestFor(parts);
    request.face = front ? FaceFilter::kBack : FaceFilter::kFront;
    const auto result =
        Locator().locate(sim::takeImage(kPinhole, sceneOf(plate, {10, 0, 600, 30, 8, 50, front})),
                         makeCamera(kPinhole), request);
    EXPECT_TRUE(result.detections.empty());
    ASSERT_EQ(result.withheld.size(), 1u);
    EXPECT_EQ(result.withheld[0].detection.face, front ? Face::kFront : Face::kBack);
  }
}

TEST(LocateRequest, ASymmetricPartIsAnsweredAsTheFaceAskedFor) {
  sim::Plate plate = slenderPlate();
  plate.outer = rectangle(-60, -15, 60, 15);
  const Parts parts = {makePart("plate", plate)};
  const cv::Mat image = sim::takeImage(kPinhole, sceneOf(plate, {10, 0, 600, 30, 8, 50}));
  std::vector<Detection> answers;
  for (const FaceFilter face : {FaceFilter::kFront, FaceFilter::kBack}) {
    LocateRequest request = requestFor(parts);
    request.face = face;
    const auto result = Locator().locate(image, makeCamera(kPinhole), request);
    ASSERT_EQ(result.detections.size(), 1u);
    EXPECT_TRUE(result.withheld.empty());
    answers.push_back(result.detections[0]);
  }
  EXPECT_EQ(answers[0].face, Face::kFront);
  EXPECT_EQ(answers[1].face, Face::kBack);
  EXPECT_EQ(faceOf(answers[0].T_camera_part), Face::kFront);
  EXPECT_EQ(faceOf(answers[1].T_camera_part), Face::kBack);
  // Its axis of symmetry stays where it is.
  const Eigen::Vector3d hole(-0.05, 0.0, 0.0);
  EXPECT_LT((answers[0].T_camera_part * hole - answers[1].T_camera_part * hole).norm(), 1e-6);
}

TEST(LocateRequest, OnlyWhatLiesWithinTheDistancesIsAnswered) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  sim::Scene scene;
  for (int i = 0; i < 4; ++i) {
    scene.plates.push_back({bracketPlate(), sim::poseOf({90.0 * (i % 2) - 50, 90.0 * (i / 2) - 40,
                                                         560.0 + 30.0 * i, 70.0 * i})});
  }
  const cv::Mat image = sim::takeImage(kPinhole, scene);
  const auto found = [&](double min, double max) {
    LocateRequest request = requestFor(parts);
    request.distance_min = min;
    request.distance_max = max;
    const auto result = Locator().locate(image, makeCamera(kPinhole), request);
    for (const Detection& d : result.detections) {
      EXPECT_GT(d.T_camera_part.translation().z(), min - 0.004);
      EXPECT_LT(d.T_camera_part.translation().z(), max + 0.004);
    }
    for (const auto& w : result.withheld) EXPECT_EQ(w.reason, Withheld::kOutside);
    return result.detections.size();
  };
  EXPECT_EQ(found(0.55, 0.66), 4u);
  EXPECT_EQ(found(0.575, 0.63), 2u);
  EXPECT_EQ(found(0.60, 0.61), 0u);
  EXPECT_EQ(found(0.45, 0.52), 0u);
  EXPECT_EQ(found(0.68, 0.80), 0u);
}

TEST(LocateRequest, NothingBeyondTheTiltLimitIsAnswered) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, sceneOf(bracketPlate(), {0, 0, 600, 30, 34, 70}));
  for (const double limit : {40.0, 30.0}) {
    LocatorParams params;
    params.refine.tilt_limit_deg = limit;
    const auto result = Locator(params).locate(image, makeCamera(kPinhole), requestFor(parts));
    EXPECT_EQ(result.detections.size(), limit > 34.0 ? 1u : 0u) << limit;
    EXPECT_TRUE(result.withheld.empty());
    for (const Detection& d : result.detections)
      EXPECT_LT(std::acos(-d.T_camera_part.linear()(2, 2)), (limit + 2.0) * kDegrees);
  }
}

}  // namespace
}  // namespace planar_bin_picking
