// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/probability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace planar_bin_picking {
namespace {

/// A part in full view whose holes are seen.
PoseEvidence clear() {
  PoseEvidence e;
  e.edges = 0.95;
  e.holes = 0.95;
  e.beyond_corners = 0.0;
  e.slide_radii = 0.002;
  e.slide_px = 0.3;
  return e;
}

TEST(Probability, WhatIsClearlySeenIsNearlySure) {
  EXPECT_GT(probabilityRight(clear()), 0.95);
  EXPECT_LT(probabilityRight(clear()), 1.0);
}

TEST(Probability, NothingSeenIsNearlyImpossible) {
  PoseEvidence e;
  e.slide_radii = 0.01;
  e.slide_px = 1.0;
  EXPECT_LT(probabilityRight(e), 0.01);
  EXPECT_GT(probabilityRight(e), 0.0);
}

TEST(Probability, EachKindOfEvidenceCountsAsItShould) {
  const double all = probabilityRight(clear());
  PoseEvidence e = clear();
  e.edges = 0.6;
  EXPECT_LT(probabilityRight(e), all - 0.05);
  e = clear();
  e.holes = 0.1;
  EXPECT_LT(probabilityRight(e), all - 0.05);
  e = clear();
  e.beyond_corners = 0.6;
  EXPECT_LT(probabilityRight(e), 0.5);
  e = clear();
  e.slide_radii = 0.2;
  e.slide_px = 10.0;
  EXPECT_LT(probabilityRight(e), all - 0.1);
}

TEST(Probability, WhatIsNotKnownSpeaksNeitherWay) {
  PoseEvidence seen = clear(), missing = clear(), none = clear();
  missing.holes = 0.0;
  none.holes.reset();
  EXPECT_LT(probabilityRight(none), probabilityRight(seen));
  EXPECT_GT(probabilityRight(none), probabilityRight(missing));
  none = clear();
  none.beyond_corners.reset();
  EXPECT_EQ(probabilityRight(none), probabilityRight(seen));
}

/// A covariance that says nothing is no proof, and neither is one that a known plane makes zero.
TEST(Probability, ExtremeDeviationsAreNumbers) {
  for (const double slide : {0.0, 1e-12, 1e12, std::numeric_limits<double>::infinity()}) {
    PoseEvidence e = clear();
    e.slide_radii = e.slide_px = slide;
    const double p = probabilityRight(e);
    EXPECT_TRUE(p >= 0.0 && p <= 1.0) << slide;
  }
}

TEST(Probability, SigmaInPlaneIsTheLargestAlongTheFace) {
  RefinedPose pose;
  pose.covariance.diagonal() << 1e-6, 4e-6, 1e-2, 0, 0, 0;  // 1, 2 and 100 mm
  EXPECT_NEAR(sigmaInPlane(pose), 2e-3, 1e-9);
  pose.covariance(0, 1) = pose.covariance(1, 0) = 1.5e-6;  // aslant
  EXPECT_NEAR(sigmaInPlane(pose), std::sqrt(2.5e-6 + std::sqrt(4.5) * 1e-6), 1e-9);
}

TEST(Probability, OfTheTiltIsByItsLargestSigma) {
  RefinedPose pose;
  pose.covariance = Matrix6d::Identity();  // a radian about the normal, and a metre
  const auto with = [&](double about_x_deg, double about_y_deg) {
    pose.covariance(3, 3) = std::pow(about_x_deg * M_PI / 180.0, 2);
    pose.covariance(4, 4) = std::pow(about_y_deg * M_PI / 180.0, 2);
    return probabilityOfTilt(pose);
  };
  EXPECT_EQ(with(0.0, 0.0), 1.0);
  EXPECT_GT(with(1.0, 0.5), 0.999);
  EXPECT_NEAR(with(0.1, 6.0), 0.6827, 1e-4);
  EXPECT_NEAR(with(6.0, 0.1), 0.6827, 1e-4);
  EXPECT_NEAR(with(3.0, 0.1), 0.9545, 1e-4);
}

}  // namespace
}  // namespace planar_bin_picking
