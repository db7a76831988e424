// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/part/part_file.h"
#include "support/plates.h"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <string>

/// Pictures in which a part was answered wrongly: each one part of a heap, on a picture of 1.3
/// megapixels of the simulated cell; what lies about it is blank. Truth in the camera's frame.

namespace planar_bin_picking {
namespace {

LocateResult locatedIn(const std::string& folder, const std::string& part) {
  const std::string data = std::string(PACKAGE_DIR) + "/test/data/";
  const cv::Mat image = cv::imread(data + folder + "/image.png", cv::IMREAD_GRAYSCALE);
  LocateRequest request;
  request.distance_min = 0.6;
  request.distance_max = 0.78;
  request.parts = {
      std::make_shared<const PartModel>(loadPartFile(data + "parts/" + part + ".yaml"))};
  return Locator(LocatorParams{})
      .locate(image, loadCamera(data + folder + "/camera_info.yaml"), request);
}

TEST(Pictures, ALongPartsTiltsAreComparedAboutEitherAxis) {
  // An edge of a neighbour makes it rest 6 degrees off, and so it does from the tilt that lies the
  // other way about the line of sight; from the one that lies so about its length only it does not.
  const auto result = locatedIn("linkarm_tilted", "linkarm");
  ASSERT_EQ(result.detections.size(), 1u);
  const Eigen::Matrix3d R = result.detections[0].T_camera_part.linear();
  const Eigen::Vector3d normal(0.0373, -0.0654, -0.9972);
  EXPECT_LT((R.col(2) - normal).norm(), 3.0 * kDegrees);
}

TEST(Pictures, TurnsAreComparedWithOneAnother) {
  // A sprocket whose keyway alone tells its turn, on brushed metal. From 96 degrees off, the turn
  // that lies 24 degrees beside that one seemed likelier than the right one: they differ in so few
  // points that most of these were seen.
  const auto result = locatedIn("sprocket_turned", "sprocket");
  ASSERT_EQ(result.detections.size(), 1u);
  const Eigen::Matrix3d R = result.detections[0].T_camera_part.linear();
  const Eigen::Vector3d keyway(-0.9939, 0.1092, -0.0156);  // the part's y
  EXPECT_LT((R.col(1) - keyway).norm(), 3.0 * kDegrees);
}

}  // namespace
}  // namespace planar_bin_picking
