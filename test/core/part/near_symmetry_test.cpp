// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/near_symmetry.h"

#include "support/plates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace planar_bin_picking {
namespace {

std::vector<NearSymmetry> turnsOf(const PartModel& part, bool flips, bool exact) {
  std::vector<NearSymmetry> out;
  for (const NearSymmetry& other : part.nearSymmetries()) {
    if (other.flips == flips && other.exact == exact) out.push_back(other);
  }
  return out;
}

double turnDeg(const NearSymmetry& other) {
  const Eigen::Matrix3d& R = other.T_part_turned.linear();
  const double angle = std::atan2(R(1, 0), R(0, 0)) / kDegrees;
  return angle < 0.0 ? angle + 360.0 : angle;
}

/// Whether the point belongs to the keyway or to the arc of the bore that it interrupts.
bool nearKeyway(const Eigen::Vector2d& p) {
  return std::abs(p.x()) < 4e-3 && p.y() > 8e-3 && p.y() < 15e-3;
}

TEST(NearSymmetries, AWheelsTeethAreAlikeButForItsKeyway) {
  const auto part = makePart("wheel", wheelPlate(15, true));
  const auto turns = turnsOf(*part, false, false);
  ASSERT_EQ(turns.size(), 14u);
  std::set<int> seen;
  for (const NearSymmetry& other : turns) {
    const double teeth = turnDeg(other) / 24.0;
    EXPECT_NEAR(teeth, std::round(teeth), 0.05);  // angles are sought to a degree
    seen.insert(static_cast<int>(std::lround(teeth)));
    ASSERT_FALSE(other.only_part.empty());
    ASSERT_FALSE(other.only_turned.empty());
    for (const int i : other.only_part) {
      const Eigen::Vector2d p = part->outline()[i].position;
      const Eigen::Vector3d back =
          other.T_part_turned.inverse() * Eigen::Vector3d(p.x(), p.y(), 0.0);
      EXPECT_TRUE(nearKeyway(p) || nearKeyway(back.head<2>())) << p.transpose();
    }
    for (const int i : other.only_turned) {
      const Eigen::Vector2d p = part->outline()[i].position;
      const Eigen::Vector3d there = other.T_part_turned * Eigen::Vector3d(p.x(), p.y(), 0.0);
      EXPECT_TRUE(nearKeyway(p) || nearKeyway(there.head<2>())) << p.transpose();
    }
  }
  EXPECT_EQ(seen.size(), 14u);
  EXPECT_EQ(seen.count(0), 0u);
}

TEST(NearSymmetries, ItsOtherFaceIsTheSameWhereTheKeywayIsInTheMiddle) {
  const auto part = makePart("wheel", wheelPlate(15, true));
  // Upside down it is one of the other teeth.
  EXPECT_TRUE(turnsOf(*part, true, false).empty());
  EXPECT_TRUE(turnsOf(*part, true, true).empty());
  EXPECT_TRUE(turnsOf(*part, false, true).empty());
}

TEST(NearSymmetries, ARingIsAlikeAtEveryTurnButForItsHoles) {
  const sim::Plate ring = {
      circle(0, 0, 40),
      {circle(0, 0, 26, true), circle(33, 0, 2.5, true), circle(-33, 0, 2.5, true)},
      {},
      0.0};
  const auto part = makePart("ring", ring);
  ASSERT_EQ(part->symmetry().order, 2);
  std::vector<bool> alike(180, false);  // of a ring with two holes a half turn is an exact symmetry
  for (const NearSymmetry& other : turnsOf(*part, false, false)) {
    ASSERT_LT(turnDeg(other), 180.5);
    alike[static_cast<int>(turnDeg(other) + 0.5) % 180] = true;
  }
  for (int angle = 15; angle <= 165; ++angle) EXPECT_TRUE(alike[angle]) << angle;
  EXPECT_TRUE(turnsOf(*part, true, false).empty());
}

TEST(NearSymmetries, TheyMapTheOutlineOntoItself) {
  sim::Plate plate = wheelPlate(15, true);
  plate.thickness_mm = 3.0;
  const auto part = makePart("wheel", plate);
  for (const NearSymmetry& other : part->nearSymmetries()) {
    const double z = part->faceZ(Face::kFront);
    int on = 0;
    for (const OutlinePoint& p : part->outline()) {
      const Eigen::Vector3d q =
          other.T_part_turned * Eigen::Vector3d(p.position.x(), p.position.y(), z);
      // The front lands on the front or, turned over, on the back.
      EXPECT_NEAR(q.z(), other.flips ? part->faceZ(Face::kBack) : z, 1e-12);
      on += std::any_of(part->outline().begin(), part->outline().end(), [&](const OutlinePoint& o) {
        return (o.position - q.head<2>()).norm() < 0.05 * part->radius();
      });
    }
    EXPECT_GT(on, 0.9 * part->outline().size());
  }
}

TEST(NearSymmetries, ExactSymmetriesAreLeftOut) {
  EXPECT_TRUE(makePart("wheel", wheelPlate(15, false))->nearSymmetries().empty());
  EXPECT_TRUE(makePart("disk", {circle(0, 0, 30), {}, {}, 0.0})->nearSymmetries().empty());
  sim::Plate square = printedPlate();
  square.prints.clear();
  EXPECT_TRUE(turnsOf(*makePart("square", square), false, true).empty());
  EXPECT_TRUE(turnsOf(*makePart("square", square), true, true).empty());
}

TEST(NearSymmetries, AChiralPartHasNone) {
  EXPECT_TRUE(makePart("bracket", bracketPlate())->nearSymmetries().empty());
}

TEST(NearSymmetries, APrintTellsExactOnesApart) {
  const auto part = makePart("printed", printedPlate());
  const auto turned = turnsOf(*part, false, true), flipped = turnsOf(*part, true, true);
  ASSERT_EQ(turned.size(), 3u);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(turnDeg(turned[k]), 90.0 * (k + 1), 1e-6);
  ASSERT_EQ(flipped.size(), 4u);
  for (const NearSymmetry& other : flipped) {
    // A corner lands on a corner of the other face.
    const Eigen::Vector3d q = other.T_part_turned * Eigen::Vector3d(0.03, 0.03, 0.0);
    EXPECT_NEAR(std::abs(q.x()), 0.03, 1e-6);
    EXPECT_NEAR(std::abs(q.y()), 0.03, 1e-6);
    EXPECT_NEAR(other.T_part_turned.linear()(2, 2), -1.0, 1e-9);
  }
}

}  // namespace
}  // namespace planar_bin_picking
