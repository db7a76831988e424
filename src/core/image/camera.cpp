// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/camera.h"

#include <Eigen/LU>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

constexpr double kDegrees = 180.0 / EIGEN_PI;

// Pixels of matrix cameras are square; those of old video standards are within 10 % of it, and the
// two focal lengths of a good calibration within 1 %.
constexpr double kFocalRatioMax = 1.2;
// Of the image's longer side. Below, the lens is a telescope, or the image's size in pixels was put
// down as focal length in another unit; beyond, plumb_bob and rational_polynomial do not reach.
constexpr double kViewMinDeg = 2.0, kViewMaxDeg = 150.0;
// A fisheye lens of that field of view bends its border by a factor of 2.9.
constexpr double kBendMax = 4.0;
// Of undistort: Newton's steps, pixels of error at which they end, far below any measurement, and
// the least share of a step that is tried.
constexpr int kNewtonSteps = 50;
constexpr double kExactPx = 1e-10, kShareLeast = 1e-3;
// Pixels: where undistort ends farther off, it has found no direction.
constexpr double kFoundPx = 1e-6;
constexpr int kPerSide = 16;      // of the grid over which a lens model is checked
constexpr int kWaySteps = 32;     // from the centre to a border's pixel
constexpr int kPoleSteps = 1000;  // along the radius: a pole of the rational model is narrow

template <class T>
[[noreturn]] void refuse(const std::string& field, const T& value, const std::string& expected) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << "camera: " << field << " is " << value << ", must be " << expected;
  throw std::invalid_argument(text.str());
}

void checkFocalLengths(const Camera::Model& m) {
  const std::string calibrated = "a finite number greater than 0 (is the camera calibrated?)";
  if (!std::isfinite(m.fx) || m.fx <= 0.0) refuse("fx", m.fx, calibrated);
  if (!std::isfinite(m.fy) || m.fy <= 0.0) refuse("fy", m.fy, calibrated);
  if (m.fx == 1.0 && m.fy == 1.0) {
    refuse("fx", m.fx,
           "in pixels; a focal length of 1 pixel is no calibration: calibrate the camera");
  }
  const double ratio = std::max(m.fx, m.fy) / std::min(m.fx, m.fy);
  if (ratio > kFocalRatioMax) {
    std::ostringstream both;
    both.imbue(std::locale::classic());
    both << m.fx << " and " << m.fy;
    refuse("fx and fy", both.str(),
           "within 20 % of each other, as pixels are square; calibrate "
           "the camera");
  }
}

void checkFieldOfView(const Camera::Model& m) {
  const double view = 2.0 * kDegrees * std::atan(0.5 * std::max(m.width / m.fx, m.height / m.fy));
  if (view >= kViewMinDeg && view <= kViewMaxDeg) return;
  std::ostringstream what;
  what.imbue(std::locale::classic());
  what << "field of view with fx " << m.fx << ", fy " << m.fy << " over " << m.width << " x "
       << m.height << " pixels";
  refuse(what.str(), view,
         "2 to 150 degrees; give focal lengths in pixels of this image's size, from a calibration");
}

/// Cut-out pictures and shifted lenses have it off the middle, none at the border: 0 is a field
/// that nobody filled in.
void checkPrincipalPoint(const std::string& field, double value, int size) {
  if (value > 0.0 && value < size - 1.0) return;
  refuse(field, value,
         "inside the image, between 0 and " + std::to_string(size - 1) +
             "; calibrate the camera at this image size");
}

/// How many coefficients a lens model has.
std::size_t coefficientCount(const std::string& distortion_model) {
  if (distortion_model.empty()) return 0;
  if (distortion_model == "plumb_bob") return 5;
  if (distortion_model == "rational_polynomial") return 8;
  refuse("distortion_model", "\"" + distortion_model + "\"",
         "plumb_bob, rational_polynomial or empty; calibrate the camera with one of these");
}

/// Evenly spaced pixels over the whole image, borders included.
struct Grid {
  std::vector<Eigen::Vector2d> border, inside;
};

Grid gridOver(int width, int height) {
  Grid grid;
  for (int i = 0; i <= kPerSide; ++i) {
    for (int j = 0; j <= kPerSide; ++j) {
      const bool on_border = i % kPerSide == 0 || j % kPerSide == 0;
      (on_border ? grid.border : grid.inside)
          .emplace_back(-0.5 + width * static_cast<double>(i) / kPerSide,
                        -0.5 + height * static_cast<double>(j) / kPerSide);
    }
  }
  return grid;
}

/// Whether undistort finds a direction for this pixel, and no neighbouring one shares it.
bool isOneToOne(const Camera& camera, const Eigen::Vector2d& p_image,
                const Eigen::Vector2d& p_ideal) {
  Eigen::Matrix2d jacobian;
  const double off = (camera.distort(p_ideal, &jacobian) - p_image).norm();
  return off < kFoundPx && jacobian.determinant() > 0.0;
}

/// Whether any direction between the centre and this one shares its pixel with a neighbour.
bool foldsOnTheWay(const Camera& camera, const Eigen::Vector2d& p_ideal) {
  for (int step = 0; step <= kWaySteps; ++step) {
    Eigen::Matrix2d jacobian;
    camera.distort(p_ideal * (static_cast<double>(step) / kWaySteps), &jacobian);
    if (!(jacobian.determinant() > 0.0)) return true;
  }
  return false;
}

/// Whether a longer way from the centre always leads farther out, up to `radius`.
bool growsWithRadius(const std::array<double, 8>& d, double radius) {
  const auto& [k1, k2, p1, p2, k3, k4, k5, k6] = d;
  double last = 0.0;
  for (int step = 1; step <= kPoleSteps; ++step) {
    const double r = radius * step / kPoleSteps, r2 = r * r;
    const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
    const double here = r * (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below;
    if (!(below > 0.0) || !(here > last)) return false;
    last = here;
  }
  return true;
}

[[noreturn]] void refuseLens(const Eigen::Vector2d& p_image, const std::string& expected) {
  std::ostringstream pixel;
  pixel.imbue(std::locale::classic());
  pixel << "(" << p_image.x() << ", " << p_image.y() << ")";
  refuse("the lens model toward pixel", pixel.str(),
         expected + "; calibrate with views that reach the image's corners");
}

void checkPinhole(const Camera::Model& m) {
  if (m.width <= 0) refuse("width", m.width, "greater than 0");
  if (m.height <= 0) refuse("height", m.height, "greater than 0");
  checkFocalLengths(m);
  checkFieldOfView(m);
  checkPrincipalPoint("cx", m.cx, m.width);
  checkPrincipalPoint("cy", m.cy, m.height);
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

void checkLens(const Camera& camera) {
  // A polynomial beyond the board's views may turn back: then two directions share one pixel, and
  // undistort could give either.
  const std::string one_to_one = "one-to-one, but it folds over";
  const Camera::Model& m = camera.model();
  const Grid grid = gridOver(m.width, m.height);
  double farthest = 0.0;
  Eigen::Vector2d farthest_image = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p_image : grid.border) {
    const Eigen::Vector2d p_ideal = camera.undistort(p_image);
    if (!isOneToOne(camera, p_image, p_ideal) || foldsOnTheWay(camera, p_ideal)) {
      refuseLens(p_image, one_to_one);
    }
    if (p_ideal.norm() > farthest) {
      farthest = p_ideal.norm();
      farthest_image = p_image;
    }
  }
  for (const Eigen::Vector2d& p_image : grid.inside) {
    if (!isOneToOne(camera, p_image, camera.undistort(p_image))) refuseLens(p_image, one_to_one);
  }
  if (!growsWithRadius(checkedCoefficients(m), farthest)) refuseLens(farthest_image, one_to_one);
  const Eigen::Vector2d pinhole((farthest_image.x() - m.cx) / m.fx,
                                (farthest_image.y() - m.cy) / m.fy);
  if (farthest > kBendMax * pinhole.norm()) {
    refuseLens(farthest_image, "within a factor of 4 of a pinhole's");
  }
}

}  // namespace

Camera::Camera(const Model& model) : model_(model) {
  checkPinhole(model);
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = checkedCoefficients(model);
  lens_ = {model.fx, model.fy, model.cx, model.cy, k1, k2, p1, p2, k3, k4, k5, k6};
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
  const Lens::Pixel pixel = lens_.distort(p_ideal.x(), p_ideal.y());
  if (jacobian != nullptr) *jacobian << pixel.xx, pixel.xy, pixel.yx, pixel.yy;
  return {pixel.x, pixel.y};
}

Eigen::Vector2d Camera::undistort(const Eigen::Vector2d& p_image) const {
  Eigen::Vector2d p_ideal((p_image.x() - model_.cx) / model_.fx,
                          (p_image.y() - model_.cy) / model_.fy);
  Eigen::Matrix2d jacobian;
  Eigen::Vector2d error = distort(p_ideal, &jacobian) - p_image;
  for (int iteration = 0; iteration < kNewtonSteps && error.norm() > kExactPx; ++iteration) {
    const Eigen::Vector2d step = jacobian.inverse() * error;
    // Far from the centre a full step may leap over a fold of the polynomial: take less of it.
    double share = 1.0;
    Eigen::Vector2d next;
    Eigen::Matrix2d next_jacobian;
    Eigen::Vector2d next_error;
    for (; share > kShareLeast; share *= 0.5) {
      next = p_ideal - share * step;
      next_error = distort(next, &next_jacobian) - p_image;
      if (next_error.norm() < error.norm() && next_jacobian.determinant() > 0.0) break;
    }
    if (share <= kShareLeast) break;  // at the limit of double precision
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

}  // namespace planar_bin_picking
