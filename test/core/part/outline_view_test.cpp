// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part/outline_view.h"

#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

sim::Plate perforated(int holes_each_way) {
  sim::Plate plate;
  plate.outer = rectangle(-55, -55, 55, 55);
  for (int i = 0; i < holes_each_way; ++i)
    for (int k = 0; k < holes_each_way; ++k)
      plate.holes.push_back(circle(-45 + 10 * i, -45 + 10 * k, 3, true));
  return plate;
}

int countOuter(const PartModel& part, const std::vector<int>& indices) {
  return static_cast<int>(std::count_if(indices.begin(), indices.end(), [&](int index) {
    return part.outline()[index].kind == LoopKind::kOuter;
  }));
}

TEST(OutlineView, HalfOfTheShapesPointsLieOnTheOuterContour) {
  const auto part = makePart("perforated", perforated(10));
  const auto indices = shapeIndices(*part, 80);
  EXPECT_EQ(indices.size(), 80u);
  EXPECT_EQ(countOuter(*part, indices), 40);
  EXPECT_TRUE(std::is_sorted(indices.begin(), indices.end()));
  EXPECT_EQ(std::adjacent_find(indices.begin(), indices.end()), indices.end());
}

TEST(OutlineView, WhereThatHasMoreThePointsGoByLength) {
  const auto part = makePart("perforated", perforated(2));
  double outer = 0.0, all = 0.0;
  for (const Loop& loop : part->file().drawing.loops) {
    all += lengthOf(loop);
    if (loop.kind == LoopKind::kOuter) outer += lengthOf(loop);
  }
  EXPECT_NEAR(countOuter(*part, shapeIndices(*part, 80)), 80 * outer / all, 2.0);
}

TEST(OutlineView, PrintsAreNoShape) {
  const auto part = makePart("printed", printedPlate());
  for (const int index : shapeIndices(*part, 100))
    EXPECT_NE(part->outline()[index].kind, LoopKind::kPrint);
}

TEST(OutlineView, NoMorePointsThanThereAre) {
  const auto part = makePart("perforated", perforated(10));
  const auto indices = shapeIndices(*part, 1000000);
  EXPECT_EQ(indices.size(), part->outline().size());
}

}  // namespace
}  // namespace planar_bin_picking
