// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "views/view_starts.h"

#include "support/looked_bracket.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

class ViewStarts : public testing::Test {
 protected:
  ViewPtr from(const Eigen::Isometry3d& T_first_view) const {
    return viewOf(bracketAt(sim::poseOf(kLie)), T_first_view, 2);
  }
  /// How far the part lies from where it was thought to be, along the first camera's ray.
  double depthOf(const Eigen::Isometry3d& T) const {
    return (T.translation() - truth_.translation()).dot(truth_.translation().normalized());
  }

  const SeenPart seen_{*kBracket, Face::kFront, {}};
  const Eigen::Isometry3d truth_ = sim::poseOf(kLie) * centreOf(*kBracket, Face::kFront);
  const Eigen::Isometry3d T_first_view_ = orbit(kCentre, 30, 20);
  const ViewPtr view_ = from(T_first_view_);
};

TEST_F(ViewStarts, ReachAllDepthsInSmallSteps) {
  constexpr double kReach = 0.02;
  const auto starts = startsAbout(seen_, truth_, *view_, kReach);
  ASSERT_GT(starts.size(), 8u);
  EXPECT_TRUE(starts.front().isApprox(truth_, 1e-12));  // the pose itself first
  std::vector<double> depths, other_tilt;
  for (const Eigen::Isometry3d& T : starts) {
    EXPECT_LT(T.translation().cross(truth_.translation()).norm(), 1e-9);  // on the ray
    const bool is_same = (T.linear() - truth_.linear()).norm() < 1e-9;
    (is_same ? depths : other_tilt).push_back(depthOf(T));
  }
  EXPECT_EQ(depths.size(), other_tilt.size());
  for (auto* list : {&depths, &other_tilt}) {
    std::sort(list->begin(), list->end());
    EXPECT_NEAR(list->front(), -kReach, 1e-9);
    EXPECT_NEAR(list->back(), kReach, 1e-9);
    const auto pixel = [&](double depth) {
      const Eigen::Vector3d x = truth_.translation() + depth * truth_.translation().normalized();
      return view_->camera().project(T_first_view_.inverse() * x);
    };
    for (std::size_t i = 1; i < list->size(); ++i) {
      const double step = (pixel((*list)[i]) - pixel((*list)[i - 1])).norm();
      EXPECT_LT(step, 11.0) << i;
      EXPECT_GT(step, 4.0) << i;
    }
  }
}

/// From far away the first view could not tell the two.
TEST_F(ViewStarts, TheOtherTiltLooksTheSameInTheFirstView) {
  const auto looks = [](const Eigen::Isometry3d& T) {
    const Eigen::Vector2d p = T.translation().hnormalized();
    Eigen::Matrix<double, 2, 3> project;
    project << 1, 0, -p.x(), 0, 1, -p.y();
    const Eigen::Matrix2d A = project * T.linear().leftCols<2>();
    return Eigen::Matrix2d(A / A.norm());
  };
  int others = 0;
  for (const Eigen::Isometry3d& T : startsAbout(seen_, truth_, *view_, 0.02)) {
    if ((T.linear() - truth_.linear()).norm() < 1e-9) continue;
    ++others;
    EXPECT_GT((T.linear().col(2) - truth_.linear().col(2)).norm(), 0.2);
    EXPECT_TRUE(looks(T).isApprox(looks(truth_), 1e-6));
  }
  EXPECT_GT(others, 4);
}

TEST_F(ViewStarts, AreFewAndBeforeTheCamera) {
  EXPECT_LE(startsAbout(seen_, truth_, *view_, 0.2).size(), 50u);
  EXPECT_GT(startsAbout(seen_, truth_, *view_, 0.2).size(), 40u);
  // From the same place no depth looks otherwise.
  const auto same = startsAbout(seen_, truth_, *from(Eigen::Isometry3d::Identity()), 0.02);
  ASSERT_GE(same.size(), 1u);
  EXPECT_LE(same.size(), 2u);
  EXPECT_TRUE(startsAbout(seen_, truth_, *view_, 0.4).empty());  // as near as the camera
  // Seen from behind it is another face.
  EXPECT_TRUE(startsAbout(seen_, truth_, *from(orbit(kCentre, 150, 20)), 0.02).empty());
}

TEST_F(ViewStarts, TheBestIsWhereThePartIs) {
  Eigen::Isometry3d deep = truth_;
  deep.translation() *= 1.0 + 0.01 / kCentre.norm();
  const auto starts = startsAbout(seen_, deep, *view_, 0.02);
  const auto best = bestStarts(seen_, *view_, 0.0, starts, 1);
  ASSERT_FALSE(best.empty());
  EXPECT_LE(best.size(), 4u);
  EXPECT_TRUE(isometryNear(best[0].own.T_camera_centre, T_first_view_.inverse() * truth_, 1e-3,
                           1.0 * kDegrees));
  EXPECT_GT(best[0].score, 0.8);
  EXPECT_NEAR(depthOf(best[0].T_first_centre), 0.0, 5e-3);
  for (std::size_t i = 0; i < best.size(); ++i) {
    EXPECT_EQ(best[i].own.status, AlignmentStatus::kAligned);
    EXPECT_GT(best[i].score, best[0].score - 0.5);
    for (std::size_t k = 0; k < i; ++k) {  // each another place, or another tilt
      const Eigen::Isometry3d &a = best[i].own.T_camera_centre, &b = best[k].own.T_camera_centre;
      EXPECT_TRUE((a.translation() - b.translation()).norm() > 0.5e-3 ||
                  (a.linear().col(2) - b.linear().col(2)).norm() > 0.03);
    }
  }
  const auto with_threads = bestStarts(seen_, *view_, 0.0, starts, 2);
  ASSERT_EQ(with_threads.size(), best.size());
  for (std::size_t i = 0; i < best.size(); ++i) EXPECT_EQ(with_threads[i].score, best[i].score);
  EXPECT_TRUE(bestStarts(seen_, *view_, 0.0, {}, 2).empty());
}

TEST_F(ViewStarts, ScoreIsTheShareThatIsBorneOut) {
  const auto score = [&](const Eigen::Isometry3d& T_first_centre) {
    return scoreIn(seen_, *view_, T_first_view_.inverse() * T_first_centre, seen_.fine);
  };
  EXPECT_GT(score(truth_), 0.9);
  Eigen::Isometry3d aside = truth_;
  aside.translation() += 0.005 * T_first_view_.linear().col(0);
  EXPECT_LT(score(aside), 0.5);
  const Eigen::Isometry3d turned = truth_ * Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
  EXPECT_EQ(score(turned), 0.0);  // its back
}

}  // namespace
}  // namespace planar_bin_picking
