// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/next_view.h"

#include "part/outline_view.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/views/look.h"
#include "support/matchers.h"
#include "support/orbit.h"

#include <gtest/gtest.h>

#include <functional>

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
  EXPECT_LT(place(proposed->covariance), 0.3 * place(known_.covariance));
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

/// Of the box's six sides each.
TEST_F(NextViewOf, StaysInTheBox) {
  const auto wide = next(wideLimits());
  ASSERT_TRUE(wide);
  const Eigen::Vector3d free = kT_base_first * wide->T_first_camera.translation();
  int found = 0;
  for (int side = 0; side < 6; ++side) {
    NextViewLimits limits = wideLimits();
    const int axis = side / 2;
    const double wall = free(axis) + (side % 2 == 0 ? 0.02 : -0.02);
    (side % 2 == 0 ? limits.box_min : limits.box_max)(axis) = wall;
    const auto within = next(limits);
    if (!within) continue;
    ++found;
    const double x = (kT_base_first * within->T_first_camera.translation())(axis);
    EXPECT_TRUE(side % 2 == 0 ? x >= wall : x <= wall) << side << ": " << x << " " << wall;
  }
  EXPECT_GE(found, 5);
}

TEST_F(NextViewOf, LooksAtThePartFromWhereItIsSharp) {
  NextViewLimits limits = wideLimits();
  limits.focus = {0.55, 0.75};
  const auto proposed = next(limits);
  ASSERT_TRUE(proposed);
  const Eigen::Isometry3d& T = proposed->T_first_camera;
  const Eigen::Vector3d centre =
      T.inverse() * known_.T_camera_part * centreOf(*kBracket, Face::kFront).translation();
  EXPECT_LT(centre.head<2>().norm(), 1e-9);                             // on the optical axis
  EXPECT_LT(std::abs(Eigen::AngleAxisd(T.linear()).axis().z()), 1e-9);  // not turned about it
  for (const auto& p : bracketPlate().outer) {
    const double depth =
        (T.inverse() * sim::poseOf(kLie) * (1e-3 * Eigen::Vector3d(p.x(), p.y(), 0.0))).z();
    EXPECT_GT(depth, 0.549);
    EXPECT_LT(depth, 0.751);
  }
  // Where the focus is the same everywhere, no place is proposed that is as good and farther away.
  EXPECT_LT(T.translation().norm(), 0.55);
  limits.focus = {0.6, 0.602};  // less than the part's own depth from aside
  EXPECT_FALSE(next(limits));
}

/// Not from where its face is seen from the side, or it is not all in the picture.
TEST_F(NextViewOf, PredictsNothingWhereTooLittleIsSeen) {
  const Eigen::Vector3d centre = known_.T_camera_part * Eigen::Vector3d(0.007, -0.004, 0.0);
  const auto told = [&](const Eigen::Isometry3d& T) {
    return predictedCovariance(known_, *kBracket, kCamera, T, {}).has_value();
  };
  for (const double direction : {0.0, 90.0, 180.0, 270.0}) {
    EXPECT_TRUE(told(orbit(centre, 35, direction))) << direction;
    EXPECT_FALSE(told(orbit(centre, 80, direction))) << direction;
    const Eigen::Vector3d aside(0.21 * std::cos(direction * kDegrees),
                                0.18 * std::sin(direction * kDegrees), 0.0);
    Eigen::Isometry3d T = orbit(centre, 5, 40);
    T.translation() += aside + T.linear() * Eigen::Vector3d(centre.x(), centre.y(), 0.0);
    EXPECT_FALSE(told(T)) << direction;
  }
  Eigen::Isometry3d beyond = Eigen::Isometry3d::Identity();
  beyond.translation().z() = 1.0;  // the part is behind it
  EXPECT_FALSE(told(beyond));
}

/// Edges that are covered say nothing; what several views tell already, they tell.
TEST_F(NextViewOf, PredictsFromWhatIsKnown) {
  const Eigen::Vector3d centre = known_.T_camera_part * Eigen::Vector3d(0.007, -0.004, 0.0);
  const Eigen::Isometry3d T = orbit(centre, 30, 200);
  const auto place = [&](const Detection& known) {
    const auto said = predictedCovariance(known, *kBracket, kCamera, T, {});
    return said ? std::sqrt(said->topLeftCorner<3, 3>().trace()) : 1.0;
  };
  Detection half = known_;
  half.covered.clear();
  const auto& cells = kBracket->faceGrid().cells();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells[i].x() < 0.01) half.covered.push_back(static_cast<int>(i));
  }
  EXPECT_GT(place(half), 1.1 * place(known_));
  Detection tracked = known_;
  tracked.views = 2;
  tracked.covariance *= 0.01;
  EXPECT_LT(place(tracked), place(known_));
  tracked.covariance = known_.covariance * 1e4;
  EXPECT_GT(place(tracked), place(known_));
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
  // A wall on either side, close to the part and high: it looks from the other one.
  for (int side = 0; side < 4; ++side) {
    const int axis = side / 2;
    limits.bin->min = part - Eigen::Vector3d(0.4, 0.4, 0.1);
    limits.bin->max = part + Eigen::Vector3d(0.4, 0.4, 0.2);
    (side % 2 == 0 ? limits.bin->min : limits.bin->max)(axis) =
        part(axis) + (side % 2 == 0 ? -0.06 : 0.06);
    const auto inside = next(limits);
    ASSERT_TRUE(inside) << side;
    const Eigen::Vector3d from = kT_base_first * inside->T_first_camera.translation();
    const double at_rim = (part + (from - part) * (0.2 / (from.z() - part.z())))(axis);
    EXPECT_TRUE(side % 2 == 0 ? at_rim > part(axis) - 0.06 : at_rim < part(axis) + 0.06) << side;
  }
}

TEST_F(NextViewOf, LimitsThatCannotBeAreRefused) {
  const auto refused = [&](const std::function<void(NextViewLimits*)>& spoil,
                           const std::vector<std::string>& words) {
    NextViewLimits limits = wideLimits();
    spoil(&limits);
    return refuses([&] { next(limits); }, words);
  };
  EXPECT_TRUE(refused([](auto* l) { l->box_max.y() = -1.0; }, {"box", "empty", "maximum"}));
  EXPECT_TRUE(refused([](auto* l) { l->box_min.x() = NAN; }, {"box"}));
  EXPECT_TRUE(refused([](auto* l) { l->cone_deg = 0.0; }, {"cone is 0.0", "less than 90"}));
  EXPECT_TRUE(refused([](auto* l) { l->cone_deg = 90.0; }, {"cone is 90.0", "more than 0"}));
  EXPECT_TRUE(refused([](auto* l) { l->cone_deg = NAN; }, {"cone"}));
  EXPECT_TRUE(refused([](auto* l) { l->focus = {0.5, 0.5}; }, {"focus", "0.50", "smaller one"}));
  EXPECT_TRUE(refused([](auto* l) { l->focus = {0.0, 0.5}; }, {"focus", "0.00"}));
}

}  // namespace
}  // namespace planar_bin_picking
