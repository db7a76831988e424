// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/print_image.h"

#include <opencv2/imgproc.hpp>

#include <cmath>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPixel = 5e-5;   // metres
constexpr double kSoft = 1.5;     // pixels, standard deviation of the strokes' borders
constexpr float kOnFace = 1e-4f;  // metres

}  // namespace

PrintImage::PrintImage(const Shape& shape, double stroke) {
  if (shape.prints.empty()) return;
  Eigen::AlignedBox2d box;
  for (const Polygon& print : shape.prints)
    for (const Eigen::Vector2d& p : print) box.extend(p);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(2.0 * stroke);
  const Eigen::Vector2d corner = box.min() - margin;
  corner_ = corner.cast<float>();
  const Eigen::Vector2d size = (box.max() + margin - corner) / kPixel;
  cv::Mat_<unsigned char> ink(static_cast<int>(size.y()) + 1, static_cast<int>(size.x()) + 1,
                              static_cast<unsigned char>(0));
  for (const Polygon& print : shape.prints) {
    std::vector<cv::Point> points;
    for (const Eigen::Vector2d& p : print) {
      const Eigen::Vector2d q = (p - corner) / kPixel;
      points.emplace_back(static_cast<int>(std::lround(q.x())),
                          static_cast<int>(std::lround(q.y())));
    }
    cv::polylines(ink, points, false, cv::Scalar(255),
                  static_cast<int>(std::lround(stroke / kPixel)));
  }
  ink.convertTo(cover_, CV_32F, 1.0 / 255.0);
  cv::GaussianBlur(cover_, cover_, {}, kSoft);
}

float PrintImage::at(const Eigen::Vector3f& x_part) const {
  if (empty() || x_part.z() < -kOnFace) return 0.0f;
  const Eigen::Vector2f p = (x_part.head<2>() - corner_) / static_cast<float>(kPixel);
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  if (x < 0 || y < 0 || x + 1 >= cover_.cols || y + 1 >= cover_.rows) return 0.0f;
  const float a = p.x() - static_cast<float>(x), b = p.y() - static_cast<float>(y);
  return (1 - b) * ((1 - a) * cover_(y, x) + a * cover_(y, x + 1)) +
         b * ((1 - a) * cover_(y + 1, x) + a * cover_(y + 1, x + 1));
}

}  // namespace planar_bin_picking::cell
