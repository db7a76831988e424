// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Draws flat plates, lying in front of a camera, for the tests of the localization.
///
/// The truth must not be made by the code under test: shapes are raw polygons in the drawing's
/// millimetres, and projection, lens and rasterization are written here once more (no Drawing, no
/// PartModel, no Camera). Frames as in types.h; a plate's walls are not drawn.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace planar_bin_picking::sim {

using Ring = std::vector<Eigen::Vector2d>;  ///< mm; the last point joins the first

/// Outer contour counter-clockwise, holes clockwise, as a Drawing has them.
struct Plate {
  Ring outer;
  std::vector<Ring> holes;
  std::vector<Ring> prints;  ///< painted areas of the front face
  double thickness_mm = 0.0;
};

struct PinholeCamera {
  int width = 1200, height = 1000;
  double fx = 1700.0, fy = 1697.0, cx = 604.3, cy = 492.8;
  std::array<double, 5> lens = {-0.11, 0.07, 4e-4, -5e-4, 0.01};  ///< k1 k2 p1 p2 k3
};

/// One plate in the scene; the face that its pose turns toward the camera is drawn.
struct Lying {
  Plate plate;
  Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();  ///< metres
  double grey = 150.0, print_grey = 60.0;
};

struct Scene {
  std::vector<Lying> plates;  ///< later ones lie over earlier ones
  double background = 60.0;
  double blur_px = 0.7;
  double noise = 2.0;  ///< standard deviation, grey levels
  int seed = 1;
};

inline Eigen::Vector2d project(const PinholeCamera& camera, const Eigen::Vector3d& p) {
  const auto& [k1, k2, p1, p2, k3] = camera.lens;
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const double radial = 1.0 + k1 * r2 + k2 * r2 * r2 + k3 * r2 * r2 * r2;
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
  const double yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
  return {camera.fx * xd + camera.cx, camera.fy * yd + camera.cy};
}

/// Share of each pixel that the rings cover (even-odd): exact along rows, 8 lines per row.
class Coverage {
 public:
  Coverage(int width, int height)
      : width_(width), crossings_(static_cast<std::size_t>(height) * kLines) {}

  /// Pixel (0, 0) is the centre of the top-left pixel.
  void addSide(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d &top = a.y() < b.y() ? a : b, &bottom = a.y() < b.y() ? b : a;
    const int last = static_cast<int>(crossings_.size());
    for (int i = std::max(0, lineBelow(top.y())), end = std::min(last, lineBelow(bottom.y()));
         i < end; ++i) {
      const double y = (i + 0.5) / kLines - 0.5;
      const double x = top.x() + (bottom.x() - top.x()) * (y - top.y()) / (bottom.y() - top.y());
      crossings_[static_cast<std::size_t>(i)].push_back(x + 0.5);  // now pixel k spans k .. k + 1
    }
  }

  /// Lays `grey` over the image where covered.
  void paint(double grey, cv::Mat_<float>* image) {
    std::vector<double> share(static_cast<std::size_t>(width_));
    for (int row = 0; row < image->rows; ++row) {
      std::fill(share.begin(), share.end(), 0.0);
      for (int k = 0; k < kLines; ++k) {
        addLine(&crossings_[static_cast<std::size_t>(row) * kLines + static_cast<std::size_t>(k)],
                &share);
      }
      for (int x = 0; x < width_; ++x) {
        float& value = (*image)(row, x);
        value += static_cast<float>(share[static_cast<std::size_t>(x)] / kLines * (grey - value));
      }
    }
  }

 private:
  static constexpr int kLines = 8;

  static int lineBelow(double y) { return static_cast<int>(std::ceil((y + 0.5) * kLines - 0.5)); }

  void addLine(std::vector<double>* crossings, std::vector<double>* share) const {
    std::sort(crossings->begin(), crossings->end());
    for (std::size_t i = 0; i + 1 < crossings->size(); i += 2) {
      const double from = std::clamp<double>((*crossings)[i], 0.0, width_);
      const double to = std::clamp<double>((*crossings)[i + 1], 0.0, width_);
      for (int x = static_cast<int>(from); x < to; ++x) {
        (*share)[static_cast<std::size_t>(x)] +=
            std::min(to, x + 1.0) - std::max(from, static_cast<double>(x));
      }
    }
  }

  int width_;
  std::vector<std::vector<double>> crossings_;  // of each line
};

/// Sides in pieces of at most a millimetre, so that the lens may bend them.
inline void addRing(const PinholeCamera& camera, const Lying& lying, const Ring& ring, double z_mm,
                    Coverage* coverage) {
  const auto seen = [&](const Eigen::Vector2d& p) {
    return project(camera, lying.T_camera_part * (1e-3 * Eigen::Vector3d(p.x(), p.y(), z_mm)));
  };
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], b = ring[(i + 1) % ring.size()];
    const int pieces = std::max(1, static_cast<int>(std::ceil((b - a).norm())));
    for (int k = 0; k < pieces; ++k) {
      coverage->addSide(seen(a + (b - a) * k / pieces), seen(a + (b - a) * (k + 1) / pieces));
    }
  }
}

/// The scene without blur and noise, in grey levels.
inline cv::Mat_<float> paint(const PinholeCamera& camera, const Scene& scene) {
  cv::Mat_<float> image(camera.height, camera.width, static_cast<float>(scene.background));
  for (const Lying& lying : scene.plates) {
    const bool front_up = lying.T_camera_part.linear()(2, 2) < 0.0;
    const double z_mm = front_up ? 0.0 : -lying.plate.thickness_mm;
    Coverage face(camera.width, camera.height);
    addRing(camera, lying, lying.plate.outer, z_mm, &face);
    for (const Ring& hole : lying.plate.holes) addRing(camera, lying, hole, z_mm, &face);
    face.paint(lying.grey, &image);
    if (!front_up) continue;
    for (const Ring& print : lying.plate.prints) {
      Coverage area(camera.width, camera.height);
      addRing(camera, lying, print, z_mm, &area);
      area.paint(lying.print_grey, &image);
    }
  }
  return image;
}

/// The picture that the camera takes: 8 bit, the same for the same scene.
inline cv::Mat takeImage(const PinholeCamera& camera, const Scene& scene) {
  cv::Mat_<float> image = paint(camera, scene);
  if (scene.blur_px > 0.0) cv::GaussianBlur(image, image, {}, scene.blur_px);
  if (scene.noise > 0.0) {
    cv::Mat_<float> noise(image.size());
    cv::RNG(static_cast<std::uint64_t>(scene.seed)).fill(noise, cv::RNG::NORMAL, 0.0, scene.noise);
    image += noise;
  }
  cv::Mat out;
  image.convertTo(out, CV_8U);
  return out;
}

/// How a plate lies: its origin in millimetres, the turn in its plane, and its tilt against the
/// image plane about an axis of that direction in the image.
struct Lie {
  double x_mm = 0.0, y_mm = 0.0, z_mm = 600.0;
  double yaw_deg = 0.0, tilt_deg = 0.0, axis_deg = 0.0;
  bool front = true;  ///< the drawn face is up
};

inline Eigen::Isometry3d poseOf(const Lie& lie) {
  constexpr double kRadians = 3.14159265358979323846 / 180.0;
  const double axis = lie.axis_deg * kRadians;
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = (Eigen::AngleAxisd(lie.tilt_deg * kRadians,
                                  Eigen::Vector3d(std::cos(axis), std::sin(axis), 0.0)) *
                Eigen::AngleAxisd(lie.yaw_deg * kRadians, Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(lie.front ? 180.0 * kRadians : 0.0, Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  T.translation() = 1e-3 * Eigen::Vector3d(lie.x_mm, lie.y_mm, lie.z_mm);
  return T;
}

}  // namespace planar_bin_picking::sim
