// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/vote/raster_points.h"

#include "support/plates.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// Also where their number is no multiple of the lanes, and left of and above the centre.
TEST(RasterPoints, LieWhereTheViewHasThem) {
  const auto part = makePart("bracket", bracketPlate());
  Field field;
  field.width = 300;
  field.height = 200;
  const VotePlanes planes = sizePlanes(field, 1.5, 60.0);
  for (const int count : {16, 53, 80}) {
    const RasterPoints points(*part, count);
    ASSERT_LE(points.count, count);
    ASSERT_GT(points.count, count / 2);
    for (const double yaw : {0.0, 0.7, 2.9}) {
      const Eigen::Matrix2d A = 500.0 * Eigen::Rotation2Dd(yaw).toRotationMatrix() *
                                Eigen::Vector2d(1.0, -0.8).asDiagonal();
      const Eigen::Matrix2d to_normal = A.inverse().transpose();
      std::vector<std::int32_t> cells(points.count);
      const auto box = placePoints(points, A, to_normal, planes, cells.data());
      Eigen::AlignedBox2d expected;
      for (int i = 0; i < points.count; ++i) {
        const Eigen::Vector2d q = A * Eigen::Vector2d(points.x[i], points.y[i]);
        const Eigen::Vector2d n = to_normal * Eigen::Vector2d(points.nx[i], points.ny[i]);
        expected.extend(q);
        const int hx = static_cast<int>(std::floor(q.x() + 0.5));
        const int hy = static_cast<int>(std::floor(q.y() + 0.5));
        EXPECT_EQ(static_cast<std::size_t>(cells[i]),
                  planes.offset(directionBin(n.x(), n.y()), hx, hy))
            << i;
      }
      EXPECT_LT(expected.min().maxCoeff(), -5.0);
      EXPECT_TRUE(box.min().isApprox(expected.min(), 1e-12));
      EXPECT_TRUE(box.max().isApprox(expected.max(), 1e-12));
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
