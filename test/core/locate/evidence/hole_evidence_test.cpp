// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/hole_evidence.h"

#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 600, 35, 6};
constexpr double kWidthPx = 30.0;

sim::Plate withHole(const sim::Ring& hole) {
  return {bracketPlate().outer, {hole, bracketPlate().holes[1]}, {}, 0.0};
}

/// The drawing has a hole of 6 mm radius at (-18, 6); the plate in the picture has `hole` instead.
HoleEvidence seen(const sim::Plate& plate, double width_px = kWidthPx) {
  const auto part = makePart("bracket", bracketPlate());
  const Shot shot = shoot(sceneOf(plate, kLie));
  const auto points = localPoints(*part, 48, [](const OutlinePoint& p) { return p.loop == 1; });
  return holeEvidence(shot.edges, shot.camera, points, solidOf(*part, Face::kFront),
                      sim::poseOf(kLie) * centreOf(*part, Face::kFront), width_px);
}

TEST(HoleEvidence, AHoleInItsPlaceIsSeenThere) {
  const auto evidence = seen(bracketPlate());
  EXPECT_GT(evidence.here, 0.9);
  EXPECT_EQ(evidence.elsewhere, 0.0);
}

TEST(HoleEvidence, AHoleOfAnotherSizeIsSeenAsThat) {
  for (const double radius_mm : {4.5, 7.5}) {
    const auto evidence = seen(withHole(circle(-18, 6, radius_mm, true)));
    EXPECT_LT(evidence.here, 0.3) << radius_mm;
    EXPECT_GT(evidence.elsewhere, 0.8) << radius_mm;
  }
}

TEST(HoleEvidence, AMovedHoleIsFoundInAnyDirection) {
  for (int k = 0; k < 6; ++k) {
    const double angle = 60.0 * kDegrees * k;
    const auto evidence =
        seen(withHole(circle(-18 + 3.5 * std::cos(angle), 6 + 3.5 * std::sin(angle), 6, true)));
    EXPECT_LT(evidence.here, 0.4) << k;
    EXPECT_GT(evidence.elsewhere, 0.8) << k;
  }
}

TEST(HoleEvidence, WithoutAHoleNothingIsSeenElsewhere) {
  sim::Plate plate = bracketPlate();
  plate.holes.erase(plate.holes.begin());
  const auto evidence = seen(plate);
  EXPECT_LT(evidence.here, 0.1);
  EXPECT_LT(evidence.elsewhere, 0.3);
}

TEST(HoleEvidence, OfAHoleTooSmallNothingElseIsSought) {
  EXPECT_EQ(seen(withHole(circle(-18, 6, 4.5, true)), 8.0).elsewhere, 0.0);
}

}  // namespace
}  // namespace planar_bin_picking
