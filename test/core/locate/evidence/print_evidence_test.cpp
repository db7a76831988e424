// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/print_evidence.h"

#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{15, -10, 600, 25, 5};

double inlierScore(const sim::Plate& drawn, const PartModel& part, double turn_deg,
                   double print_grey) {
  sim::Scene scene = sceneOf(drawn, kLie);
  scene.plates[0].print_grey = print_grey;
  const Shot shot = shoot(scene);
  const auto points =
      localPoints(part, 200, [](const OutlinePoint& p) { return p.kind == LoopKind::kPrint; });
  const auto T = candidateNear(sim::poseOf(kLie), 0.0, turn_deg).T_camera_part;
  return printScore(shot.edges, shot.camera, points, part.radius(),
                    T * centreOf(part, Face::kFront));
}

/// The printed plate with a line of this width along its print in place of the filled area.
sim::Plate stroked(double width_mm) {
  sim::Plate plate = printedPlate();
  const double h = 0.5 * width_mm;
  plate.prints = {
      rectangle(-10 - h, 2 - h, 20 + h, 2 + h), rectangle(-10 - h, 14 - h, 20 + h, 14 + h),
      rectangle(-10 - h, 2 + h, -10 + h, 14 - h), rectangle(20 - h, 2 + h, 20 + h, 14 - h)};
  return plate;
}

TEST(PrintEvidence, BordersOfFilledAreas) {
  const auto part = makePart("printed", printedPlate());
  for (const double grey : {60.0, 230.0}) {
    EXPECT_GT(inlierScore(printedPlate(), *part, 0.0, grey), 0.9) << grey;
    EXPECT_LT(inlierScore(printedPlate(), *part, 90.0, grey), 0.4) << grey;
  }
}

TEST(PrintEvidence, StrokesOfAnyWidth) {
  const auto part = makePart("printed", printedPlate());
  for (const double width_mm : {0.4, 1.0, 2.0}) {
    EXPECT_GT(inlierScore(stroked(width_mm), *part, 0.0, 60.0), 0.85) << width_mm;
    EXPECT_LT(inlierScore(stroked(width_mm), *part, 180.0, 60.0), 0.4) << width_mm;
  }
}

TEST(PrintEvidence, ABlankFaceHasNone) {
  const auto part = makePart("printed", printedPlate());
  sim::Plate blank = printedPlate();
  blank.prints.clear();
  EXPECT_LT(inlierScore(blank, *part, 0.0, 60.0), 0.15);
}

}  // namespace
}  // namespace planar_bin_picking
