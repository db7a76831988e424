// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/polygon.h"

#include "base/box_tree.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace planar_bin_picking {
namespace {

TEST(BoxTree, FindsWhatAPlainSearchFinds) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(0.0, 10.0), size(0.0, 1.5);
  const auto box = [&] {
    const Eigen::Vector2d low(place(random), place(random));
    return Eigen::AlignedBox2d(low, low + Eigen::Vector2d(size(random), size(random)));
  };
  for (const int n : {0, 1, 4, 5, 9, 17, 100, 333}) {
    std::vector<Eigen::AlignedBox2d> boxes;
    for (int i = 0; i < n; ++i) boxes.push_back(box());
    const BoxTree tree(boxes);
    for (int query = 0; query < 50; ++query) {
      const Eigen::AlignedBox2d asked = box();
      std::multiset<std::size_t> found, expected;
      EXPECT_FALSE(tree.any(asked, [&](std::size_t i) {
        found.insert(i);
        return false;
      }));
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        if (boxes[i].intersects(asked)) expected.insert(i);
      }
      EXPECT_EQ(found, expected);
      int visits = 0;
      EXPECT_EQ(tree.any(asked, [&](std::size_t) { return ++visits == 1; }), !expected.empty());
      EXPECT_EQ(visits, expected.empty() ? 0 : 1);
    }
  }
}

TEST(BoxTree, BearsEqualBoxes) {
  const std::vector<Eigen::AlignedBox2d> boxes(
      1000, Eigen::AlignedBox2d(Eigen::Vector2d(1, 1), Eigen::Vector2d(2, 2)));
  int visits = 0;
  BoxTree(boxes).any(boxes[0], [&](std::size_t) { return ++visits < 0; });
  EXPECT_EQ(visits, 1000);
}

TEST(Polygon, CrossingsAreFound) {
  const Polygon square = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  const auto moved = [&](double x, double y) {
    Polygon other = square;
    for (Eigen::Vector2d& p : other) p += Eigen::Vector2d(x, y);
    return other;
  };
  EXPECT_FALSE(findCrossing({square}, 1e-4));
  EXPECT_FALSE(findCrossing({square, moved(10.001, 0), moved(0, -11)}, 1e-4));
  EXPECT_TRUE(findCrossing({square, moved(10.001, 0)}, 0.01));
  const auto crossing = findCrossing({moved(50, 0), square, moved(4, 5)}, 1e-4);
  ASSERT_TRUE(crossing);
  EXPECT_EQ(crossing->first, 1u);
  EXPECT_EQ(crossing->second, 2u);
  const bool right = (crossing->point - Eigen::Vector2d(10, 5)).norm() < 1e-9;
  const bool top = (crossing->point - Eigen::Vector2d(4, 10)).norm() < 1e-9;
  EXPECT_TRUE(right || top) << crossing->point.transpose();
  const auto own = findCrossing({{{0, 0}, {10, 10}, {10, 0}, {0, 10}}}, 1e-4);
  ASSERT_TRUE(own);
  EXPECT_EQ(own->first, own->second);
  EXPECT_LT((own->point - Eigen::Vector2d(5, 5)).norm(), 1e-9);
  EXPECT_TRUE(findCrossing({{{0, 0}, {10, 0}, {10, 9}, {10, -3}}}, 1e-4));  // runs back
}

TEST(Polygon, MeasuresAreExactFarAway) {
  const Eigen::Vector2d far(1e7, -5e6);
  Polygon polygon = {{0, 0}, {4, 0}, {4, 2}, {0, 2}};
  for (Eigen::Vector2d& p : polygon) p += far;
  EXPECT_DOUBLE_EQ(signedArea(polygon), 8.0);
  EXPECT_LT((signedMoment(polygon) / 8.0 - far - Eigen::Vector2d(2, 1)).norm(), 1e-8);
  EXPECT_TRUE(contains(polygon, far + Eigen::Vector2d(3.9, 0.1)));
  EXPECT_FALSE(contains(polygon, far + Eigen::Vector2d(4.1, 0.1)));
  EXPECT_DOUBLE_EQ(distanceToSegment({3, 4}, {0, 0}, {0, 0}), 5.0);
  EXPECT_DOUBLE_EQ(distanceToSegment({3, 4}, {0, 0}, {2, 0}), std::hypot(1, 4));
}

}  // namespace
}  // namespace planar_bin_picking
