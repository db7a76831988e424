// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/pick_failures.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

namespace planar_bin_picking {
namespace {

constexpr double kSamePlace = 0.003, kChangedGrey = 12.0, kRadius = 0.03;

/// Owns what a PickInstance refers to.
struct Lying {
  std::string part = "hinge";
  Eigen::Vector3d center;
  Surroundings surroundings{cv::Mat(24, 24, CV_32F, cv::Scalar(0)), 8};
  explicit Lying(double x) : center(x, 0.0, 0.01) {}
  PickInstance instance() const { return {part, center, kRadius, surroundings}; }
};

class PickFailuresTest : public ::testing::Test {
 protected:
  PickFailuresTest() { failures_.use(kSamePlace, kChangedGrey); }
  std::vector<std::size_t> moved(const std::vector<Lying>& all) {
    std::vector<PickInstance> instances;
    for (const Lying& lying : all) instances.push_back(lying.instance());
    return failures_.moved(instances);
  }
  PickFailures failures_;
};

using Indices = std::vector<std::size_t>;

TEST_F(PickFailuresTest, CountsWhatFailsAtOnePlace) {
  EXPECT_EQ(failures_.recall(Lying(0.0).instance()), 0);
  failures_.add(Lying(0.0).instance());
  failures_.add(Lying(0.002).instance());
  EXPECT_EQ(failures_.recall(Lying(0.0029).instance()), 2);
  EXPECT_EQ(failures_.recall(Lying(0.0031).instance()), 0);
}

TEST_F(PickFailuresTest, WhatWasDraggedAsideHasMoved) {
  failures_.add(Lying(0.0).instance());
  EXPECT_EQ(moved({Lying(0.1), Lying(0.008)}), Indices({1}));
  EXPECT_EQ(moved({Lying(0.029)}), Indices({0}));
  EXPECT_EQ(moved({Lying(0.031)}), Indices());
}

TEST_F(PickFailuresTest, TheNearestIsWhatMoved) {
  failures_.add(Lying(0.0).instance());
  EXPECT_EQ(moved({Lying(0.02), Lying(-0.008), Lying(0.009)}), Indices({1}));
}

TEST_F(PickFailuresTest, EachFailureHasItsOwn) {
  failures_.add(Lying(0.1).instance());
  failures_.add(Lying(0.0).instance());
  EXPECT_EQ(moved({Lying(0.008), Lying(0.2), Lying(0.108)}), Indices({0, 2}));
  EXPECT_EQ(moved({Lying(0.0), Lying(0.108)}), Indices({1}));
}

TEST_F(PickFailuresTest, NeighboursOfWhatFailedAndLiesThereStillHaveNot) {
  failures_.add(Lying(0.0).instance());
  EXPECT_EQ(moved({Lying(0.02), Lying(0.001)}), Indices());
}

TEST_F(PickFailuresTest, OtherPartsHaveNotMoved) {
  failures_.add(Lying(0.0).instance());
  Lying other(0.008);
  other.part = "bracket";
  EXPECT_EQ(moved({other}), Indices());
  EXPECT_EQ(moved({other, Lying(0.009)}), Indices({1}));
  Lying on_it(0.009);
  on_it.part = "bracket";
  failures_.remove(on_it.instance());
  EXPECT_EQ(moved({Lying(0.009)}), Indices({0}));
}

TEST_F(PickFailuresTest, WhatIsBackAtItsPlaceHasNotMoved) {
  failures_.add(Lying(0.0).instance());
  ASSERT_EQ(moved({Lying(0.008)}), Indices({0}));  // it was not found, a neighbour was
  EXPECT_EQ(moved({Lying(0.0), Lying(0.008)}), Indices());
  failures_.remove(Lying(0.008).instance());
  EXPECT_EQ(failures_.recall(Lying(0.0).instance()), 1);
}

TEST_F(PickFailuresTest, APickAfterwardsEndsIt) {
  failures_.add(Lying(0.0).instance());
  ASSERT_EQ(moved({Lying(0.008)}), Indices({0}));
  failures_.add(Lying(0.008).instance());  // dragged aside, failed once more
  ASSERT_EQ(moved({Lying(0.016)}), Indices({0}));
  failures_.remove(Lying(0.016).instance());
  EXPECT_EQ(moved({Lying(0.01), Lying(0.002)}), Indices());
  EXPECT_EQ(failures_.recall(Lying(0.0).instance()), 0);
}

TEST_F(PickFailuresTest, AFailureWhereItWasDraggedToTakesTheFirstOnesPlace) {
  failures_.add(Lying(0.0).instance());
  ASSERT_EQ(moved({Lying(0.02)}), Indices({0}));
  failures_.add(Lying(0.02).instance());
  EXPECT_EQ(moved({Lying(0.04), Lying(-0.01)}), Indices({0}));
}

TEST_F(PickFailuresTest, APickOfANeighbourDoesNot) {
  failures_.add(Lying(0.0).instance());
  moved({Lying(0.0), Lying(0.02)});
  failures_.remove(Lying(0.02).instance());
  EXPECT_EQ(failures_.recall(Lying(0.0).instance()), 1);
  ASSERT_EQ(moved({Lying(0.008), Lying(0.02)}), Indices({0}));
  failures_.remove(Lying(0.02).instance());
  EXPECT_EQ(moved({Lying(0.008)}), Indices({0}));
}

TEST_F(PickFailuresTest, ACallForAnotherPartInBetweenForgetsNothing) {
  failures_.add(Lying(0.0).instance());
  moved({Lying(0.008)});
  Lying other(0.05);
  other.part = "bracket";
  EXPECT_EQ(moved({other}), Indices());
  failures_.remove(Lying(0.008).instance());
  EXPECT_EQ(moved({Lying(0.01)}), Indices());  // it was its own, and has gone
}

TEST_F(PickFailuresTest, AChangedSceneIsAnother) {
  failures_.add(Lying(0.0).instance());
  Lying changed(0.0);
  changed.surroundings.patch = cv::Mat(24, 24, CV_32F, cv::Scalar(13));
  EXPECT_EQ(failures_.recall(changed.instance()), 0);
  EXPECT_EQ(failures_.recall(Lying(0.0).instance()), 0);  // forgotten for good
}

}  // namespace
}  // namespace planar_bin_picking
