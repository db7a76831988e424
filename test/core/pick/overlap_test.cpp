// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/overlap.h"

#include "planar_bin_picking/pick/pick_policy.h"
#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

constexpr double kThick = 0.003;

/// 80 x 40 mm, 3 mm thick, with a hole of 20 mm in the middle.
const std::shared_ptr<const PartModel> kPlate =
    makePart("plate", {rectangle(-40, -20, 40, 20), {circle(0, 0, 10, true)}, {}, 1e3 * kThick});

/// Front up; its face is so high.
Eigen::Isometry3d at(double x, double z, double turn_deg = 0.0) {
  return Eigen::Translation3d(x, 0.0, z) *
         Eigen::AngleAxisd(turn_deg * kDegrees, Eigen::Vector3d::UnitZ());
}

/// Back up; its face is so high.
Eigen::Isometry3d turnedOver(double x, double z) {
  return Eigen::Translation3d(x, 0.0, z - kThick) *
         Eigen::Isometry3d(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()));
}

double shareBelow(const Eigen::Isometry3d& own, Face up, const Eigen::Isometry3d& other,
                  Face other_up) {
  const auto cells = cellsBelow({kPlate.get(), up, own, {}}, {kPlate.get(), other_up, other, {}});
  return static_cast<double>(cells.size()) / static_cast<double>(kPlate->faceGrid().cells().size());
}

TEST(CellsBelow, AreThoseOverWhichTheOtherPartHasMaterial) {
  // A quarter of its length is under the other one, whose end has no hole there.
  constexpr double kQuarter = 800.0 / (80.0 * 40.0 - EIGEN_PI * 100.0);
  EXPECT_NEAR(shareBelow(at(0, kThick), Face::kFront, at(0.06, 2 * kThick), Face::kFront), kQuarter,
              0.03);
  EXPECT_EQ(shareBelow(at(0.06, 2 * kThick), Face::kFront, at(0, kThick), Face::kFront), 0.0);
  // Whichever face is up.
  EXPECT_NEAR(shareBelow(turnedOver(0, kThick), Face::kBack, at(0.06, 2 * kThick), Face::kFront),
              kQuarter, 0.03);
  EXPECT_NEAR(
      shareBelow(turnedOver(0, kThick), Face::kBack, turnedOver(0.06, 2 * kThick), Face::kBack),
      kQuarter, 0.03);
  EXPECT_EQ(shareBelow(turnedOver(0.06, 2 * kThick), Face::kBack, at(0, kThick), Face::kFront),
            0.0);
  // Across: what is seen through the other's hole is not covered, what is beside it neither.
  EXPECT_NEAR(shareBelow(at(0.02, kThick), Face::kFront, at(0.02, 2 * kThick, 90.0), Face::kFront),
              (1600.0 - EIGEN_PI * 100.0) / (3200.0 - EIGEN_PI * 100.0), 0.03);
}

TEST(CellsBelow, HoldWhereDepthIsNotKnownWell) {
  // Half a thickness of error is too much: the lower one may as well be the upper one.
  EXPECT_GT(shareBelow(at(0, kThick), Face::kFront, at(0.06, 1.6 * kThick), Face::kFront), 0.2);
  EXPECT_EQ(shareBelow(at(0, kThick), Face::kFront, at(0.06, 1.4 * kThick), Face::kFront), 0.0);
  // Where the picture shows the other one to be covered, it lies below.
  LyingFace other{kPlate.get(), Face::kFront, at(0.06, 2 * kThick), {}};
  const LyingFace own{kPlate.get(), Face::kFront, at(0, kThick), {}};
  const std::size_t all = cellsBelow(own, other).size();
  for (const Eigen::Vector2d& cell : kPlate->faceGrid().cells())
    if (cell.x() < -0.03) other.covered.push_back(cell);  // half of what lies over this one
  EXPECT_NEAR(static_cast<double>(cellsBelow(own, other).size()), 0.5 * all, 0.05 * all);
}

TEST(CellsBelow, AreNoneOfWhatLiesBesideOrStandsUpright) {
  EXPECT_EQ(shareBelow(at(0, kThick), Face::kFront, at(0.0805, 2 * kThick), Face::kFront), 0.0);
  EXPECT_EQ(shareBelow(at(0, kThick), Face::kFront, at(0.5, 2 * kThick), Face::kFront), 0.0);
  const Eigen::Isometry3d upright =
      at(0, 0.05) * Eigen::Isometry3d(Eigen::AngleAxisd(85 * kDegrees, Eigen::Vector3d::UnitY()));
  EXPECT_EQ(shareBelow(at(0, kThick), Face::kFront, upright, Face::kFront), 0.0);
}

PickCandidate candidateAt(const Eigen::Isometry3d& T_target_part, double pick_x) {
  PickCandidate candidate;
  candidate.part = "plate";
  candidate.model = kPlate;
  candidate.center = T_target_part.translation();
  candidate.score = candidate.confirmed = candidate.visible_fraction = 1.0;
  candidate.face.T_target_part = T_target_part;
  candidate.T_target_pick = {
      T_target_part * Eigen::Translation3d(pick_x, 0.0, 0.0) *
      Eigen::Isometry3d(Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()))};
  return candidate;
}

std::vector<std::size_t> offered(const PickPlan& plan) {
  std::vector<std::size_t> list;
  for (const auto& offer : plan.offers) list.push_back(offer.candidate);
  return list;
}

using Order = std::vector<std::size_t>;

TEST(PickPolicy, RanksBehindWhatOtherPartsLieOn) {
  PickPolicy policy{PickParams()};
  std::vector<PickCandidate> candidates = {candidateAt(at(0, kThick), -0.025),
                                           candidateAt(at(0.06, 2 * kThick), 0.025)};
  candidates[1].confirmed = 0.9;  // the picture shows nothing that covers the first
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({1, 0}));
  candidates[1].confirmed = 0.4;  // a quarter covered costs about half the rank
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({0, 1}));
  // By itself, or with one on it that another view contradicts, it stays what it is.
  candidates[1].confirmed = 0.9;
  candidates[1].withheld = PickRefusal::kContradicted;
  const auto plan = policy.plan(candidates, std::nullopt);
  EXPECT_EQ(offered(plan), Order({0}));
  EXPECT_EQ(plan.refused.size(), 1u);
}

TEST(PickPolicy, RanksWhatCarriesSomethingLower) {
  PickPolicy policy{PickParams()};
  // Far from each other; a corner of the first is covered by what nobody knows.
  std::vector<PickCandidate> candidates = {candidateAt(at(0, kThick), 0.025),
                                           candidateAt(at(0.5, kThick), 0.025)};
  candidates[1].confirmed = 0.85;
  candidates[0].visible_fraction = 0.96;
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({1, 0}));
  candidates[0].visible_fraction = 0.98;  // so much the picture errs
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({0, 1}));
  candidates[0].visible_fraction = 0.96;
  candidates[1].confirmed = 0.8;
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({0, 1}));
}

TEST(PickPolicy, SendsNoToolToWhereAnotherPartLies) {
  PickParams params;
  params.tool_radius = 0.01;
  PickPolicy policy(params);
  std::vector<PickCandidate> candidates = {candidateAt(at(0, kThick), 0.025),
                                           candidateAt(at(0.06, 2 * kThick), 0.025)};
  const auto plan = policy.plan(candidates, std::nullopt);
  EXPECT_EQ(offered(plan), Order({1}));
  ASSERT_EQ(plan.refused.size(), 1u);
  EXPECT_EQ(plan.refused[0].reason, PickRefusal::kOccluded);
  // The same place on the part below it is free once the other one has gone.
  candidates.pop_back();
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Order({0}));
}

}  // namespace
}  // namespace planar_bin_picking
