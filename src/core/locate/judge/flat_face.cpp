// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/flat_face.h"

#include "base/scatter.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

constexpr int kSamples = FaceGrid::kSamples;
constexpr int kHalf = 1;  // samples to either side that a level is the mean of

/// Of an edge that is no line of the drawing: it is clear where the change is as large as this
/// share of the median on the part's own lines, and at least so many grey levels per sample.
constexpr double kAsClear = 0.7, kLeast = 4.0;
/// The same where many edges are counted, and no single one decides.
constexpr double kHalfAsClear = 0.5;
constexpr int kFewSamples = 50;    // of an open face: too few to tell what lies there
constexpr float kOwnLine = 1.0f;   // samples off the drawing's lines: on them
constexpr double kSmallest = 6.0;  // samples across, of what the edge encloses: less is a speck
/// Of a clear change: a hole shows the same level as a drawn hole to within this.
constexpr double kAlike = 1.0;
/// Enclosed area over that of the rectangle about it: a circle has 0.79, a scratch next to nothing.
constexpr double kRound = 0.65;

/// The face in samples, without covered cells and the part's own lines.
cv::Mat_<std::uint8_t> openFace(const FaceGrid& grid, const std::vector<int>& covered) {
  cv::Mat_<std::uint8_t> open(grid.fromOutline().size(), std::uint8_t{0});
  for (std::size_t i = 0; i < grid.cells().size(); ++i) {
    if (std::binary_search(covered.begin(), covered.end(), static_cast<int>(i))) continue;
    const Eigen::Vector2d at = (grid.cells()[i] - grid.corner(0, 0)) / grid.cellSize();
    const int col = static_cast<int>(at.x()), row = static_cast<int>(at.y());
    open(cv::Rect(kSamples * col, kSamples * row, kSamples, kSamples)) = 1;
  }
  open.setTo(0, grid.fromOutline() < kOwnLines);
  return open;
}

/// Median change on the drawing's lines, grey levels per sample.
double ownChange(const FaceGrid& grid, const cv::Mat_<float>& change) {
  std::vector<double> own;
  for (int y = 0; y < change.rows; ++y)
    for (int x = 0; x < change.cols; ++x)
      if (grid.fromOutline()(y, x) < kOwnLine) own.push_back(change(y, x));
  return median(std::move(own));
}

bool isInside(const cv::Mat& image, const Eigen::Vector2f& pixel) {
  return pixel.x() >= 0.0f && pixel.y() >= 0.0f &&
         pixel.x() <= static_cast<float>(image.cols - 1) &&
         pixel.y() <= static_cast<float>(image.rows - 1);
}

/// Mean of a few samples.
double levelAbout(const cv::Mat_<std::uint8_t>& flat, const Eigen::Vector2d& sample) {
  const cv::Rect about(static_cast<int>(sample.x()) - kHalf, static_cast<int>(sample.y()) - kHalf,
                       2 * kHalf + 1, 2 * kHalf + 1);
  const cv::Rect within = about & cv::Rect(0, 0, flat.cols, flat.rows);
  return within.empty() ? 0.0 : cv::mean(flat(within))[0];
}

}  // namespace

FlatFace flatten(const FaceGrid& grid, const cv::Mat& image, const Camera& camera,
                 const Eigen::Isometry3d& T_camera_part, double z) {
  std::vector<Eigen::Vector2f> corners;
  for (int row = 0; row <= grid.rows(); ++row)
    for (int col = 0; col <= grid.cols(); ++col)
      corners.push_back(pixelOnFace(camera, T_camera_part, grid.corner(col, row), z));
  cv::Mat_<cv::Vec2f> at(kSamples * grid.rows(), kSamples * grid.cols());
  const int stride = grid.cols() + 1;
  for (int y = 0; y < at.rows; ++y) {
    const float v = (static_cast<float>(y % kSamples) + 0.5f) / kSamples;
    for (int x = 0; x < at.cols; ++x) {
      const float u = (static_cast<float>(x % kSamples) + 0.5f) / kSamples;
      const auto* const c =
          &corners[static_cast<std::size_t>(y / kSamples * stride + x / kSamples)];
      const Eigen::Vector2f p =
          (1 - v) * ((1 - u) * c[0] + u * c[1]) + v * ((1 - u) * c[stride] + u * c[stride + 1]);
      at(y, x) = {p.x(), p.y()};
    }
  }
  cv::Mat flat;
  cv::remap(image, flat, at, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  FlatFace out(flat);
  for (std::size_t i = 0; i < grid.cells().size(); ++i)
    if (!isInside(image, pixelOnFace(camera, T_camera_part, grid.cells()[i], z)))
      out.outside.push_back(static_cast<int>(i));
  return out;
}

FlatFace::FlatFace(const cv::Mat_<std::uint8_t>& levels) : grey(levels) {
  cv::Mat_<float> x, y;
  constexpr double kUnitRamp = 1.0 / 32.0;  // a ramp of one level per sample answers with 1
  cv::Scharr(grey, x, CV_32F, 1, 0, kUnitRamp);
  cv::Scharr(grey, y, CV_32F, 0, 1, kUnitRamp);
  cv::magnitude(x, y, change);
}

bool hasExtraHole(const FaceGrid& grid, const FlatFace& flat, const std::vector<int>& covered,
                  const std::vector<Eigen::Vector2d>& holes) {
  if (holes.empty()) return false;
  std::vector<double> through;
  for (const Eigen::Vector2d& hole : holes)
    through.push_back(
        levelAbout(flat.grey, (hole - grid.corner(0, 0)) * kSamples / grid.cellSize()));
  const double clear = std::max(kLeast, kAsClear * ownChange(grid, flat.change));
  cv::Mat edges = (flat.change > clear) & (openFace(grid, covered) > 0);
  std::vector<std::vector<cv::Point>> contours;
  std::vector<cv::Vec4i> family;
  cv::findContours(edges, contours, family, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  for (std::size_t i = 0; i < contours.size(); ++i) {
    constexpr int kParent = 3;
    if (family[i][kParent] < 0) continue;  // an outer border, not what is enclosed
    const cv::RotatedRect about = cv::minAreaRect(contours[i]);
    const double across = std::min(about.size.width, about.size.height);
    if (across < kSmallest || cv::contourArea(contours[i]) < kRound * about.size.area()) continue;
    const double inside = levelAbout(flat.grey, {about.center.x, about.center.y});
    if (std::abs(inside - median(through)) < kAlike * clear) return true;
  }
  return false;
}

double foreignEdges(const FaceGrid& grid, const FlatFace& flat, const std::vector<int>& covered) {
  const cv::Mat open = openFace(grid, covered);
  const int samples = cv::countNonZero(open);
  if (samples < kFewSamples) return 0.0;
  const double clear = std::max(kLeast, kHalfAsClear * ownChange(grid, flat.change));
  const cv::Mat edges = (flat.change > clear) & (open > 0);
  return static_cast<double>(cv::countNonZero(edges)) / samples;
}

}  // namespace planar_bin_picking
