// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/image_alignment.h"

#include "planar_bin_picking/base/se3.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>
#include <random>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr SearchProfile kReach{4, true, 0.8};
constexpr double kTukeyPx = 3.0;
const auto kBracket = makePart("bracket", bracketPlate());

bool isShape(const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }

const sim::Lie kLie{20, -10, 600, 30, 12, 60};

/// The pose of a drawn bracket, from these of its points.
ImagePose poseFrom(const Shot& shot, const std::vector<LocalPoint>& points) {
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  return alignInImage(shot.edges, shot.camera, points, solidOf(*kBracket, Face::kFront), T, kReach,
                      kTukeyPx);
}

double widest(const ImagePose& pose) {
  return std::sqrt(
      Eigen::SelfAdjointEigenSolver<Matrix6d>(pose.covariance).eigenvalues().maxCoeff());
}

TEST(ImageAlignment, TooFewEdgesLeaveEverythingOpen) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto all = localPoints(*kBracket, 320, isShape);
  for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{7}}) {
    std::vector<LocalPoint> few;
    for (std::size_t i = 0; i < count; ++i) few.push_back(all[i * all.size() / 7]);
    const ImagePose pose = poseFrom(shot, few);
    EXPECT_EQ(pose.used, static_cast<int>(count));
    EXPECT_EQ(pose.status, AlignmentStatus::kTooFewEdges);
    EXPECT_FALSE(std::isfinite(pose.offset_sigma));
    // A radius and a radian, in every direction.
    EXPECT_TRUE(pose.covariance.isApprox(Matrix6d::Identity()));
  }
}

TEST(ImageAlignment, FewerEdgesAreWorthLess) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  double last = 0.0;
  for (const int count : {320, 80, 30, 16, 9}) {
    const ImagePose pose = poseFrom(shot, localPoints(*kBracket, count, isShape));
    ASSERT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_GT(widest(pose), last) << count << " points";
    last = widest(pose);
  }
  EXPECT_LT(widest(poseFrom(shot, localPoints(*kBracket, 320, isShape))), 0.03);
}

/// However many points lie on one straight side, nothing tells where along it the part lies, nor
/// how it is turned about it.
TEST(ImageAlignment, WhatNoEdgeHoldsStaysOpen) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  std::vector<LocalPoint> side;
  for (const auto& p : localPoints(*kBracket, 512, isShape)) {
    if (std::abs(p.tx) > 0.999 && kBracket->outline()[p.index].position.y() < -0.0285)
      side.push_back(p);
  }
  ASSERT_GT(side.size(), 40u);
  const ImagePose pose = poseFrom(shot, side);
  ASSERT_GE(pose.used, 40);
  Vector6d along = Vector6d::Zero();
  along(0) = 1.0;  // the side runs along the part's x
  EXPECT_GT(std::sqrt(along.dot(pose.covariance * along)), 0.5);
  // Where the others do not matter, across it is known well.
  EXPECT_LT(1.0 / std::sqrt(pose.covariance.inverse()(1, 1)), 0.01);
}

/// What lies on a part has edges, too, and some pass for the part's own.
TEST(ImageAlignment, WhatIsNotFoundMakesTheRestWorthLess) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto found = localPoints(*kBracket, 320, isShape);
  const ImagePose whole = poseFrom(shot, found);
  double last = whole.covariance.trace();
  for (const int count : {80, 160, 320}) {
    auto points = localPoints(*kBracket, count, isShape);
    moveInward(0.12, &points);  // radii: hardly an edge is near
    points.insert(points.end(), found.begin(), found.end());
    const ImagePose pose = poseFrom(shot, points);
    ASSERT_LT(pose.used, whole.used + count / 8);
    EXPECT_GT(pose.covariance.trace(), 1.3 * last) << count;
    last = pose.covariance.trace();
  }
}

/// Of the pose against the true one: translation in radii, rotation in radians.
Vector6d errorOf(const Eigen::Isometry3d& T_camera_centre) {
  Vector6d xi =
      log((sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront)).inverse() * T_camera_centre);
  xi.head<3>() /= kBracket->radius();
  return xi;
}

TEST(ImageAlignment, MovesOntoTheEdges) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto points = localPoints(*kBracket, 320, isShape);
  const Eigen::Isometry3d T = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  for (const double side : {-1.0, 1.0}) {
    Vector6d off;  // some 2 pixels
    off << 0.01, -0.01, 0.01, 0.02, -0.02, 0.01;
    ImagePose pose;
    pose.T_camera_centre = stepped(T, side * off, kBracket->radius());
    for (int round = 0; round < 3; ++round) {
      pose = alignInImage(shot.edges, shot.camera, points, solidOf(*kBracket, Face::kFront),
                          pose.T_camera_centre, kReach, kTukeyPx);
    }
    EXPECT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_GT(pose.used, 300);
    EXPECT_LT(errorOf(pose.T_camera_centre).norm(), 0.15 * off.norm());
    EXPECT_LT(pose.residual_px, 0.3);
  }
}

TEST(ImageAlignment, TellsByHowMuchTheEdgesLieInside) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  for (const double inside : {-0.01, 0.0, 0.01}) {  // radii: 0.8 pixels
    auto points = localPoints(*kBracket, 320, isShape);
    moveInward(-inside, &points);  // drawn so much larger
    const ImagePose pose = poseFrom(shot, points);
    ASSERT_EQ(pose.status, AlignmentStatus::kAligned);
    EXPECT_NEAR(pose.offset, inside, 0.002) << inside;
    EXPECT_LT(std::abs(pose.offset - inside), 3.0 * pose.offset_sigma);
    EXPECT_LT(pose.offset_sigma, 0.004);
  }
}

TEST(ImageAlignment, SaysHowThePoseFollowsTheEdgeOffset) {
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto points = localPoints(*kBracket, 320, isShape);
  constexpr double kStep = 0.003;  // radii
  auto smaller = points, larger = points;
  moveInward(kStep, &smaller);
  moveInward(-kStep, &larger);
  const Vector6d slope = (errorOf(poseFrom(shot, smaller).T_camera_centre) -
                          errorOf(poseFrom(shot, larger).T_camera_centre)) /
                         (2.0 * kStep);
  const Vector6d said = poseFrom(shot, points).per_offset;
  EXPECT_GT(slope.norm(), 1.0);  // a smaller part is nearer
  EXPECT_LT((slope - said).norm(), 0.2 * slope.norm())
      << slope.transpose() << " but it says " << said.transpose();
}

/// Edges that a pose of six unknowns would find: each holds one of these, 100 pixels to a radius or
/// a radian. Theirs is no offset, but for a trace that tells their errors apart.
std::vector<AlignmentRow> evenRows(int count) {
  std::vector<AlignmentRow> rows;
  for (int i = 0; i < count; ++i)
    rows.push_back({100.0 * Vector6d::Unit(i % 6), i % 4 < 2 ? 1e-7 : -1e-7, 0.0, 1.0});
  return rows;
}

ImagePose poseOf(const std::vector<AlignmentRow>& rows) {
  return imagePoseAt(rows, Vector6d::Zero(), kTukeyPx, Eigen::Isometry3d::Identity(), 0.05);
}

TEST(ImageAlignment, NarrowWallsAreTrustedLess) {
  for (const double wall_px : {0.0, 0.4, 6.1, 50.0}) EXPECT_EQ(trustOf(wall_px, 4.0), 1.0);
  for (const double wall_px : {0.6, 3.0, 5.9}) EXPECT_EQ(trustOf(wall_px, 4.0), 0.3) << wall_px;
  EXPECT_EQ(trustOf(5.9, 3.0), 1.0);  // out of a shorter reach
}

/// Tukey's biweight: nothing for an exact edge, the row's trust for an outlier, and the normal
/// equations lower it.
TEST(ImageAlignment, TheCostIsBoundedAndItsSlopeIsTheGradient) {
  const auto at = [](double residual_px, double trust) {
    return normalEquations({{Vector6d::Unit(0), 0.0, 0.0, trust}}, residual_px * Vector6d::Unit(0),
                           kTukeyPx);
  };
  EXPECT_EQ(at(0.0, 1.0).cost, 0.0);
  EXPECT_EQ(at(0.0, 1.0).used, 1);
  EXPECT_DOUBLE_EQ(at(0.0, 0.3).H(0, 0), 0.3);
  double last = 0.0;
  for (double r = 0.25; r < kTukeyPx; r += 0.25) {
    const NormalEquations here = at(r, 1.0);
    EXPECT_GT(here.cost, last) << r;
    last = here.cost;
    constexpr double kStep = 1e-5;
    const double slope = (at(r + kStep, 1.0).cost - at(r - kStep, 1.0).cost) / (2.0 * kStep);
    EXPECT_NEAR(slope, 6.0 / (kTukeyPx * kTukeyPx) * here.b(0), 1e-8) << r;
  }
  for (const double r : {1.1 * kTukeyPx, -1.3 * kTukeyPx, 10.0 * kTukeyPx}) {
    EXPECT_EQ(at(r, 0.3).cost, 0.3) << r;
    EXPECT_EQ(at(r, 0.3).used, 0) << r;
    EXPECT_TRUE(at(r, 0.3).b.isZero(0.0)) << r;
  }
}

/// Many rows at a time sum up to what single ones do.
TEST(ImageAlignment, TheEquationsAreThoseOfSingleRows) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const int count : {1, 15, 16, 53}) {
    std::vector<AlignmentRow> rows(count);
    NormalEquations expected;
    for (AlignmentRow& row : rows) {
      for (int i = 0; i < 6; ++i) row.J(i) = normal(random);
      row.offset = normal(random);
      row.trust = 0.7;
      const double e = 1.0 - row.offset * row.offset / (kTukeyPx * kTukeyPx);
      if (e > 0.0) expected.add(row.J, -row.offset, row.trust * e * e);
    }
    const NormalEquations here = normalEquations(rows, Vector6d::Zero(), kTukeyPx);
    EXPECT_TRUE(here.H.isApprox(expected.H, 1e-12)) << count;
    EXPECT_TRUE(here.b.isApprox(expected.b, 1e-12)) << count;
    EXPECT_EQ(here.used, expected.used) << count;
  }
}

/// However exact the edges look: each may be off by 0.22 pixels, and half of that variance is of
/// all alike that face the same way, half of all on one of eight pieces of the outline. Six
/// unknowns follow the 24 clusters.
TEST(ImageAlignment, TheCovarianceCountsWhatResidualsCannotTell) {
  // Along the outline, edges face one way after the other, or change with each edge.
  const auto variance_px2 = [](int ways, double aside_deg, bool in_turn) {
    auto rows = evenRows(240);
    for (int i = 0; i < 240; ++i) {
      const double facing = 2.0 * M_PI * (in_turn ? i % ways : i * ways / 240) / ways +
                            (i % 3 == 0 ? aside_deg : -aside_deg) * M_PI / 180.0;
      Vector6d& J = rows[static_cast<std::size_t>(i)].J;
      J.setZero();
      J.head<2>() = 100.0 * Eigen::Vector2d(std::cos(facing), std::sin(facing));
    }
    const Matrix6d covariance = poseOf(rows).covariance;
    if (ways > 2) {
      EXPECT_NEAR(covariance(0, 0), covariance(1, 1), 0.01 * covariance(0, 0));
    }
    return 1e4 * covariance(0, 0);
  };
  const double once = 0.22 * 0.22 * 24.0 / 18.0;
  EXPECT_NEAR(variance_px2(8, 0.0, false), once * (1.0 / 120.0 + 1.0 / 4.0), 1e-3 * once);
  EXPECT_NEAR(variance_px2(2, 0.0, false), once * (1.0 / 240.0 + 0.5 / 2.0 + 0.5 / 8.0),
              1e-3 * once);
  // Where each piece has all ways to face, no piece shifts the part.
  EXPECT_NEAR(variance_px2(8, 0.0, true), once * (1.0 / 120.0 + 0.5 / 4.0), 0.01 * once);
  // The drawing's axes are the middles of sides, not their borders.
  EXPECT_NEAR(variance_px2(1, 5.0, false), once * (1.0 / 240.0 + 0.5 + 0.5 / 8.0), 0.05 * once);
}

/// Of a tenth of a pixel, where half of the edges tell of a shift, by 100 pixels for a radius.
TEST(ImageAlignment, LightShiftsAPoseAcrossTheLineOfSight) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() << 0.0, 0.0, 0.7;
  const double variance = std::pow(0.1 / 50.0, 2);
  const Eigen::Vector3d across(variance, variance, 0.0);
  EXPECT_TRUE(lightVariance(evenRows(240), T).isApprox(across.asDiagonal().toDenseMatrix(), 1e-9));
  T.rotate(Eigen::AngleAxisd(M_PI / 2.0, Eigen::Vector3d::UnitX()));  // seen from its edge
  const Eigen::Vector3d turned(variance, 0.0, variance);
  EXPECT_TRUE(lightVariance(evenRows(240), T).isApprox(turned.asDiagonal().toDenseMatrix(), 1e-9));
  EXPECT_TRUE(lightVariance(std::vector<AlignmentRow>(9, {Vector6d::Zero(), 0.0, 0.0, 1.0}), T)
                  .isZero(0.0));
  const ImagePose aligned =
      poseFrom(shoot(sceneOf(bracketPlate(), kLie)), localPoints(*kBracket, 320, isShape));
  const double px_per_radius = 1700.0 * kBracket->radius() / 0.6;
  EXPECT_GT(aligned.covariance(0, 0), 0.7 * std::pow(0.1 / px_per_radius, 2));
}

TEST(ImageAlignment, HowFarOffAnOutlierIsDoesNotMatter) {
  const auto with = [](double factor) {
    auto rows = evenRows(240);
    for (std::size_t i = 0; i < rows.size(); i += 11) rows[i].offset = factor * kTukeyPx;
    for (auto& row : rows) row.out_px = 100.0;
    return poseOf(rows);
  };
  const ImagePose near = with(1.2), far = with(50.0);
  EXPECT_EQ(near.used, 240 - 22);
  EXPECT_EQ(far.used, near.used);
  EXPECT_EQ(far.covariance, near.covariance);
  EXPECT_EQ(far.residual_px, near.residual_px);
}

/// Of edges that tell nothing of the pose: noise of a tenth of a pixel at least, and each of the
/// eight sides may be off by a tenth.
TEST(ImageAlignment, TheEdgeOffsetIsAsSureAsItsEdgesAndSides) {
  constexpr double kOutPx = 100.0;
  for (const double inside : {0.0, 0.0005, -0.0005}) {
    const std::vector<AlignmentRow> rows(80, {Vector6d::Zero(), -inside * kOutPx, kOutPx, 1.0});
    const ImagePose pose = poseOf(rows);
    EXPECT_NEAR(pose.offset, inside, 1e-9);
    EXPECT_TRUE(pose.per_offset.isZero(0.0));
    const double sigma = std::hypot(0.1 / std::sqrt(80.0), 0.1 / std::sqrt(8.0)) / kOutPx;
    EXPECT_NEAR(pose.offset_sigma, sigma, 0.01 * sigma);
  }
}

/// Errors against what the covariance says of them, over many pictures of ten points each.
TEST(ImageAlignment, FewEdgesAreJudgedHonestly) {
  double sum = 0.0;
  constexpr int kPictures = 20;
  for (int seed = 1; seed <= kPictures; ++seed) {
    sim::Scene scene = sceneOf(bracketPlate(), kLie);
    scene.seed = seed;
    scene.noise = 6.0;
    std::vector<LocalPoint> points;
    const auto all = localPoints(*kBracket, 320, isShape);
    for (std::size_t i = 0; i < 10; ++i)
      points.push_back(
          all[(7u * static_cast<std::size_t>(seed) + i * all.size() / 10) % all.size()]);
    const ImagePose pose = poseFrom(shoot(scene), points);
    if (pose.used < kFewEdges) {
      EXPECT_TRUE(pose.covariance.isApprox(Matrix6d::Identity()));
      continue;
    }
    const Eigen::Isometry3d off =
        pose.T_camera_centre.inverse() * sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
    const Eigen::AngleAxisd turn(off.linear());
    Vector6d xi;
    xi << off.translation() / kBracket->radius(), turn.angle() * turn.axis();
    sum += xi.dot(pose.covariance.ldlt().solve(xi));
  }
  EXPECT_LT(sum / kPictures, 2.0 * 6.0);  // 6 per picture where it is exact
}

}  // namespace
}  // namespace planar_bin_picking
