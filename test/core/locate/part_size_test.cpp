// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/part_size.h"

#include "planar_bin_picking/locate/locator.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace planar_bin_picking {
namespace {

constexpr double kMillimetresPerInch = 25.4;

sim::Plate scaled(sim::Plate plate, double by) {
  for (auto& p : plate.outer) p *= by;
  for (auto* rings : {&plate.holes, &plate.prints})
    for (auto& ring : *rings)
      for (auto& p : ring) p *= by;
  return plate;
}

sim::Plate bar(double length_mm, double width_mm, double turn_deg = 0.0) {
  sim::Plate plate;
  for (const auto& p :
       rectangle(-0.5 * length_mm, -0.5 * width_mm, 0.5 * length_mm, 0.5 * width_mm))
    plate.outer.push_back(Eigen::Rotation2Dd(turn_deg * kDegrees) * p);
  return plate;
}

/// Whether checkPartSize refuses the plate; at 1.7 m a pixel of the pinhole is a millimetre.
testing::AssertionResult refusedAt(const sim::Plate& plate, double distance_min,
                                   double distance_max, const std::vector<std::string>& words) {
  const auto part = makePart("plate", plate);
  const Camera camera = makeCamera(kPinhole);
  return refuses([&] { checkPartSize(*part, camera, distance_min, distance_max); }, words);
}

TEST(PartSize, RefusesADrawingInInchesReadAsMillimetres) {
  const sim::Plate small = scaled(bracketPlate(), 1.0 / kMillimetresPerInch);
  EXPECT_TRUE(refusedAt(small, 0.55, 0.65,
                        {"plate", "3.15 x 1.969 mm", "10 x 6 pixels", "0.55 .. 0.65 m", "too small",
                         "56 x 8 pixels", "units: inch"}));
  const sim::Plate large = scaled(bracketPlate(), kMillimetresPerInch);
  EXPECT_TRUE(refusedAt(large, 0.55, 0.65,
                        {"plate", "2032 x 1270 mm", "5305 x 3316 pixels", "does not fit",
                         "1200 x 1000", "units: inch"}));
  EXPECT_FALSE(refusedAt(bracketPlate(), 0.55, 0.65, {}));
}

TEST(PartSize, LengthAndWidthAreBothNeeded) {
  const double at = 1e-3 * kPinhole.fy;
  EXPECT_TRUE(refusedAt(bar(55.8, 30), at, at, {"too small", "56 x 30 pixels"}));
  EXPECT_FALSE(refusedAt(bar(56.2, 30), at, at, {}));
  EXPECT_TRUE(refusedAt(bar(200, 7.8), at, at, {"too small", "200 x 8 pixels"}));
  EXPECT_FALSE(refusedAt(bar(200, 8.2), at, at, {}));
}

TEST(PartSize, APartThatIsLargeEnoughSomewhereInTheRangeIsNotRefused) {
  const double at = 1e-3 * kPinhole.fy;
  EXPECT_FALSE(refusedAt(bar(60, 30), at, 3.0 * at, {}));
  EXPECT_FALSE(refusedAt(bar(2000, 30), 0.3 * at, 2.0 * at, {}));
}

TEST(PartSize, ATenthMayStickOutOfTheView) {
  const double at = 1e-3 * kPinhole.fy;
  // Along the diagonal of 1200 x 1000 pixels, and a little beyond it; the lens sees a little more.
  EXPECT_FALSE(refusedAt(bar(1560, 30), at, at, {}));
  EXPECT_TRUE(refusedAt(bar(1850, 30), at, at, {"does not fit"}));
  EXPECT_FALSE(refusedAt(bar(1250, 1050), at, at, {}));
  EXPECT_TRUE(refusedAt(bar(1200, 1200), at, at, {"does not fit"}));
}

TEST(PartSize, ChecksTheDistancesFirst) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refusedAt(bracketPlate(), nan, 0.65, {"distances"}));
  EXPECT_TRUE(refusedAt(bracketPlate(), 1e-12, 1e-11, {"distances", "1e-12"}));
}

TEST(Distances, RangeAndRatioHaveLimits) {
  const auto refused = [](double min, double max, const std::vector<std::string>& words) {
    return refuses([&] { checkDistances(min, max); }, words);
  };
  EXPECT_FALSE(refused(0.01, 0.1, {}));
  EXPECT_FALSE(refused(10.0, 100.0, {}));
  EXPECT_FALSE(refused(0.6, 0.6, {}));
  EXPECT_TRUE(refused(0.009, 0.05, {"0.01 <= min"}));
  EXPECT_TRUE(refused(50.0, 101.0, {"max <= 100"}));
  EXPECT_TRUE(refused(0.6, 0.5999, {"min <= max"}));
  EXPECT_TRUE(refused(0.1, 1.001, {"max <= 10 min"}));
  const double infinity = std::numeric_limits<double>::infinity();
  for (const auto& [min, max] : {std::pair{1e-12, 1e-11},
                                 {1e-300, 1.0},
                                 {0.3, 1e300},
                                 {1e-5, 1.0},
                                 {0.3, infinity},
                                 {-infinity, 1.0},
                                 {0.0, 1.0},
                                 {-1.0, 1.0},
                                 {std::numeric_limits<double>::quiet_NaN(), 1.0},
                                 {0.3, std::numeric_limits<double>::quiet_NaN()}}) {
    EXPECT_TRUE(refused(min, max, {"distances"})) << min << " " << max;
  }
}

TEST(Distances, LocateRefusesThemBeforeItAllocates) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, {});
  for (const auto& [min, max] :
       {std::pair{1e-12, 1e-11}, {1e-300, 1.0}, {0.3, 1e300}, {1e-5, 1.0}}) {
    LocateRequest request;
    request.parts = parts;
    request.distance_min = min;
    request.distance_max = max;
    EXPECT_TRUE(
        refuses([&] { Locator().locate(image, makeCamera(kPinhole), request); }, {"distances"}));
  }
}

/// In the wrong unit it would be found all over the picture.
TEST(PartSize, LocateRefusesAPartOfTooFewPixels) {
  const sim::Plate small = scaled(bracketPlate(), 1.0 / kMillimetresPerInch);
  LocateRequest request;
  request.parts = {makePart("bracket", bracketPlate()), makePart("small", small)};
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  const cv::Mat image = sim::takeImage(kPinhole, sceneOf(bracketPlate(), {0, 0, 600}));
  EXPECT_THROW(Locator().locate(image, makeCamera(kPinhole), request), PartSizeError);
}

/// Twelve brackets of 62 pixels.
TEST(PartSize, SmallPartsAreLocated) {
  const sim::Plate plate = scaled(bracketPlate(), 62.0 / 80.0);
  sim::Scene scene;
  for (int i = 0; i < 12; ++i) {
    scene.plates.push_back({plate, sim::poseOf({150.0 * (i % 4) - 225, 150.0 * (i / 4) - 150, 1700,
                                                37.0 * i, 4.0 * (i % 3), 50.0 * i, i % 2 == 0})});
  }
  LocateRequest request;
  request.parts = {makePart("small", plate)};
  request.distance_min = 1.6;
  request.distance_max = 1.8;
  const auto found =
      Locator().locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), request).detections;
  EXPECT_GE(found.size(), 11u);  // at 70 pixels all of them
  for (const Detection& d : found) EXPECT_EQ(d.face, faceOf(d.T_camera_part));
}

// How near two of them can lie side by side: a bar's width, the radius of a part that is none.
}  // namespace
}  // namespace planar_bin_picking
