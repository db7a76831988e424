// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_order.h"

#include "planar_bin_picking/pick/pick_policy.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

using Indices = std::vector<std::size_t>;

/// Three parts by rank: the best lies low at a wall, the worst high in the middle.
const std::vector<PickPlace> kPlaces{{0.95, {0.18, 0.0, 0.00}, 0.00, 0.02},
                                     {0.80, {-0.10, 0.0, 0.03}, 0.03, 0.08},
                                     {0.60, {0.00, 0.0, 0.06}, 0.06, 0.15}};

TEST(PickOrder, IsTheRankWhereNothingIsSet) {
  EXPECT_EQ(ordered({kPlaces[2], kPlaces[0]}, {}), Indices({0, 1})) << "as given";
}

TEST(PickOrder, EachWeightDecidesWhereItIsLarge) {
  PickOrder order;
  order.height = 100.0;
  EXPECT_EQ(ordered(kPlaces, order), Indices({2, 1, 0}));
  order = {};
  order.walls = 100.0;
  EXPECT_EQ(ordered(kPlaces, order), Indices({2, 1, 0}));
  order = {};
  order.near = 100.0;
  order.near_x = -0.2;
  EXPECT_EQ(ordered(kPlaces, order), Indices({1, 2, 0}));
}

TEST(PickOrder, WeightsAreWeighedAgainstTheRank) {
  PickOrder order;
  order.height = 6.0;  // 0.06 m higher make up for 0.36 of rank, and 0.03 m for 0.18
  EXPECT_EQ(ordered(kPlaces, order), Indices({1, 2, 0}));
  EXPECT_NEAR(points(kPlaces[1], order), 0.98, 1e-12);
  order.near = 1.0, order.near_x = 0.18;
  EXPECT_EQ(ordered(kPlaces, order), Indices({0, 2, 1}));
}

TEST(PickOrder, NothingIsWonFarFromTheWalls) {
  PickOrder order;
  order.walls = 1.0;
  EXPECT_NEAR(points(kPlaces[2], order), 0.60 + kWallFarthest, 1e-12);
}

PickCandidate candidateAt(double x, double y) {
  PickCandidate candidate;
  candidate.part = "bracket";
  candidate.center = {x, y, 0.01};
  candidate.visible_fraction = 1.0;
  return candidate;
}

Indices offered(const PickPlan& plan) {
  Indices indices;
  for (const auto& offer : plan.offers) indices.push_back(offer.candidate);
  return indices;
}

TEST(PickOrder, IsThatOfThePolicysOffers) {
  PickBin bin;
  bin.min = {-0.2, -0.15, 0.0};
  bin.max = {0.2, 0.15, 0.1};
  PickCandidate at_wall = candidateAt(0.18, 0), high = candidateAt(0, 0),
                middle = candidateAt(0, 0);
  at_wall.confirmed = 1.0, high.confirmed = 0.7, middle.confirmed = 0.8;
  high.center.z() = 0.08;
  PickParams params;
  params.order.height = 50.0;
  PickPolicy highest{params};
  EXPECT_EQ(offered(highest.plan({at_wall, middle, high}, bin)), Indices({2, 0, 1}));
  EXPECT_EQ(offered(highest.plan({at_wall, middle, high}, std::nullopt)), Indices({2, 0, 1}));
  params.order = {};
  params.order.walls = 10.0;
  PickPolicy away{params};
  EXPECT_EQ(offered(away.plan({at_wall, high, middle}, bin)), Indices({2, 1, 0}));
  EXPECT_EQ(offered(away.plan({at_wall, high, middle}, std::nullopt)), Indices({0, 2, 1}));
  // Clockwise about the middle, from the bin's y axis on.
  params.order = {};
  params.order.clockwise = 10.0;
  PickPolicy clockwise{params};
  std::vector<PickCandidate> around;  // at 3, 12, 9 and 6 o'clock
  for (const auto& [x, y] : {std::pair{0.1, 0.0}, {0.001, 0.1}, {-0.1, 0.0}, {0.0, -0.1}})
    around.push_back(candidateAt(x, y));
  EXPECT_EQ(offered(clockwise.plan(around, bin)), Indices({1, 0, 3, 2}));
  EXPECT_EQ(offered(clockwise.plan(around, std::nullopt)), Indices({0, 1, 2, 3}));
  // What failed before comes last, wherever it lies; max_parts cuts after that.
  away.fail(middle);
  const auto plan = away.plan({at_wall, middle}, bin, 1);
  EXPECT_EQ(offered(plan), Indices({0}));
}

}  // namespace
}  // namespace planar_bin_picking
