// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/heap.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

Shape plate(double length, double width, double thickness) {
  const double x = 0.5 * length, y = 0.5 * width;
  return {{{-x, -y}, {x, -y}, {x, y}, {-x, y}}, {}, thickness};
}

Eigen::Isometry3d at(double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  return T;
}

TEST(Heap, APlateFallsAndLiesFlat) {
  Heap heap(Bin{}, {plate(0.08, 0.06, 0.004)}, 1);
  const int id = heap.put(0, at(0.0, 0.0, 0.05));
  EXPECT_TRUE(heap.settle(4.0));
  const Body body = heap.bodies().at(0);
  EXPECT_EQ(body.id, id);
  // The part's frame is on its front face. Contacts keep a tenth of a millimetre.
  EXPECT_NEAR(body.T_base_part.translation().z(), 0.004, 2e-4);
  EXPECT_GT(body.T_base_part.linear()(2, 2), 0.99999);
}

TEST(Heap, KnowsWhatLiesOnAPart) {
  Heap heap(Bin{}, {plate(0.08, 0.06, 0.004)}, 1);
  const int lower = heap.put(0, at(0.0, 0.0, 0.0045)), upper = heap.put(0, at(0.005, 0.0, 0.0095));
  EXPECT_TRUE(heap.settle(4.0));
  EXPECT_NEAR(heap.load(lower), 1.0, 0.1);
  EXPECT_NEAR(heap.load(upper), 0.0, 1e-9);
  heap.remove(upper);
  EXPECT_NEAR(heap.load(lower), 0.0, 1e-9);
  EXPECT_THROW(heap.remove(upper), std::out_of_range);
}

TEST(Heap, WhatLeansOnTheRimIsNoLoad) {
  const auto loadUnderOverhang = [](double overlap) {
    Heap heap(Bin{}, {plate(0.08, 0.06, 0.004)}, 1);
    const int lower = heap.put(0, at(0.0, 0.0, 0.0041));
    // One side on the lower plate, the other on the floor.
    const double lean = 0.004 / 0.08;
    Eigen::Isometry3d T = at(0.08 - overlap, 0.0, 0.0063);
    T.linear() = Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitY()).toRotationMatrix();
    heap.put(0, T);
    EXPECT_TRUE(heap.settle(4.0));
    return heap.load(lower);
  };
  EXPECT_NEAR(loadUnderOverhang(0.010), 0.5, 0.15);
  EXPECT_EQ(loadUnderOverhang(0.0002), 0.0);
}

TEST(Heap, WhatRestsOnABridgedNotchIsNoLoad) {
  // A notch of less than a hundredth of the area is bridged by the collision shape's pieces.
  Shape notched = plate(0.08, 0.06, 0.004);
  notched.outer = {{-0.04, -0.03}, {0.04, -0.03},  {0.04, 0.03},   {0.002, 0.03},
                   {0.002, 0.02},  {-0.002, 0.02}, {-0.002, 0.03}, {-0.04, 0.03}};
  const auto loadUnderPin = [&](double y) {
    Heap heap(Bin{}, {notched, plate(0.002, 0.006, 0.02)}, 1);
    const int lower = heap.put(0, at(0.0, 0.0, 0.0041));
    heap.put(1, at(0.0, y, 0.0243));
    EXPECT_TRUE(heap.settle(4.0));
    EXPECT_NEAR(heap.bodies().at(1).T_base_part.translation().z(), 0.024, 5e-4);
    return heap.load(lower);
  };
  EXPECT_GT(loadUnderPin(0.0), 0.005);
  EXPECT_EQ(loadUnderPin(0.025), 0.0);
}

TEST(Heap, SinksWhenItsLowestIsTakenOut) {
  Heap heap(Bin{}, {plate(0.08, 0.06, 0.004)}, 1);
  const int lower = heap.put(0, at(0.0, 0.0, 0.0045));
  heap.put(0, at(0.0, 0.0, 0.0095));
  heap.settle(4.0);
  heap.remove(lower);
  EXPECT_NEAR(heap.bodies().at(0).T_base_part.translation().z(), 0.004, 3e-4);
}

TEST(Heap, APouredHeapRestsInTheBin) {
  const Bin bin;
  const Shape shape =
      loadShape(std::string(PACKAGE_DIR) + "/test/data/parts/bracket.dxf", 0.003, 3e-4);
  Heap heap(bin, {shape}, 3);
  heap.pour(0, 12);
  ASSERT_EQ(heap.bodies().size(), 12u);
  EXPECT_LT(heap.deepestPenetration(), 3e-4);
  for (const Body& body : heap.bodies()) {
    const Eigen::Vector3d center = body.T_base_part * Eigen::Vector3d(0.045, 0.028, -0.0015);
    EXPECT_LT(std::abs(center.x()), 0.5 * bin.length);
    EXPECT_LT(std::abs(center.y()), 0.5 * bin.width);
    EXPECT_GT(center.z(), 0.0);
    EXPECT_LT(center.z(), 0.12);
  }
  const auto before = heap.bodies();
  heap.settle(1.0);
  const auto after = heap.bodies();
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_LT((before[i].T_base_part.translation() - after[i].T_base_part.translation()).norm(),
              2e-4);
}

TEST(Heap, IsTheSameForTheSameSeed) {
  const auto pour = [](std::uint64_t seed) {
    Heap heap(Bin{}, {plate(0.08, 0.06, 0.004), plate(0.05, 0.05, 0.01)}, seed);
    heap.pour(0, 5);
    heap.pour(1, 4);
    heap.remove(3);
    heap.push(2, heap.bodies().at(1).T_base_part.translation(), {0.2, 0.0, 0.1});
    return heap.bodies();
  };
  const auto first = pour(5), again = pour(5), other = pour(6);
  ASSERT_EQ(first.size(), 8u);
  double difference = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].T_base_part.matrix(), again[i].T_base_part.matrix());
    difference += (first[i].T_base_part.translation() - other[i].T_base_part.translation()).norm();
  }
  EXPECT_GT(difference, 0.01);
}

}  // namespace
}  // namespace planar_bin_picking::cell
