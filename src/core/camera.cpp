// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/camera.h"

#include "yaml_file.h"

#include <Eigen/LU>

#include <cassert>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

template <class T>
[[noreturn]] void refuse(const std::string& field, const T& value, const std::string& expected) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "camera: " << field << " is " << value << ", must be " << expected;
  throw std::invalid_argument(text.str());
}

void checkPinhole(const Camera::Model& m) {
  if (m.width <= 0) refuse("width", m.width, "greater than 0");
  if (m.height <= 0) refuse("height", m.height, "greater than 0");
  const std::string calibrated = "a finite number greater than 0 (is the camera calibrated?)";
  if (!std::isfinite(m.fx) || m.fx <= 0.0) refuse("fx", m.fx, calibrated);
  if (!std::isfinite(m.fy) || m.fy <= 0.0) refuse("fy", m.fy, calibrated);
  const auto near = [](double c, int size) { return c > -0.5 * size && c < 1.5 * size; };
  if (!near(m.cx, m.width)) refuse("cx", m.cx, "within half a width of the image");
  if (!near(m.cy, m.height)) refuse("cy", m.cy, "within half a height of the image");
}

/// How many coefficients a lens model has.
std::size_t coefficientCount(const std::string& distortion_model) {
  if (distortion_model.empty()) return 0;
  if (distortion_model == "plumb_bob") return 5;
  if (distortion_model == "rational_polynomial") return 8;
  refuse("distortion_model", "\"" + distortion_model + "\"",
         "plumb_bob, rational_polynomial or empty; calibrate the camera with one of these");
}

std::array<double, 8> checkedCoefficients(const Camera::Model& m) {
  const std::size_t count = coefficientCount(m.distortion_model);
  std::array<double, 8> d{};
  for (std::size_t i = 0; i < m.distortion.size(); ++i) {
    const double value = m.distortion[i];
    const std::string field = "distortion coefficient " + std::to_string(i + 1);
    if (!std::isfinite(value)) refuse(field, value, "a finite number");
    // Calibration programs pad with zeros; only a coefficient that does something is an error.
    if (i >= count && value != 0.0) {
      refuse(field, value,
             "0 or absent: \"" + m.distortion_model + "\" has " + std::to_string(count) +
                 " coefficients");
    }
    if (i < count) d[i] = value;
  }
  return d;
}

/// Evenly spaced pixels along the border of the image, corners included.
std::vector<Eigen::Vector2d> borderPixels(int width, int height) {
  constexpr int kPerSide = 16;
  std::vector<Eigen::Vector2d> pixels;
  for (int i = 0; i <= kPerSide; ++i) {
    const double u = -0.5 + width * static_cast<double>(i) / kPerSide;
    const double v = -0.5 + height * static_cast<double>(i) / kPerSide;
    pixels.insert(pixels.end(), {{u, -0.5}, {u, height - 0.5}, {-0.5, v}, {width - 0.5, v}});
  }
  return pixels;
}

}  // namespace

Camera::Camera(const Model& model) : model_(model) {
  checkPinhole(model);
  d_ = checkedCoefficients(model);
  // A polynomial beyond the board's views may turn back: then two directions share one pixel, and
  // undistort could give either. Walk from the centre to the border: no ray may fold on its way.
  for (const Eigen::Vector2d& p_image : borderPixels(model.width, model.height)) {
    const Eigen::Vector2d p_ideal = undistort(p_image);
    bool folds = !((distort(p_ideal) - p_image).norm() < 1e-6);
    for (int step = 0; step <= 32 && !folds; ++step) {
      Eigen::Matrix2d jacobian;
      distort(p_ideal * (step / 32.0), &jacobian);
      folds = !(jacobian.determinant() > 0.0);
    }
    if (folds) {
      std::ostringstream pixel;
      pixel << "(" << p_image.x() << ", " << p_image.y() << ")";
      refuse("the lens model toward pixel", pixel.str(),
             "one-to-one, but it folds over; calibrate with views that reach the image's corners");
    }
  }
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
  Camera::Model model;
  model.width = valueAs<int>(root["image_width"], path, "image_width", "a number of pixels");
  model.height = valueAs<int>(root["image_height"], path, "image_height", "a number of pixels");
  const std::vector<double> k = readData(root, path, "camera_matrix");
  if (k.size() != 9 || k[1] != 0.0 || k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0) {
    throwBadValue(path, "camera_matrix/data", root["camera_matrix"]["data"],
                  "[fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  }
  model.fx = k[0];
  model.cx = k[2];
  model.fy = k[4];
  model.cy = k[5];
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
