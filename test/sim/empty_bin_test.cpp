// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Whether a bin is empty, on pictures of the simulated cell.

#include "planar_bin_picking/bin/floor_cover.h"
#include "sim/simulated_cell.h"

#include <gtest/gtest.h>

#include <string>

namespace planar_bin_picking::cell {
namespace {

constexpr double kMark = 0.02;  // metres, as the cell's default

FloorCover look(const std::string& light, int brackets) {
  CellConfig config;
  config.light = light;
  config.counts = {brackets};
  config.lens.width = 640, config.lens.height = 512;
  config.lens.fx = config.lens.fy = 900.0, config.lens.cx = 319.5, config.lens.cy = 255.5;
  SimulatedCell cell(config,
                     {loadPartKind(std::string(PACKAGE_DIR) + "/test/data/parts/bracket.yaml")});
  Eigen::Isometry3d T_base_camera = Eigen::Isometry3d::Identity();
  T_base_camera.translation().z() = 0.75;
  T_base_camera.linear() =
      Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const cv::Mat image = cell.takePicture(T_base_camera, cell.exposureFor(T_base_camera));
  Camera::Model model;
  model.width = config.lens.width, model.height = config.lens.height;
  model.fx = model.fy = config.lens.fx, model.cx = config.lens.cx, model.cy = config.lens.cy;
  const Bin& bin = config.bin;
  return findFloorCover(image, Camera(model),
                        {T_base_camera.inverse(),
                         {-0.5 * bin.length, -0.5 * bin.width, 0.0},
                         {0.5 * bin.length, 0.5 * bin.width, bin.height}});
}

TEST(EmptyBin, IsToldFromOneWithAPart) {
  for (const std::string light : {"diffuse", "ring"}) {
    const FloorCover empty = look(light, 0), one = look(light, 1), four = look(light, 4);
    EXPECT_TRUE(empty.isEmpty(kMark)) << light << empty.longest << empty.doubt;
    EXPECT_FALSE(one.isEmpty(kMark)) << light;
    EXPECT_LT(empty.covered, 0.01) << light;
    EXPECT_NEAR(one.covered, 0.055, 0.01) << light;   // 5027 mm2 and its edges
    EXPECT_NEAR(four.covered, 0.206, 0.03) << light;  // four times that
  }
}

// The walls' shadow is so deep that a part in it could not be seen.
TEST(EmptyBin, IsInDoubtInADeepShadow) { EXPECT_FALSE(look("side", 0).isEmpty(kMark)); }

}  // namespace
}  // namespace planar_bin_picking::cell
