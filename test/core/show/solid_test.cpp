// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/show/solid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// 80 x 40 mm with a square hole of 10 mm, a round one of 10 mm and a print, far from its origin.
PartModel plate(const double thickness) {
  const Eigen::Vector2d off(1000.0, -2000.0);
  PartFile file;
  file.name = "plate";
  file.thickness = thickness;
  Loop outer{LoopKind::kOuter, true, {{-0.04, -0.02}, {0.04, -0.02}, {0.04, 0.02}, {-0.04, 0.02}}};
  Loop square{LoopKind::kHole, true, {{0.0, 0.0}, {0.0, 0.01}, {0.01, 0.01}, {0.01, 0.0}}};
  Loop round{LoopKind::kHole, true, {}};
  for (int i = 0; i < 720; ++i) {
    const double a = -2.0 * M_PI * i / 720;
    round.points.emplace_back(-0.02 + 0.005 * std::cos(a), 0.005 * std::sin(a));
  }
  Loop print{LoopKind::kPrint, false, {{-0.03, 0.015}, {-0.01, 0.015}}};
  for (Loop* loop : {&outer, &square, &round, &print}) {
    for (auto& p : loop->points) p += off;
    file.drawing.loops.push_back(*loop);
  }
  return PartModel(file);
}

/// Sum over the triangles: their areas as vectors, and the volume about a point.
struct Sums {
  double front = 0.0, volume = 0.0;
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
};

Sums sumsOf(const std::vector<Eigen::Vector3d>& corners, const Eigen::Vector3d& about) {
  Sums sums;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    const Eigen::Vector3d a = corners[i] - about, b = corners[i + 1] - about,
                          c = corners[i + 2] - about;
    const Eigen::Vector3d area = 0.5 * (b - a).cross(c - a);
    sums.area += area;
    sums.volume += a.dot(area) / 3.0;
    if (area.z() > 1e-12) sums.front += area.z();
  }
  return sums;
}

constexpr double kArea = 0.08 * 0.04 - 0.01 * 0.01 - M_PI * 0.005 * 0.005;

TEST(Solid, IsClosedAndHasTheVolumeOfThePart) {
  const PartModel part = plate(0.005);
  const auto corners = solidTriangles(part);
  ASSERT_EQ(corners.size() % 3, 0u);
  EXPECT_LT(corners.size(), 3u * 400);
  const Sums sums = sumsOf(corners, {part.center().x(), part.center().y(), -0.0025});
  EXPECT_NEAR(sums.front, kArea, 0.01 * kArea);
  EXPECT_NEAR(sums.volume, 0.005 * sums.front, 1e-4 * 0.005 * kArea);  // all seen from outside
  EXPECT_LT(sums.area.norm(), 1e-4 * kArea);                           // without a gap
}

TEST(Solid, OfUnknownThicknessIsItsFace) {
  const PartModel part = plate(0.0);
  const Sums sums = sumsOf(solidTriangles(part), {part.center().x(), part.center().y(), 0.0});
  EXPECT_NEAR(sums.area.z(), kArea, 0.01 * kArea);
}

}  // namespace
}  // namespace planar_bin_picking
