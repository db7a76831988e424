// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/pick/surroundings.h"

#include "planar_bin_picking/image/grey.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kPatch = 24;  // pixels across the kept surroundings

}  // namespace

Surroundings cutSurroundings(const PickScene& scene, const Eigen::Isometry3d& T_camera_part,
                             const Eigen::Vector3d& center, double radius) {
  const Eigen::Vector3d c = T_camera_part * center;
  const double left = scene.camera.project(c - Eigen::Vector3d(radius, 0.0, 0.0)).x();
  const double right = scene.camera.project(c + Eigen::Vector3d(radius, 0.0, 0.0)).x();
  const Eigen::Vector2d p = scene.camera.project(c);
  const int half = static_cast<int>(std::ceil(0.5 * (right - left)));
  const cv::Rect square(static_cast<int>(std::lround(p.x())) - half,
                        static_cast<int>(std::lround(p.y())) - half, 2 * half + 1, 2 * half + 1);
  const cv::Rect seen = square & cv::Rect(0, 0, scene.grey.cols, scene.grey.rows);
  if (seen != square) return {{}, scene.bits};
  cv::Mat patch;
  cv::resize(scene.grey(square), patch, {kPatch, kPatch}, 0, 0, cv::INTER_AREA);
  patch.convertTo(patch, CV_32F);
  patch -= cv::mean(patch)[0];
  return {patch, scene.bits};
}

double difference(const Surroundings& a, const Surroundings& b) {
  if (a.patch.empty() || b.patch.empty()) return 0.0;
  // One camera took both, and its brighter image says more about how many bits it has.
  const double level = levelOf(std::max(a.bits, b.bits));
  return cv::norm(a.patch, b.patch, cv::NORM_L1) / (level * static_cast<double>(a.patch.total()));
}

}  // namespace planar_bin_picking
