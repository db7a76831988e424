// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "views/joint_pose.h"

#include "support/looked_bracket.h"
#include "support/matchers.h"
#include "views/camera_errors.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

std::vector<ViewPtr> twoViews() {
  const sim::Scene scene = bracketAt(sim::poseOf(kLie));
  return {viewOf(scene, Eigen::Isometry3d::Identity(), 1),
          viewOf(scene, orbit({0.02, -0.01, 0.6}, 35, 70), 1)};
}

JointState stateAt(const Eigen::Isometry3d& T) { return {T, {{}, {}}, {0.0, 0.0}}; }

/// The joint problem's only derivatives that are not those of one view.
TEST(JointPose, StepsFollowTheCorrection) {
  const auto views = twoViews();
  const double r = kBracket->radius();
  JointState state = stateAt(sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront));
  state.corrections = {Vector6d::Zero(), Vector6d::Zero()};
  const Eigen::Isometry3d here = viewPose(state, views, 1);
  const auto step = [&](const Vector6d& c) -> Vector6d {
    JointState other = state;
    other.corrections[1] = c;
    Vector6d xi = log(here.inverse() * viewPose(other, views, 1));
    xi.head<3>() /= r;
    return xi;
  };
  const Matrix6d numeric = numericJacobian(step, Vector6d(Vector6d::Zero()), 1e-6);
  EXPECT_TRUE(stepByCorrection(here, r).isApprox(numeric, 1e-6));
}

/// What a row says of the new view's own step is, through both, what it says of the joint unknowns.
TEST(JointPose, RowsFollowPoseAndCorrection) {
  const auto views = twoViews();
  const double r = kBracket->radius();
  JointState state = stateAt(sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront));
  state.corrections = {Vector6d::Zero(), Vector6d::Zero()};
  const SeenPart seen(*kBracket, Face::kFront, {});
  for (std::size_t i = 0; i < seen.coarse.size(); i += 7) {
    PosedPoint at;
    ASSERT_TRUE(posePoint(views[1]->camera(), seen.coarse[i], r, viewPose(state, views, 1), &at));
    const auto along = [&](const Eigen::Matrix<double, 12, 1>& x) {
      JointState other = state;
      other.T_first_centre = stepped(state.T_first_centre, x.head<6>(), r);
      other.corrections[1] = x.tail<6>();
      const Eigen::Vector3d p = viewPose(other, views, 1) *
                                (r * Eigen::Vector3d(seen.coarse[i].x, seen.coarse[i].y, 0.0));
      return Eigen::Matrix<double, 1, 1>(at.normal.dot(views[1]->camera().project(p)));
    };
    const auto numeric = numericJacobian(
        along, Eigen::Matrix<double, 12, 1>(Eigen::Matrix<double, 12, 1>::Zero()), 1e-6);
    const Vector6d J = normalJacobian(seen.coarse[i], at);
    EXPECT_TRUE(J.transpose().isApprox(numeric.leftCols<6>(), 1e-4));
    EXPECT_TRUE((J.transpose() * stepByCorrection(viewPose(state, views, 1), r))
                    .isApprox(numeric.rightCols<6>(), 1e-4));
    // Farther inside by the edge offset, the outline's image moves against its normal.
    constexpr double kInside = 1e-4;
    PosedPoint inside;
    ASSERT_TRUE(posePoint(views[1]->camera(), inward({seen.coarse[i]}, kInside).front(), r,
                          viewPose(state, views, 1), &inside));
    EXPECT_NEAR(at.normal.dot(inside.pixel - at.pixel) / kInside, -at.out_px, 1e-3 * at.out_px);
  }
}

TEST(JointPose, ComesBackFromAFewPixels) {
  const auto views = twoViews();
  const Eigen::Isometry3d truth = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  const SeenPart seen(*kBracket, Face::kFront, {});
  const JointAlignment alignment(seen, views, 0.0, {});
  const Eigen::Isometry3d start =
      truth * exp((Vector6d() << 1e-3, -1e-3, 3e-3, 0.03, 0.03, -0.02).finished());
  const JointPose pose = alignment.align(alignment.startAt(start));
  EXPECT_TRUE(isometryNear(pose.state.T_first_centre, truth, 0.1e-3, 0.1 * kDegrees));
  EXPECT_EQ(pose.used.size(), 2u);
  EXPECT_EQ(pose.freedom, 8);
  EXPECT_LT(pose.chi_squared, 16.0);
}

/// Light makes another one from each side.
TEST(JointPose, EachViewHasItsOwnEdgeOffset) {
  const Eigen::Isometry3d T = sim::poseOf(kLie), T_view = orbit(kCentre, 35, 70);
  sim::Scene less = bracketAt(T), more = bracketAt(T);
  less.plates[0].plate = smallerBracket(0.05);
  more.plates[0].plate = smallerBracket(0.20);
  const std::vector<ViewPtr> views = {viewOf(less, Eigen::Isometry3d::Identity(), 1),
                                      viewOf(more, T_view, 2)};
  const SeenPart seen(*kBracket, Face::kFront, {});
  const JointAlignment alignment(seen, views, 0.12e-3, {});
  const JointPose pose = alignment.align(alignment.startAt(T * seen.T_part_centre));
  const double r = kBracket->radius();
  EXPECT_NEAR(r * pose.state.offsets[0], 0.05e-3, 0.06e-3);
  EXPECT_NEAR(r * pose.state.offsets[1], 0.20e-3, 0.06e-3);
}

TEST(JointPose, TheFaceLiesAboveItsBrokenEdges) {
  JointState state = stateAt(sim::poseOf(kLie));
  const double r = 0.05;
  state.offsets = {0.1e-3 / r, 0.3e-3 / r};
  const auto height = [&](Face face) {
    return (state.T_first_centre.inverse() * facePose(state, face, r)).translation().z();
  };
  EXPECT_NEAR(height(Face::kFront), 0.2e-3, 1e-9);
  EXPECT_NEAR(height(Face::kBack), -0.2e-3, 1e-9);
  state.offsets = {-0.1e-3 / r, 0.0};
  EXPECT_EQ(height(Face::kFront), 0.0);
}

/// Of robots, pixels and views that are as good as can be, the edge's break is left; of the middle
/// between two edges half of its variance, of the face's height four times as much.
TEST(JointPose, NothingIsBetterThanTheBreak) {
  const Matrix6d C = leastCovariance(0.05, 0.6, 4000.0);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(0.05 * std::sqrt(C(i, i)), 0.0306e-3, 0.0005e-3);
  EXPECT_NEAR(0.05 * std::sqrt(C(2, 2)), 0.0866e-3, 0.0005e-3);
  for (int i = 3; i < 6; ++i) EXPECT_NEAR(std::sqrt(C(i, i)), 0.02 * 0.6 / (4000.0 * 0.05), 1e-9);
  const Matrix6d coarse = leastCovariance(0.05, 0.6, 400.0);
  EXPECT_NEAR(std::sqrt(coarse(5, 5)), 10.0 * std::sqrt(C(5, 5)), 1e-9);
}

/// The face's place follows the offsets, so it is as unsure as they are, and as both together.
TEST(JointPose, TheFaceIsAsUnsureAsItsEdges) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Identity(20, 20);
  const auto depth = [&](Face face) { return faceCovariance(C, 2, face)(2, 2); };
  EXPECT_NEAR(depth(Face::kFront), 1.0 + 0.5, 1e-12);  // the mean of two offsets
  C(2, 19) = C(19, 2) = 0.4;
  EXPECT_NEAR(depth(Face::kFront), 1.5 + 0.4, 1e-12);
  EXPECT_NEAR(depth(Face::kBack), 1.5 - 0.4, 1e-12);
  C(2, 17) = C(17, 2) = 0.4;  // a camera's correction, no offset
  EXPECT_NEAR(depth(Face::kFront), 1.9, 1e-12);
  C(5, 18) = C(18, 5) = 0.2;
  EXPECT_NEAR(faceCovariance(C, 2, Face::kFront)(5, 2), 0.1, 1e-12);
  EXPECT_TRUE(faceCovariance(C, 2, Face::kFront).topLeftCorner(2, 2).isIdentity(1e-12));
}

/// Against what as many shaken robots do.
TEST(CameraErrors, AreThoseOfRobotAndHandEye) {
  ViewsParams params;
  params.robot_sigma = 0.3e-3;
  params.robot_sigma_deg = 0.05;
  params.hand_eye_sigma = 0.5e-3;
  params.hand_eye_sigma_deg = 0.08;
  const std::vector<Eigen::Isometry3d> views = {orbit({0.02, -0.01, 0.6}, 35, 70),
                                                orbit({0.02, -0.01, 0.5}, -25, 10)};
  std::mt19937 random(3);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(12, 12);
  constexpr int kRobots = 4000;
  const Eigen::Isometry3d same = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kRobots; ++i) {
    const auto x = shaken(same, params.hand_eye_sigma, params.hand_eye_sigma_deg, &random);
    const auto first = shaken(same, params.robot_sigma, params.robot_sigma_deg, &random);
    Eigen::Matrix<double, 12, 1> c;
    for (int k = 0; k < 2; ++k) {
      const auto robot = shaken(same, params.robot_sigma, params.robot_sigma_deg, &random);
      const Eigen::Isometry3d truth = x.inverse() * first.inverse() * views[k] * robot * x;
      c.segment<6>(6 * k) = log(views[k].inverse() * truth);
    }
    sum += c * c.transpose();
  }
  const Eigen::MatrixXd said = correctionCovariance(views, params, 1e9);
  EXPECT_LT((sum / kRobots - said).norm(), 0.1 * said.norm());
  const Eigen::VectorXd ratio = (sum / kRobots).diagonal().cwiseQuotient(said.diagonal());
  EXPECT_GT(ratio.minCoeff(), 0.85);
  EXPECT_LT(ratio.maxCoeff(), 1.15);
}

}  // namespace
}  // namespace planar_bin_picking
