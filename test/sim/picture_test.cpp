// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The simulated camera against OpenCV's projection, which neither it nor the localizer uses.

#include "sim/picture.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;

Lens bentLens() {
  Lens lens;
  lens.width = 640, lens.height = 512;
  lens.fx = 900.0, lens.fy = 896.0, lens.cx = 322.4, lens.cy = 250.7;
  lens.d = {-0.12, 0.08, 6e-4, -4e-4, 0.02};
  return lens;
}

/// plumb_bob as OpenCV's documentation of calib3d states it, in long form.
Eigen::Vector2d asOpenCvStates(const Lens& lens, const Eigen::Vector3d& p) {
  const double x = p.x() / p.z(), y = p.y() / p.z(), r = std::sqrt(x * x + y * y);
  const double k =
      1.0 + lens.d[0] * std::pow(r, 2) + lens.d[1] * std::pow(r, 4) + lens.d[4] * std::pow(r, 6);
  const double u = x * k + 2.0 * lens.d[2] * x * y + lens.d[3] * (r * r + 2.0 * x * x);
  const double v = y * k + lens.d[2] * (r * r + 2.0 * y * y) + 2.0 * lens.d[3] * x * y;
  return {lens.fx * u + lens.cx, lens.fy * v + lens.cy};
}

TEST(Lens, ProjectsAsItIsDefinedAndBack) {
  const Lens lens = bentLens();
  for (double u = 0.0; u < 640.0; u += 63.0) {
    for (double v = 0.0; v < 512.0; v += 57.0) {
      const Eigen::Vector3d ray = rayOf(lens, u, v);
      EXPECT_NEAR((asOpenCvStates(lens, 0.7 * ray) - Eigen::Vector2d(u, v)).norm(), 0.0, 1e-8);
      EXPECT_NEAR((pixelOf(lens, 2.0 * ray) - Eigen::Vector2d(u, v)).norm(), 0.0, 1e-8);
    }
  }
}

/// A square plate of 20 mm in the air, before a camera that looks down from 0.5 m.
struct Scene {
  Lens lens = bentLens();
  Mesh mesh =
      makeMesh({{{-0.01, -0.01}, {0.01, -0.01}, {0.01, 0.01}, {-0.01, 0.01}}, {}, 0.00005}, 1e-6);
  Raycaster world{{mesh}};
  Looks looks;
  Eigen::Isometry3d T_base_camera = Eigen::Isometry3d::Identity();

  explicit Scene(const Eigen::Isometry3d& T_base_part) {
    T_base_camera.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
    T_base_camera.translation() = Eigen::Vector3d(0.0, 0.0, 0.5);
    world.place({{0, T_base_part}});
    Material flat;
    flat.grain = 0.0f;
    looks = {{flat}, {T_base_part.inverse()}, {1u}};
  }
  cv::Mat_<float> look(const std::string& light) const {
    return Eye(lens).look(world, looks, makeLamps(light, T_base_camera), T_base_camera);
  }
};

TEST(Eye, SeesAPlateWhereTheLensPutsIt) {
  for (const double x : {-0.12, 0.0, 0.13}) {
    Eigen::Isometry3d T_base_part = Eigen::Isometry3d::Identity();
    T_base_part.translation() = Eigen::Vector3d(x, 0.5 * x + 0.01, 0.0);
    T_base_part.linear() = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    const Scene scene(T_base_part);
    const cv::Mat_<float> light = scene.look("diffuse");
    // Centre of mass of what is bright, whose shade does not count.
    double sum = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    double brightest = 0.0;
    cv::minMaxLoc(light, nullptr, &brightest);
    for (int v = 0; v < light.rows; ++v) {
      for (int u = 0; u < light.cols; ++u) {
        const double weight = std::min(1.0, std::max(0.0, light(v, u) - 0.02) / (0.5 * brightest));
        sum += weight;
        mean += weight * Eigen::Vector2d(u, v);
      }
    }
    Eigen::Vector2d expected = Eigen::Vector2d::Zero();
    int count = 0;
    for (double a = -0.0095; a < 0.01; a += 0.001) {
      for (double b = -0.0095; b < 0.01; b += 0.001, ++count) {
        expected += asOpenCvStates(
            scene.lens, scene.T_base_camera.inverse() * T_base_part * Eigen::Vector3d(a, b, 0.0));
      }
    }
    // A tenth of a pixel, where the square has 36 and its edges nine rays per pixel.
    EXPECT_NEAR((mean / sum - expected / count).norm(), 0.0, 0.12) << x;
  }
}

TEST(Eye, CastsShadows) {
  Eigen::Isometry3d T_high = Eigen::Isometry3d::Identity(), T_low = T_high;
  T_high.translation() = Eigen::Vector3d(0.0, 0.0, 0.012);
  T_low.linear() *= 1.0;
  Scene scene(T_low);
  const Mesh ground =
      makeMesh({{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}}, {}, 0.002}, 1e-5);
  Raycaster world({scene.mesh, ground});
  world.place({{0, T_high}, {1, T_low}});
  Material flat;
  flat.grain = 0.0f;
  const Looks looks{{flat, flat}, {T_high.inverse(), T_low.inverse()}, {1u, 2u}};
  const auto light =
      Eye(scene.lens)
          .look(world, looks, makeLamps("side", scene.T_base_camera), scene.T_base_camera);
  // The lamp stands at the right, so the shadow falls to the left of the plate.
  const auto at = [&](double x) {
    const Eigen::Vector2d p =
        pixelOf(scene.lens, scene.T_base_camera.inverse() * Eigen::Vector3d(x, 0.0, 0.0));
    return light(static_cast<int>(p.y()), static_cast<int>(p.x()));
  };
  EXPECT_LT(at(-0.014), 0.6f * at(0.016));
}

TEST(Eye, IsTheSameEveryTime) {
  const Scene scene(Eigen::Isometry3d::Identity());
  const auto light = scene.look("ring");
  EXPECT_EQ(cv::norm(light, scene.look("ring"), cv::NORM_INF), 0.0);
  EXPECT_EQ(
      cv::norm(expose(light, Sensor(), 0.01, 4), expose(light, Sensor(), 0.01, 4), cv::NORM_INF),
      0.0);
  EXPECT_GT(
      cv::norm(expose(light, Sensor(), 0.01, 4), expose(light, Sensor(), 0.01, 5), cv::NORM_INF),
      0.0);
}

TEST(Sensor, CountsPhotons) {
  const cv::Mat_<float> grey(200, 200, 0.4f);
  Sensor sensor;
  sensor.blur_px = 0.0;
  cv::Scalar mean, deviation;
  cv::meanStdDev(expose(grey, sensor, 0.01, 1), mean, deviation);
  EXPECT_NEAR(mean[0], 0.4 * 255.0, 0.3);
  // 4000 electrons: 63 of photon noise and 5 of reading, 39.2 to a grey level; and rounding.
  EXPECT_NEAR(deviation[0], std::sqrt((4000.0 + 25.0) / (39.2 * 39.2) + 1.0 / 12.0), 0.05);
  cv::meanStdDev(expose(grey, sensor, 0.05, 1), mean, deviation);
  EXPECT_EQ(mean[0], 255.0);
}

TEST(Sensor, FindsItsExposure) {
  cv::Mat_<float> grey(100, 100, 0.2f);
  grey.rowRange(0, 10) = 2.0f;  // one tenth is bright
  const double seconds = exposureFor(grey, Sensor(), 80.0);
  EXPECT_NEAR(seconds * Sensor().light_per_second * 0.2, 0.85, 1e-6);
}

TEST(Lamps, RefuseUnknownNames) {
  EXPECT_THROW(makeLamps("candle", Eigen::Isometry3d::Identity()), std::invalid_argument);
  EXPECT_THROW(material("wood"), std::invalid_argument);
}

}  // namespace
}  // namespace planar_bin_picking::cell
