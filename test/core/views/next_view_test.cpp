// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/next_view.h"

#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/views/look.h"
#include "support/matchers.h"
#include "support/orbit.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::PinholeCamera kPinhole;
const sim::Lie kLie{60, -30, 600, 30, 12, 60};
const auto kBracket = makePart("bracket", bracketPlate());
const Camera kCamera = makeCamera(kPinhole);
/// The first camera looks down from there.
const Eigen::Isometry3d kT_base_first =
    Eigen::Translation3d(0.1, 0.2, 0.7) * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());

NextViewLimits wideLimits() {
  NextViewLimits limits;
  limits.box_min = {-1.0, -1.0, 0.0};
  limits.box_max = {1.0, 1.0, 1.0};
  limits.focus = {0.4, 0.8};
  return limits;
}

Detection located() {
  LocateRequest request;
  request.parts = {kBracket};
  request.distance_min = 0.5;
  request.distance_max = 0.7;
  const cv::Mat image =
      pictureFrom(kPinhole, sceneOf(bracketPlate(), kLie), Eigen::Isometry3d::Identity(), 1);
  return Locator().locate(image, kCamera, request).detections.at(0);
}

class NextViewOf : public testing::Test {
 protected:
  const Detection known_ = located();
  std::optional<ViewProposal> next(const NextViewLimits& limits) const {
    return nextView(known_, *kBracket, kCamera, kT_base_first, limits, {});
  }
};

/// What was predicted is what the look then gives, for the proposed place and for worse ones.
TEST_F(NextViewOf, PredictsWhatTheLookGives) {
  const auto proposed = next(wideLimits());
  ASSERT_TRUE(proposed);
  const Eigen::Vector3d centre = known_.T_camera_part * Eigen::Vector3d(0.007, -0.004, 0.0);
  for (const Eigen::Isometry3d& T :
       {proposed->T_first_camera, orbit(centre, 12, 80), orbit(centre, 35, 200)}) {
    const auto said = predictedCovariance(known_, *kBracket, kCamera, T, {});
    ASSERT_TRUE(said);
    const auto view = [&](const Eigen::Isometry3d& at, int seed) {
      return std::make_shared<const View>(
          pictureFrom(kPinhole, sceneOf(bracketPlate(), kLie), at, seed), kCamera, at);
    };
    const auto result =
        Looker().look(known_, *kBracket, {view(Eigen::Isometry3d::Identity(), 1), view(T, 2)});
    ASSERT_EQ(result.status, LookStatus::kConfirmed) << result.text;
    for (int i = 0; i < 6; ++i) {
      const double ratio = std::sqrt((*said)(i, i) / result.detection.covariance(i, i));
      EXPECT_GT(ratio, 0.6) << i;
      EXPECT_LT(ratio, 1.6) << i;
    }
  }
}

TEST_F(NextViewOf, IsBetterThanOthersAndKeepsThePartInView) {
  const auto proposed = next(wideLimits());
  ASSERT_TRUE(proposed);
  const auto place = [](const Matrix6d& C) { return C.topLeftCorner(3, 3).trace(); };
  EXPECT_LT(place(proposed->covariance), 0.25 * place(known_.covariance));
  const auto said = predictedCovariance(known_, *kBracket, kCamera, proposed->T_first_camera, {});
  ASSERT_TRUE(said);
  EXPECT_TRUE(said->isApprox(proposed->covariance, 1e-9));
  for (const auto& p : bracketPlate().outer) {
    const Eigen::Vector3d x = proposed->T_first_camera.inverse() * sim::poseOf(kLie) *
                              (1e-3 * Eigen::Vector3d(p.x(), p.y(), 0.0));
    const Eigen::Vector2d pixel = sim::project(kPinhole, x);
    EXPECT_GT(pixel.x(), 0.0);
    EXPECT_LT(pixel.x(), kPinhole.width);
    EXPECT_GT(pixel.y(), 0.0);
    EXPECT_LT(pixel.y(), kPinhole.height);
    EXPECT_GT(x.z(), 0.4);
    EXPECT_LT(x.z(), 0.8);
  }
}

TEST_F(NextViewOf, StaysWithinItsLimits) {
  NextViewLimits limits = wideLimits();
  limits.cone_deg = 15.0;
  const auto narrow = next(limits);
  ASSERT_TRUE(narrow);
  EXPECT_LT(std::acos(narrow->T_first_camera.linear()(2, 2)), 15.01 * kDegrees);
  limits = wideLimits();
  limits.box_min.x() = 0.3;
  const auto aside = next(limits);
  ASSERT_TRUE(aside);
  EXPECT_GE((kT_base_first * aside->T_first_camera.translation()).x(), 0.3);
  limits.box_min.x() = 0.9;
  EXPECT_FALSE(next(limits));
  limits = wideLimits();
  limits.focus = {0.06, 0.09};  // so near that the part does not fit
  EXPECT_FALSE(next(limits));
}

TEST_F(NextViewOf, LooksOverTheWallsOfTheBin) {
  NextViewLimits limits = wideLimits();
  const Eigen::Vector3d part = kT_base_first * sim::poseOf(kLie).translation();
  limits.bin.emplace();
  limits.bin->min = part - Eigen::Vector3d(0.08, 0.3, 0.1);
  limits.bin->max = part + Eigen::Vector3d(0.3, 0.3, 0.2);  // a wall 80 mm beside it, 200 mm high
  const auto over = next(limits);
  ASSERT_TRUE(over);
  const Eigen::Vector3d eye = kT_base_first * over->T_first_camera.translation();
  EXPECT_GT((part + (eye - part) * (0.2 / (eye.z() - part.z()))).x(), limits.bin->min.x());
  limits.bin->max.z() = 0.9;  // higher than any place that is allowed
  EXPECT_FALSE(next(limits));
}

TEST_F(NextViewOf, LimitsThatCannotBeAreRefused) {
  NextViewLimits limits;
  EXPECT_TRUE(refuses([&] { next(limits); }, {"box"}));
  limits = wideLimits();
  limits.cone_deg = 0.0;
  EXPECT_TRUE(refuses([&] { next(limits); }, {"cone"}));
  limits = wideLimits();
  limits.focus = {0.5, 0.5};
  EXPECT_TRUE(refuses([&] { next(limits); }, {"focus"}));
}

}  // namespace
}  // namespace planar_bin_picking
