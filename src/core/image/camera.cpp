// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/camera.h"

#include "base/yaml_file.h"
#include "image/camera_check.h"

#include <Eigen/LU>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {

Camera::Camera(const Model& model) : model_(model) {
  checkPinhole(model);
  d_ = checkedCoefficients(model);
  checkLens(*this);
}

Camera::Model pinholeModel(int width, int height, const std::array<double, 9>& K) {
  const auto& [fx, skew, cx, k10, fy, cy, k20, k21, k22] = K;
  const auto refuse = [&](const std::string& why) {
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text << "camera matrix [";
    for (std::size_t i = 0; i < K.size(); ++i) text << (i > 0 ? ", " : "") << K[i];
    text << "] " << why << "; it must be [fx, 0, cx, 0, fy, cy, 0, 0, 1]";
    throw std::invalid_argument(text.str());
  };
  if (skew != 0.0) refuse("has a skew, which no lens model here has");
  if (k10 != 0.0 || k20 != 0.0 || k21 != 0.0 || k22 != 1.0) refuse("is none of a pinhole");
  Camera::Model model;
  model.width = width;
  model.height = height;
  model.fx = fx;
  model.fy = fy;
  model.cx = cx;
  model.cy = cy;
  return model;
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& p_ideal) const {
  return distort(p_ideal, nullptr);
}

Eigen::Vector2d Camera::distort(const Eigen::Vector2d& p_ideal, Eigen::Matrix2d* jacobian) const {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = d_;
  const double x = p_ideal.x(), y = p_ideal.y(), r2 = p_ideal.squaredNorm();
  const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double radial = above / below;
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * radial + 2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y);
  if (jacobian != nullptr) {
    const double above_r2 = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);
    const double below_r2 = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
    const double radial_r2 = (above_r2 - radial * below_r2) / below;
    const double mixed = 2.0 * (x * y * radial_r2 + p1 * x + p2 * y);
    *jacobian << model_.fx * (radial + 2.0 * x * x * radial_r2 + 2.0 * p1 * y + 6.0 * p2 * x),
        model_.fx * mixed, model_.fy * mixed,
        model_.fy * (radial + 2.0 * y * y * radial_r2 + 6.0 * p1 * y + 2.0 * p2 * x);
  }
  return {model_.fx * xd + model_.cx, model_.fy * yd + model_.cy};
}

Eigen::Vector2d Camera::undistort(const Eigen::Vector2d& p_image) const {
  Eigen::Vector2d p_ideal((p_image.x() - model_.cx) / model_.fx,
                          (p_image.y() - model_.cy) / model_.fy);
  Eigen::Matrix2d jacobian;
  Eigen::Vector2d error = distort(p_ideal, &jacobian) - p_image;
  for (int iteration = 0; iteration < 50 && error.norm() > 1e-10; ++iteration) {
    const Eigen::Vector2d step = jacobian.inverse() * error;
    // Far from the centre a full step may leap over a fold of the polynomial: take less of it.
    double share = 1.0;
    Eigen::Vector2d next;
    Eigen::Matrix2d next_jacobian;
    Eigen::Vector2d next_error;
    for (; share > 1e-3; share *= 0.5) {
      next = p_ideal - share * step;
      next_error = distort(next, &next_jacobian) - p_image;
      if (next_error.norm() < error.norm() && next_jacobian.determinant() > 0.0) break;
    }
    if (share <= 1e-3) break;  // at the limit of double precision
    p_ideal = next;
    error = next_error;
    jacobian = next_jacobian;
  }
  return p_ideal;
}

Eigen::Vector2d Camera::project(const Eigen::Vector3d& p_camera) const {
  assert(p_camera.z() > 0.0);
  return distort(Eigen::Vector2d(p_camera.x() / p_camera.z(), p_camera.y() / p_camera.z()));
}

namespace {

std::vector<double> readData(const YAML::Node& root, const std::string& path,
                             const std::string& key) {
  const bool written = root[key].IsDefined() && root[key].IsMap() && root[key]["data"].IsDefined();
  if (!written) throw std::runtime_error(path + ": " + key + "/data is missing");
  const YAML::Node data = root[key]["data"];
  return valueAs<std::vector<double>>(data, path, key + "/data", "a list of numbers");
}

}  // namespace

Camera loadCamera(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  if (root["K"] && !root["camera_matrix"]) {
    throw std::runtime_error(path +
                             ": is a printed CameraInfo message (key \"K\"); give the file "
                             "that the calibration wrote (key \"camera_matrix\")");
  }
  const int width = valueAs<int>(root["image_width"], path, "image_width", "a number of pixels");
  const int height = valueAs<int>(root["image_height"], path, "image_height", "a number of pixels");
  const std::vector<double> k = readData(root, path, "camera_matrix");
  std::array<double, 9> K{};
  if (k.size() != K.size()) {
    throwBadValue(path, "camera_matrix/data", root["camera_matrix"]["data"],
                  "[fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  }
  std::copy(k.begin(), k.end(), K.begin());
  Camera::Model model;
  try {
    model = pinholeModel(width, height, K);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(path + ": camera_matrix/data: " + e.what());
  }
  const YAML::Node distortion_model = root["distortion_model"];
  model.distortion_model = distortion_model.IsDefined() && distortion_model.IsNull()
                               ? ""
                               : valueAs<std::string>(distortion_model, path, "distortion_model",
                                                      "plumb_bob or rational_polynomial");
  model.distortion = readData(root, path, "distortion_coefficients");
  try {
    return Camera(model);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace planar_bin_picking
