// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locator.h"

#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <limits>

namespace planar_bin_picking {
namespace {

LocateRequest requestFor(const Parts& parts) {
  LocateRequest request;
  request.parts = parts;
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  return request;
}

sim::Scene threeKinds() {
  sim::Scene scene;
  scene.plates.push_back({bracketPlate(), sim::poseOf({-110, -80, 600, 20, 8, 30})});
  scene.plates.push_back({bracketPlate(), sim::poseOf({100, -70, 590, 120, 12, 100, false})});
  scene.plates.push_back({wheelPlate(15, true), sim::poseOf({-70, 80, 610, 3, 6})});
  scene.plates.push_back({slenderPlate(), sim::poseOf({90, 90, 620, 40})});
  return scene;
}

TEST(Locator, FindsThePartsAndNoOthers) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const sim::Scene scene = threeKinds();
  const auto result =
      Locator().locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), requestFor(parts));
  ASSERT_EQ(result.detections.size(), 2u);
  for (const Detection& d : result.detections) {
    const auto& truth = scene.plates[d.face == Face::kFront ? 0 : 1].T_camera_part;
    EXPECT_TRUE(isometryNear(d.T_camera_part, truth, 0.6e-3, 0.6 * kDegrees));
    EXPECT_GT(d.score, 0.8);
    EXPECT_GT(d.visible_fraction, 0.95);
  }
}

TEST(Locator, SeveralPartsAreRankedTogether) {
  const Parts parts = {makePart("bracket", bracketPlate()),
                       makePart("wheel", wheelPlate(15, true))};
  const auto result = Locator().locate(sim::takeImage(kPinhole, threeKinds()), makeCamera(kPinhole),
                                       requestFor(parts));
  int brackets = 0, wheels = 0;
  for (const Detection& d : result.detections) {
    (d.part == 0 ? brackets : wheels) += 1;
    EXPECT_EQ(d.part_name, d.part == 0 ? "bracket" : "wheel");
  }
  EXPECT_EQ(brackets, 2);
  EXPECT_EQ(wheels, 1);
}

TEST(Locator, TheReportNamesTheStages) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const auto report =
      Locator()
          .locate(sim::takeImage(kPinhole, threeKinds()), makeCamera(kPinhole), requestFor(parts))
          .report;
  ASSERT_EQ(report.stages.size(), 5u);
  double sum = 0.0;
  const char* const names[] = {"edges", "hough", "refine", "score", "rank"};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(report.stages[i].name, names[i]);
    sum += report.stages[i].seconds;
  }
  EXPECT_NEAR(report.seconds, sum, 1e-9);
  EXPECT_EQ(report.stages[4].out, 2u);
}

TEST(Locator, TheSameAnswerOnAnyNumberOfThreads) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  std::vector<LocateResult> results;
  for (const int threads : {1, 2, 2, 3}) {
    LocatorParams params;
    params.threads = threads;
    results.push_back(Locator(params).locate(image, makeCamera(kPinhole), requestFor(parts)));
  }
  for (const auto& other : results) {
    ASSERT_EQ(other.detections.size(), results[0].detections.size());
    for (std::size_t i = 0; i < other.detections.size(); ++i) {
      EXPECT_EQ(other.detections[i].T_camera_part.matrix(),
                results[0].detections[i].T_camera_part.matrix());
      EXPECT_EQ(other.detections[i].score, results[0].detections[i].score);
    }
  }
}

TEST(Locator, SixteenBitsSayTheSame) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  cv::Mat image = sim::takeImage(kPinhole, threeKinds()), deep;
  image.convertTo(deep, CV_16U, 256.0);
  const Locator locator;
  const auto a = locator.locate(image, makeCamera(kPinhole), requestFor(parts));
  const auto b = locator.locate(deep, makeCamera(kPinhole), requestFor(parts));
  ASSERT_EQ(a.detections.size(), b.detections.size());
  for (std::size_t i = 0; i < a.detections.size(); ++i) {
    EXPECT_TRUE(isometryNear(a.detections[i].T_camera_part, b.detections[i].T_camera_part, 1e-4,
                             0.1 * kDegrees));
  }
}

TEST(Locator, AnEmptyPictureIsAnAnswer) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const Camera camera = makeCamera(kPinhole);
  EXPECT_TRUE(
      Locator().locate(sim::takeImage(kPinhole, {}), camera, requestFor(parts)).detections.empty());
  const cv::Mat flat(kPinhole.height, kPinhole.width, CV_8U, cv::Scalar(90));
  EXPECT_TRUE(Locator().locate(flat, camera, requestFor(parts)).detections.empty());
}

TEST(Locator, RefusesBadInput) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, {});
  const Camera camera = makeCamera(kPinhole);
  const Locator locator;
  const auto with = [&](const cv::Mat& picture, LocateRequest request) {
    return [&locator, &camera, picture, request] { locator.locate(picture, camera, request); };
  };
  EXPECT_TRUE(refuses(with({}, requestFor(parts)), {"image is empty"}));
  EXPECT_TRUE(refuses(with(image(cv::Rect(0, 0, 600, 500)), requestFor(parts)),
                      {"600 x 500", "1200 x 1000"}));
  EXPECT_TRUE(refuses(with(cv::Mat(1000, 1200, CV_8UC3), requestFor(parts)), {"3 channels"}));
  EXPECT_TRUE(refuses(with(image, requestFor({})), {"no part"}));
  LocateRequest far = requestFor(parts);
  far.distance_max = 0.2;
  EXPECT_TRUE(refuses(with(image, far), {"0.55", "0.2"}));
  far.distance_max = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refuses(with(image, far), {"distances"}));
  LocatorParams params;
  params.score.threshold = 2.0;
  EXPECT_TRUE(refuses([&] { Locator{params}; }, {"score/threshold"}));
}

}  // namespace
}  // namespace planar_bin_picking
