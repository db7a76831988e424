// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/locator.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

namespace planar_bin_picking {
namespace {

/// A disc on whose rim a turn hides: seven holes on a circle for eight places.
sim::Plate flangePlate() {
  sim::Plate plate{circle(0, 0, 32), {circle(0, 0, 12, true)}, {}, 0.0};
  for (int k = 0; k < 7; ++k) {
    const double a = 45.0 * k * kDegrees;
    plate.holes.push_back(circle(24 * std::cos(a), 24 * std::sin(a), 2, true));
  }
  return plate;
}

/// Processor time of the call that takes the least of three, on one thread.
double secondsFor(const sim::Plate& plate, const cv::Mat& image) {
  const Parts parts = {makePart("plate", plate)};
  LocatorParams params;
  params.threads = 1;
  const Locator locator(params);
  LocateRequest request;
  request.parts = parts;
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  const Camera camera = makeCamera(kPinhole);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const std::clock_t start = std::clock();
    locator.locate(image, camera, request);
    least = std::min(least, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  return least;
}

/// What is searched besides for some outlines (slides, near-symmetries, narrow webs) stays within
/// bounds of a plain part's search: a robot waits.
TEST(LocatorCost, NoOutlineTakesManyTimesAsLong) {
  sim::Scene scene;
  scene.plates.push_back({bracketPlate(), sim::poseOf({-110, -80, 600, 20, 8, 30})});
  scene.plates.push_back({bracketPlate(), sim::poseOf({100, -70, 590, 120, 12, 100, false})});
  scene.plates.push_back({wheelPlate(15, true), sim::poseOf({-70, 80, 610, 3, 6})});
  scene.plates.push_back({slenderPlate(), sim::poseOf({90, 90, 620, 40})});
  for (const auto& [x, y] : {std::pair{-30, -60}, {10, 20}, {-120, 10}, {20, 110}, {120, 20}})
    scene.plates.push_back({flangePlate(), sim::poseOf({1.0 * x, 1.0 * y, 600, 10.0 * x})});
  const cv::Mat image = sim::takeImage(kPinhole, scene);
  const double plain = secondsFor(bracketPlate(), image);
  for (const auto& plate : {flangePlate(), slenderPlate(), wheelPlate(15, true), printedPlate()})
    EXPECT_LT(secondsFor(plate, image), 6.0 * plain);
}

}  // namespace
}  // namespace planar_bin_picking
