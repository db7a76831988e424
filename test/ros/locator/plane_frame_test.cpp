// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/plane_frame.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::Plane;
using planar_bin_picking::refuses;

/// A belt's frame below a camera that looks down on it, leaning by `tilt`.
Eigen::Isometry3d belowCamera(const double height, const double tilt) {
  const Eigen::AngleAxisd down(M_PI + tilt, Eigen::Vector3d::UnitX());
  return (Eigen::Translation3d(0.1, 0.2, height) * down).inverse();
}

TEST(PlaneFrame, IsTheSameWhicheverWayZPoints) {
  const Eigen::Isometry3d T_camera_belt = belowCamera(0.7, 0.2);
  const Plane up = planeOfFrame("belt", T_camera_belt);
  EXPECT_NEAR(up.distance, 0.7, 1e-12);
  EXPECT_NEAR(up.normal_camera.z(), -std::cos(0.2), 1e-12);
  // Any point of the belt lies on it.
  const Eigen::Vector3d x_camera = T_camera_belt * Eigen::Vector3d(0.3, -0.5, 0.0);
  EXPECT_NEAR(up.normal_camera.dot(x_camera), -up.distance, 1e-12);
  const Plane down =
      planeOfFrame("belt", T_camera_belt * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  EXPECT_NEAR(down.distance, up.distance, 1e-12);
  EXPECT_TRUE(down.normal_camera.isApprox(up.normal_camera));
}

TEST(PlaneFrame, RefusesWhatCannotBeSeen) {
  EXPECT_TRUE(refuses([] { planeOfFrame("belt", belowCamera(0.0, 0.0)); },
                      {"belt", "0.000 m", "plane_frame"}));
  EXPECT_TRUE(refuses([] { planeOfFrame("belt", belowCamera(0.7, 1.55)); }, {"89 degrees"}));
  // Behind the camera: its z looks away from the belt.
  EXPECT_TRUE(refuses([] { planeOfFrame("belt", belowCamera(-0.7, 0.0)); }, {"180 degrees"}));
}

TEST(PlaneFrame, RefusesTwoPlanes) {
  CellParams cell;
  planar_bin_picking::PlaneParams params;
  params.distance = 0.7;
  EXPECT_NO_THROW(checkOnePlane(cell, params));
  cell.plane_frame = "belt";
  EXPECT_TRUE(refuses([&] { checkOnePlane(cell, params); }, {"plane_frame", "plane/distance"}));
  params.distance = 0.0;
  EXPECT_NO_THROW(checkOnePlane(cell, params));
}

TEST(PlaneFrame, RefusesAPlaneOutsideOfTheDistances) {
  planar_bin_picking::Camera::Model model;
  model.width = 1280, model.height = 1024, model.fx = model.fy = 1500.0, model.cx = 640.0,
  model.cy = 512.0;
  const planar_bin_picking::Camera camera(model);
  planar_bin_picking::LocateRequest request;
  request.parts = {std::make_shared<const planar_bin_picking::PartModel>(
      planar_bin_picking::loadPartFile(std::string(PACKAGE_DIR) + "/test/data/parts/hinge.yaml"))};
  request.distance_min = 0.6, request.distance_max = 0.8;
  planar_bin_picking::PlaneParams params;
  EXPECT_NO_THROW(checkPlane(request, camera, params));  // there is none
  request.plane = planeOfFrame("belt", belowCamera(0.7, 0.0));
  EXPECT_NO_THROW(checkPlane(request, camera, params));
  request.plane->distance = 0.9;
  EXPECT_TRUE(
      refuses([&] { checkPlane(request, camera, params); }, {"0.900", "hinge", "0.600 .. 0.800"}));
  request.plane.reset();
  params.distance = 0.4;
  EXPECT_TRUE(refuses([&] { checkPlane(request, camera, params); }, {"0.400"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
