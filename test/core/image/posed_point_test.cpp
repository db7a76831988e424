// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image/posed_point.h"

#include "support/matchers.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <random>

namespace planar_bin_picking {
namespace {

constexpr double kRadius = 0.045;

Camera wideAngle() {
  Camera::Model model;
  model.width = 1280;
  model.height = 960;
  model.fx = 640.0;
  model.fy = 645.0;
  model.cx = 655.0;
  model.cy = 470.0;
  model.distortion_model = "rational_polynomial";
  model.distortion = {5.2, 3.1, 1e-3, -8e-4, 0.2, 5.5, 4.6, 0.9};
  return Camera(model);
}

struct Case {
  LocalPoint point;
  Eigen::Isometry3d T_camera_centre;
};

/// Points of an outline of either face, tilted by up to 50 degrees, all over the image.
std::vector<Case> randomCases() {
  std::mt19937 random(3);
  const auto uniform = [&random](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Case> out;
  for (int i = 0; i < 100; ++i) {
    const double angle = uniform(0.0, 6.28);
    out.push_back({{uniform(-1.0, 1.0), uniform(-1.0, 1.0), std::cos(angle), std::sin(angle), 0},
                   sim::poseOf({uniform(-120, 120), uniform(-90, 90), uniform(400, 700),
                                uniform(0, 360), uniform(0, 50), uniform(0, 360), i % 2 == 0})});
  }
  return out;
}

std::vector<Camera> cameras() { return {makeCamera({}), wideAngle()}; }

PosedPoint posed(const Camera& camera, const LocalPoint& p, const Eigen::Isometry3d& T) {
  PosedPoint at;
  EXPECT_TRUE(posePoint(camera, p, kRadius, T, &at));
  return at;
}

TEST(PosedPoint, JacobianEqualsDifferences) {
  for (const Camera& camera : cameras()) {
    for (const Case& c : randomCases()) {
      const PosedPoint at = posed(camera, c.point, c.T_camera_centre);
      const auto along = [&](const Vector6d& xi) -> Eigen::Matrix<double, 1, 1> {
        const Eigen::Isometry3d T = stepped(c.T_camera_centre, xi, kRadius);
        return Eigen::Matrix<double, 1, 1>(at.normal.dot(posed(camera, c.point, T).pixel));
      };
      const Vector6d zero = Vector6d::Zero();
      const Vector6d numeric = numericJacobian(along, zero, 1e-5).transpose();
      const Vector6d J = normalJacobian(c.point, at);
      // A hundred pixels per unit, third derivatives alike: differences are good to 1e-6 relative.
      EXPECT_LT((J - numeric).norm(), 1e-5 * numeric.norm());
    }
  }
}

TEST(PosedPoint, PixelsPerRadiusOutOfTheMaterialEqualDifferences) {
  constexpr double kStep = 1e-5;
  for (const Camera& camera : cameras()) {
    for (const Case& c : randomCases()) {
      const PosedPoint at = posed(camera, c.point, c.T_camera_centre);
      const auto moved = [&](double out) {
        LocalPoint p = c.point;
        p.x += out * p.ty;
        p.y -= out * p.tx;
        return at.normal.dot(posed(camera, p, c.T_camera_centre).pixel);
      };
      const double numeric = (moved(kStep) - moved(-kStep)) / (2.0 * kStep);
      EXPECT_NEAR(at.out_px, numeric, 1e-5 * numeric);
      EXPECT_GT(at.out_px, 0.0);  // the normal points out of the material
    }
  }
}

TEST(PosedPoint, PixelsPerRadiusOfDepthEqualDifferences) {
  constexpr double kStep = 1e-5;
  for (const Camera& camera : cameras()) {
    for (const Case& c : randomCases()) {
      const PosedPoint at = posed(camera, c.point, c.T_camera_centre);
      const auto deeper = [&](double z) {
        const Eigen::Isometry3d T = c.T_camera_centre * Eigen::Translation3d(0.0, 0.0, kRadius * z);
        return at.normal.dot(posed(camera, c.point, T).pixel);
      };
      const double numeric = (deeper(kStep) - deeper(-kStep)) / (2.0 * kStep);
      EXPECT_NEAR(at.deep_px, numeric, 1e-4);
    }
  }
}

TEST(PosedPoint, TheNormalIsAcrossTheImageOfTheTangent) {
  constexpr double kStep = 1e-5;
  for (const Camera& camera : cameras()) {
    for (const Case& c : randomCases()) {
      const PosedPoint at = posed(camera, c.point, c.T_camera_centre);
      LocalPoint on = c.point;
      on.x += kStep * on.tx;
      on.y += kStep * on.ty;
      const Eigen::Vector2d step = posed(camera, on, c.T_camera_centre).pixel - at.pixel;
      EXPECT_LT(std::abs(step.normalized().dot(at.normal)), 1e-4);
      EXPECT_NEAR(at.normal.norm(), 1.0, 1e-12);
    }
  }
}

TEST(PosedPoint, TheSimulatedCameraAgrees) {
  const sim::PinholeCamera camera;
  for (const Case& c : randomCases()) {
    const Eigen::Vector3d p(kRadius * c.point.x, kRadius * c.point.y, 0.0);
    const PosedPoint at = posed(makeCamera(camera), c.point, c.T_camera_centre);
    EXPECT_LT((sim::project(camera, c.T_camera_centre * p) - at.pixel).norm(), 1e-9);
  }
}

TEST(PosedPoint, NothingBehindTheCamera) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation().z() = -0.5;
  PosedPoint at;
  EXPECT_FALSE(posePoint(makeCamera({}), {0.1, 0.2, 1.0, 0.0, 0}, kRadius, T, &at));
}

}  // namespace
}  // namespace planar_bin_picking
