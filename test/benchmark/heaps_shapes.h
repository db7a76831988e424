// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Parts of many shapes for the benchmark of heaps, none of which anything was tuned to: slender,
/// toothed, perforated, round, without holes, with sides equally far from one point.

#include "support/plates.h"

#include <cmath>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct HeapShape {
  std::string name;
  double thickness_mm;
  int count;              ///< in a heap
  Eigen::Vector2d grasp;  ///< where a cup may go, mm
  sim::Plate plate;       ///< mm
};

namespace shapes {

inline sim::Ring onCircle(double radius, double from_deg, double to_deg, int corners) {
  sim::Ring ring;
  for (int k = 0; k < corners; ++k) {
    const double angle = (from_deg + (to_deg - from_deg) * k / (corners - 1)) * kDegrees;
    ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
  }
  return ring;
}

/// `count` of `of` places for holes on a circle.
inline std::vector<sim::Ring> boltCircle(double at, double radius, int count, int of) {
  std::vector<sim::Ring> holes;
  for (int k = 0; k < count; ++k) {
    const double angle = 360.0 * kDegrees * k / of;
    holes.push_back(circle(at * std::cos(angle), at * std::sin(angle), radius, true));
  }
  return holes;
}

inline sim::Plate flange() {
  sim::Plate plate{circle(0, 0, 35), boltCircle(27, 2.5, 7, 8), {}, 0.0};
  plate.holes.push_back(circle(0, 0, 10, true));
  return plate;
}

inline sim::Plate flangeOfSix() {
  sim::Plate plate{circle(0, 0, 30), boltCircle(22, 3.2, 6, 6), {}, 0.0};
  plate.holes.front() = circle(22, 0, 4.5, true);
  plate.holes.push_back(circle(0, 0, 12, true));
  return plate;
}

inline sim::Plate comb() {
  sim::Plate plate{{{-40, -20}, {44, -20}}, {}, {}, 0.0};
  double x = 44.0;
  for (int finger = 0; finger < 6; ++finger, x -= 15.2) {
    plate.outer.insert(plate.outer.end(), {{x, 20}, {x - 8, 20}});
    if (finger < 5) plate.outer.insert(plate.outer.end(), {{x - 8, -4}, {x - 15.2, -4}});
  }
  plate.outer.back() = {-40, 20};
  return plate;
}

inline sim::Plate keyedWasher() {
  sim::Ring bore = onCircle(9, 17, 343, 61);
  bore.insert(bore.end(), {{12, -2.66}, {12, 2.66}});
  return {circle(0, 0, 20), {bore}, {}, 0.0};
}

inline sim::Plate star() {
  sim::Plate plate;
  for (int k = 0; k < 6; ++k) {
    const double tip = 60.0 * kDegrees * k, notch = tip + 30.0 * kDegrees, out = k == 0 ? 34 : 26;
    plate.outer.push_back({out * std::cos(tip), out * std::sin(tip)});
    plate.outer.push_back({13 * std::cos(notch), 13 * std::sin(notch)});
  }
  return plate;
}

inline sim::Plate perforated() {
  sim::Plate plate{rectangle(-45, -30, 45, 30), {}, {}, 0.0};
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 4; ++j)
      plate.holes.push_back(circle(-36.0 + 18.0 * i, -20.0 + 13.3 * j, 3.5, true));
  return plate;
}

inline sim::Plate ladder() {
  sim::Plate plate{rectangle(-60, -16, 60, 16), {}, {}, 0.0};
  for (int k = 0; k < 8; ++k)
    if (k != 4) plate.holes.push_back(rectangle(-54 + 14 * k, -10, -46 + 14 * k, 10));
  return plate;
}

inline sim::Plate arc() {
  sim::Plate plate{onCircle(45, -20, 120, 29), {}, {}, 0.0};
  const sim::Ring inner = onCircle(31, 120, -20, 29);
  plate.outer.insert(plate.outer.end(), inner.begin(), inner.end());
  plate.holes = {circle(38 * std::cos(0.2), 38 * std::sin(0.2), 3.5, true)};
  return plate;
}

}  // namespace shapes

inline std::vector<HeapShape> shapesAToH() {
  const auto hole = [](double x, double y, double radius) { return circle(x, y, radius, true); };
  return {
      {"angle",
       3,
       18,
       {0, 0},
       {{{-45, -6}, {45, -6}, {45, 6}, {-33, 6}, {-33, 50}, {-45, 50}},
        {hole(-39, 44, 3), hole(-39, 0, 3), hole(38, 0, 3)},
        {},
        0.0}},
      {"arc", 5, 18, {23.6, 29.8}, shapes::arc()},
      {"comb", 4, 18, {0, -12}, shapes::comb()},
      {"cross",
       6,
       18,
       {20, 0},
       {{{-30, -7},
         {-7, -7},
         {-7, -30},
         {7, -30},
         {7, -7},
         {38, -7},
         {38, 7},
         {7, 7},
         {7, 24},
         {-7, 24},
         {-7, 7},
         {-30, 7}},
        {hole(0, 0, 4)},
        {},
        0.0}},
      {"flange", 5, 18, {0, 18}, shapes::flange()},
      {"flange_of_six", 8, 18, {15, 8.5}, shapes::flangeOfSix()},
      {"hook",
       6,
       18,
       {-22, 0},
       {{{-30, -25}, {30, -25}, {30, -10}, {-14, -10}, {-14, 12}, {10, 12}, {10, 26}, {-30, 26}},
        {},
        {},
        0.0}}};
}

inline std::vector<HeapShape> shapesKToT() {
  const auto hole = [](double x, double y, double radius) { return circle(x, y, radius, true); };
  return {
      {"keyed_washer", 4, 40, {0, 14.5}, shapes::keyedWasher()},
      {"ladder", 4, 18, {6, 0}, shapes::ladder()},
      {"lever",
       5,
       18,
       {30, 1},
       {{{-8, -8}, {70, -5}, {70, 5}, {12, 9}, {18, 40}, {8, 42}, {-8, 10}},
        {hole(0, 0, 4), hole(62, 0, 2.5)},
        {},
        0.0}},
      {"long_bar", 4, 12, {0, 0}, {rectangle(-75, -7, 75, 7), {hole(-66, 0, 3)}, {}, 0.0}},
      {"perforated", 3, 18, {9, 0}, shapes::perforated()},
      {"star", 5, 18, {0, 0}, shapes::star()},
      {"strip",
       3,
       12,
       {0, 0},
       {rectangle(-55, -5, 55, 5), {hole(-48, 0, 2.2), hole(40, 0, 2.2)}, {}, 0.0}},
      {"tab",
       2.5,
       40,
       {4, 0},
       {{{-16, -9}, {16, -9}, {16, 3}, {10, 9}, {-16, 9}}, {hole(-9, 0, 3)}, {}, 0.0}},
      {"trapezium",
       4,
       18,
       {0, 0},
       {{{-35, -22}, {40, -22}, {22, 22}, {-20, 22}, {-35, 8}}, {}, {}, 0.0}},
  };
}

inline std::vector<HeapShape> heapShapes() {
  std::vector<HeapShape> out = shapesAToH();
  for (const HeapShape& shape : shapesKToT()) out.push_back(shape);
  return out;
}

}  // namespace planar_bin_picking
