// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/flat_face.h"

#include "base/polygon.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <numeric>

namespace planar_bin_picking {
namespace {

constexpr std::uint8_t kDark = 90, kBright = 150;

/// Flattened faces are drawn as they would be seen: a bright bracket on a dark ground.
class ForeignEdges : public testing::Test {
 protected:
  ForeignEdges() : flat_(grid().fromOutline().size(), kDark) {
    for (int y = 0; y < flat_.rows; ++y)
      for (int x = 0; x < flat_.cols; ++x)
        if (isMaterial(x + 0.5, y + 0.5)) flat_(y, x) = kBright;
  }
  bool isMaterial(double x, double y) const {
    const double scale = grid().cellSize() / FaceGrid::kSamples;
    const Eigen::Vector2d at = grid().corner(0, 0) + scale * Eigen::Vector2d(x, y);
    int inside = 0;  // of how many loops: 1 is the outer contour alone
    for (const Loop& loop : part_->file().drawing.loops) inside += contains(loop.points, at);
    return inside == 1;
  }
  const FaceGrid& grid() const { return part_->faceGrid(); }
  double share(const std::vector<int>& covered = {}) const {
    return foreignEdges(grid(), FlatFace(flat_), covered);
  }
  /// Upright stripes on the face, `width` samples wide and as far apart.
  void stripe(int width, std::uint8_t grey) {
    for (int x = 0; x < flat_.cols; ++x)
      if (x / width % 2 == 0) flat_.col(x).setTo(grey, flat_.col(x) == kBright);
  }
  std::shared_ptr<const PartModel> part_ = makePart("bracket", bracketPlate());
  cv::Mat_<std::uint8_t> flat_;
};

TEST_F(ForeignEdges, ASmoothFaceHasNone) { EXPECT_EQ(share(), 0.0); }

TEST_F(ForeignEdges, StripesAsClearAsTheOutlineCount) {
  stripe(8, kDark);  // each of its edges is two samples wide
  EXPECT_NEAR(share(), 0.25, 0.06);
}

TEST_F(ForeignEdges, FaintStripesDoNot) {
  stripe(8, 140);
  EXPECT_EQ(share(), 0.0);
}

TEST_F(ForeignEdges, WhatIsCoveredDoesNot) {
  stripe(8, kDark);
  std::vector<int> all(grid().cells().size());
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(share(all), 0.0);
  // Half of it covered, the share of the other half is the same.
  const std::vector<int> half(all.begin(), all.begin() + static_cast<long>(all.size() / 2));
  EXPECT_NEAR(share(half), share(), 0.08);
}

}  // namespace
}  // namespace planar_bin_picking
