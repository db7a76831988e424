// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
// What is not known well enough to be picked, and parameters that change, as pick_policy.h says it.

#include "planar_bin_picking/pick/pick_policy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking {
namespace {

PickCandidate known(double depth_sigma, double tilt_sigma) {
  PickCandidate candidate;
  candidate.part = "bracket";
  candidate.score = candidate.confirmed = 0.9;
  candidate.visible_fraction = 1.0;
  candidate.depth_sigma = depth_sigma;
  candidate.tilt_sigma = tilt_sigma;
  candidate.surroundings = {cv::Mat(24, 24, CV_32F, cv::Scalar(0)), 8};
  return candidate;
}

std::vector<Refused> refusedBy(const PickParams& params, const PickCandidate& candidate) {
  return PickPolicy(params).plan({candidate}, std::nullopt).refused;
}

TEST(NeedsView, IsOffByDefault) { EXPECT_TRUE(refusedBy({}, known(1.0, 1.0)).empty()); }

TEST(NeedsView, SaysWhatIsUnsure) {
  PickParams depth, tilt;
  depth.depth_sigma_max = 0.001;
  tilt.tilt_sigma_max = 0.01;
  EXPECT_TRUE(refusedBy(depth, known(0.001, 1.0)).empty());
  EXPECT_TRUE(refusedBy(tilt, known(1.0, 0.01)).empty());
  const auto deep = refusedBy(depth, known(0.0012, 0.0));
  ASSERT_EQ(deep.size(), 1u);
  EXPECT_EQ(deep[0].reason, PickRefusal::kNeedsView);
  EXPECT_EQ(deep[0].text, "its depth is known to 1.20 mm, at most 1.00");
  const auto steep = refusedBy(tilt, known(0.0, 0.012));
  ASSERT_EQ(steep.size(), 1u);
  EXPECT_EQ(steep[0].text, "its tilt is known to 0.0120 rad, at most 0.0100");
  EXPECT_EQ(refusedBy(depth, known(std::nan(""), 0.0)).size(), 1u);
}

TEST(NeedsView, StandsBehindWhatALookDoesNotMend) {
  PickParams params;
  params.depth_sigma_max = 0.001;
  params.tilt_max_deg = 30.0;
  PickCandidate steep = known(0.002, 0.0);
  steep.tilt_deg = 40.0;
  EXPECT_EQ(refusedBy(params, steep).at(0).reason, PickRefusal::kTilt);
}

TEST(NeedsView, HintsNameTheRemedy) {
  EXPECT_NE(deadlockHint({{0, PickRefusal::kNeedsView, ""}}).find("refine_part"),
            std::string::npos);
  EXPECT_NE(deadlockHint({{0, PickRefusal::kContradicted, ""}}).find("second one"),
            std::string::npos);
}

TEST(TiltSigma, IsThatOfTheWorstAxis) {
  Matrix6d covariance = Matrix6d::Zero();
  covariance(3, 3) = 4e-4;
  covariance(4, 4) = 1e-4;
  EXPECT_NEAR(tiltSigma(covariance), 0.02, 1e-12);
  // The same, turned by half a right angle in the face.
  covariance(3, 3) = covariance(4, 4) = 2.5e-4;
  covariance(3, 4) = covariance(4, 3) = 1.5e-4;
  EXPECT_NEAR(tiltSigma(covariance), 0.02, 1e-12);
}

PickCandidate at(const double x) {
  PickCandidate candidate = known(0.0, 0.0);
  candidate.center.x() = x;
  return candidate;
}

std::vector<std::size_t> offered(const PickPlan& plan) {
  std::vector<std::size_t> indices;
  for (const auto& offer : plan.offers) indices.push_back(offer.candidate);
  return indices;
}

using Indices = std::vector<std::size_t>;

TEST(TunedPolicy, OffersNoMoreThanTheCellWants) {
  PickParams params;
  params.max_parts = 2;
  PickPolicy policy{params};
  const std::vector<PickCandidate> candidates = {at(0.0), at(0.1), at(0.2)};
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Indices({0, 1}));
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt, 1)), Indices({0}));
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt, 3)), Indices({0, 1}));
}

TEST(TunedPolicy, RemembersFailures) {
  PickPolicy policy{PickParams()};
  const std::vector<PickCandidate> candidates = {at(0.0), at(0.1)};
  policy.fail(candidates[0]);
  PickParams params;
  params.failures_max = 1;
  policy.use(params);
  EXPECT_EQ(offered(policy.plan(candidates, std::nullopt)), Indices({1}));
  params.failures_max = 0;
  EXPECT_THROW(policy.use(params), std::invalid_argument);
  EXPECT_EQ(policy.params().failures_max, 1);
}

}  // namespace
}  // namespace planar_bin_picking
