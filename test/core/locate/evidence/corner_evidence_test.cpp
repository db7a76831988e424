// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/corner_evidence.h"

#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 600, 35, 6};

sim::Plate plateOf(const sim::Ring& outer) {
  sim::Plate plate;
  plate.outer = outer;
  return plate;
}

/// What is seen of `lying` where `sought` is thought to lie.
std::optional<double> beyond(const sim::Plate& sought, const sim::Plate& lying,
                             double offset_mm = 0.0) {
  const auto part = makePart("part", sought);
  sim::Scene scene;
  scene.plates.push_back({lying, sim::poseOf(kLie)});
  const Shot shot = shoot(scene);
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*part, Face::kFront);
  const PosedPart posed{solidOf(*part, Face::kFront), T, 1e-3 * offset_mm / part->radius(),
                        part->radius() * kPinhole.fx / T.translation().z()};
  return edgesBeyondCorners(shot.edges, shot.camera, sideEndsOf(*part), posed, 1.5);
}

TEST(CornerEvidence, TheEdgesOfAPartEndAtItsCorners) {
  const sim::Plate plate = plateOf(rectangle(-40, -12, 40, 12));
  const auto seen = beyond(plate, plate);
  ASSERT_TRUE(seen);
  EXPECT_LT(*seen, 0.1);
}

TEST(CornerEvidence, ThoseOfSomethingLongerGoOn) {
  const auto seen =
      beyond(plateOf(rectangle(-40, -12, 40, 12)), plateOf(rectangle(-70, -12, 70, 12)));
  ASSERT_TRUE(seen);
  EXPECT_GT(*seen, 0.8);  // the short sides are not seen and do not count
}

/// One side lies on the rim of something large.
TEST(CornerEvidence, OneSideIsWeighedByHowWellItIsSeen) {
  const sim::Plate corner = plateOf(rectangle(-40, -12, 140, 112));
  const auto seen = beyond(plateOf(rectangle(-40, -12, 40, 12)), corner);
  ASSERT_TRUE(seen);
  EXPECT_GT(*seen, 0.4);  // of two sides with two ends each, one goes on at both ends ...
  EXPECT_LT(*seen, 0.6);  // ... of which one is the corner itself
}

TEST(CornerEvidence, AnEdgeOffsetMovesWhatIsLookedAt) {
  const sim::Plate sought = plateOf(rectangle(-41.2, -13.2, 41.2, 13.2));
  const sim::Plate lying = plateOf(rectangle(-70, -12, 70, 12));
  EXPECT_GT(beyond(sought, lying, 1.2).value_or(0.0), 0.8);
  EXPECT_LT(beyond(sought, lying, -1.2).value_or(0.0), 0.4);
}

TEST(CornerEvidence, ARoundContourHasNoSideThatEnds) {
  EXPECT_TRUE(sideEndsOf(*makePart("disc", plateOf(circle(0, 0, 30)))).empty());
  EXPECT_FALSE(beyond(plateOf(circle(0, 0, 30)), plateOf(circle(0, 0, 30))));
}

/// Where the contour turns into a notch, the line beyond the corner lies on the part.
TEST(CornerEvidence, NothingOfThePartLiesBeyond) {
  const sim::Plate notched =
      plateOf({{-40, -20}, {40, -20}, {40, 20}, {10, 20}, {10, 0}, {-10, 0}, {-10, 20}, {-40, 20}});
  const auto part = makePart("notched", notched);
  const auto ends = sideEndsOf(*part);
  ASSERT_EQ(ends.size(), 16u);
  int on_part = 0;
  for (const SideEnd& end : ends) {
    on_part += end.beyond.empty();
    ASSERT_EQ(end.beyond.size(), end.from_contour.size());
    EXPECT_FALSE(end.side.empty());
  }
  EXPECT_EQ(on_part, 4);  // both ends of the notch's bottom, one of each of its sides
  const auto seen = beyond(notched, notched);
  ASSERT_TRUE(seen);
  EXPECT_LT(*seen, 0.3);  // the outer two of the upper edges go on at each other
}

/// Edge-on, a radius has no pixels.
TEST(CornerEvidence, NothingIsSaidOfAPoseSeenEdgeOn) {
  const auto part = makePart("part", plateOf(rectangle(-40, -12, 40, 12)));
  const Shot shot = shoot(sceneOf(plateOf(rectangle(-40, -12, 40, 12)), kLie));
  for (const double px : {0.0, 1e-9, 0.5}) {
    const PosedPart posed{solidOf(*part, Face::kFront), sim::poseOf(kLie), 0.0, px};
    EXPECT_FALSE(edgesBeyondCorners(shot.edges, shot.camera, sideEndsOf(*part), posed, 1.5)) << px;
  }
}

TEST(CornerEvidence, NothingIsSaidWhereNothingIsSeen) {
  EXPECT_FALSE(beyond(plateOf(rectangle(-40, -12, 40, 12)), plateOf(circle(300, 300, 5))));
}

}  // namespace
}  // namespace planar_bin_picking
