// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/bin/floor_cover.h"

#include "planar_bin_picking/image/grey.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

namespace planar_bin_picking {
namespace {

/// The floor laid out flat: row by row along the box's y, columns along its x.
struct FlatFloor {
  cv::Mat grey;       ///< 8 bit
  cv::Mat seen;       ///< 255 where the picture shows the floor
  double step = 0.0;  ///< metres per pixel
};

/// Walls are known to this much (as boxMargin in pick_policy.h), and have edges of their own.
constexpr double kInset = 0.008;  // metres
/// Finer than this is not laid out: a bin's floor then takes a few milliseconds.
constexpr int kMostPixels = 480;  // along the longer side
constexpr int kLeastPixels = 24;  // along the shorter side; fewer show nothing

bool isInside(const BinBox& bin, const Eigen::Vector3d& x_bin) {
  return x_bin.x() > bin.min.x() && x_bin.x() < bin.max.x() && x_bin.y() > bin.min.y() &&
         x_bin.y() < bin.max.y();
}

/// Whether the walls leave the way from the eye to a point of the floor free.
bool isOpen(const BinBox& bin, const Eigen::Vector3d& eye, const Eigen::Vector3d& x_bin) {
  const double share = (bin.max.z() - x_bin.z()) / (eye.z() - x_bin.z());
  return share <= 1.0 && isInside(bin, x_bin + share * (eye - x_bin));
}

/// Size of the image's pixels on the floor's middle, metres.
double pixelOnFloor(const Camera& camera, const BinBox& bin) {
  Eigen::Vector3d middle = 0.5 * (bin.min + bin.max);
  middle.z() = bin.min.z();
  return (bin.T_camera_bin * middle).norm() / camera.model().fx;
}

FlatFloor layOut(const cv::Mat& image, const Camera& camera, const BinBox& bin) {
  const Eigen::Vector2d size =
      (bin.max - bin.min).head<2>() - Eigen::Vector2d::Constant(2.0 * kInset);
  FlatFloor floor;
  floor.step = std::max(pixelOnFloor(camera, bin), size.maxCoeff() / kMostPixels);
  const int columns = static_cast<int>(size.x() / floor.step);
  const int rows = static_cast<int>(size.y() / floor.step);
  if (std::min(columns, rows) < kLeastPixels) return floor;
  // Whole blocks of the image's pixels, as large as those of the floor: nothing is passed over.
  // Of a box that is told far too large, some pixels are left.
  const double most = std::max(1, std::min(image.cols, image.rows) / kLeastPixels);
  const int shrink =
      static_cast<int>(std::clamp(floor.step / pixelOnFloor(camera, bin), 1.0, most));
  cv::Mat source = toEightBits(image);
  if (shrink > 1)
    cv::resize(source, source, {image.cols / shrink, image.rows / shrink}, 0, 0, cv::INTER_AREA);
  cv::Mat_<float> u(rows, columns), v(rows, columns);
  floor.seen = cv::Mat::zeros(rows, columns, CV_8U);
  const Eigen::Vector3d eye = bin.T_camera_bin.inverse().translation();
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d x_bin(bin.min.x() + kInset + (column + 0.5) * floor.step,
                                  bin.min.y() + kInset + (row + 0.5) * floor.step, bin.min.z());
      const Eigen::Vector3d p_camera = bin.T_camera_bin * x_bin;
      u(row, column) = v(row, column) = -1.0f;
      if (p_camera.z() <= 0.0 || !isOpen(bin, eye, x_bin)) continue;
      const Eigen::Vector2d p = camera.project(p_camera);
      u(row, column) = static_cast<float>((p.x() + 0.5) / shrink - 0.5);
      v(row, column) = static_cast<float>((p.y() + 0.5) / shrink - 0.5);
      if (p.x() >= 1.0 && p.y() >= 1.0 && p.x() < image.cols - 2.0 && p.y() < image.rows - 2.0)
        floor.seen.at<std::uint8_t>(row, column) = 255;
    }
  }
  cv::remap(source, floor.grey, u, v, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return floor;
}

double shareOfFloor(const FlatFloor& floor, const cv::Mat& mask) {
  cv::Mat both;
  cv::bitwise_and(mask, floor.seen, both);
  return static_cast<double>(cv::countNonZero(both)) / cv::countNonZero(floor.seen);
}

/// Why such a picture would not show a part that lies there; "" where it would.
std::string whyBlind(const FlatFloor& floor) {
  constexpr double kSeenLeast = 0.9;             // the rest may hide a part
  constexpr double kDark = 12.0, kFull = 250.0;  // grey levels
  constexpr double kBlindMost = 0.05;            // share of the floor
  constexpr double kContrast = 0.5;              // grey levels; any sensor's noise is more
  const double seen = static_cast<double>(cv::countNonZero(floor.seen)) / floor.seen.total();
  const double dark = shareOfFloor(floor, floor.grey < kDark);
  const double full = shareOfFloor(floor, floor.grey > kFull);
  cv::Scalar mean, deviation;
  cv::meanStdDev(floor.grey, mean, deviation, floor.seen);
  const auto say = [](const char* pattern, const double share) {
    char text[160];
    std::snprintf(text, sizeof text, pattern, 100.0 * share);
    return std::string(text);
  };
  if (seen < kSeenLeast) return say("only %.0f %% of the bin's floor are in view", seen);
  if (dark > kBlindMost) return say("%.0f %% of the bin's floor are too dark", dark);
  if (full > kBlindMost) return say("%.0f %% of the bin's floor are overexposed", full);
  if (deviation[0] < kContrast) return "the bin's floor is uniformly grey, as in no real picture";
  return "";
}

/// The same with pixels so many times as large.
FlatFloor coarser(const FlatFloor& floor, const int factor) {
  FlatFloor coarse;
  const cv::Rect whole(0, 0, floor.grey.cols / factor * factor, floor.grey.rows / factor * factor);
  const cv::Size size(whole.width / factor, whole.height / factor);
  cv::resize(floor.grey(whole), coarse.grey, size, 0, 0, cv::INTER_AREA);
  cv::resize(floor.seen(whole), coarse.seen, size, 0, 0, cv::INTER_AREA);
  coarse.seen = coarse.seen == 255;
  coarse.step = floor.step * factor;
  return coarse;
}

/// 255 where there is an edge: a gradient well above the noise and above the floor's own grain.
/// @param least  grey levels per pixel of the floor; fainter is shading
cv::Mat edgesOf(const FlatFloor& floor, const double least) {
  constexpr double kGrainFactor = 4.0;  // of the median gradient: noise and grain have none beyond
  constexpr double kUnit = 1.0 / 32.0;  // Scharr's answer to a ramp of one grey level per pixel
  cv::Mat smooth, dx, dy, gradient;
  cv::GaussianBlur(floor.grey, smooth, {5, 5}, 1.0);
  cv::Scharr(smooth, dx, CV_32F, 1, 0, kUnit);
  cv::Scharr(smooth, dy, CV_32F, 0, 1, kUnit);
  cv::magnitude(dx, dy, gradient);
  cv::Mat inner, edges;
  cv::erode(floor.seen, inner, {}, {-1, -1}, 3, cv::BORDER_CONSTANT, 0);
  std::vector<float> values;
  for (int row = 0; row < gradient.rows; ++row)
    for (int column = row % 2; column < gradient.cols; column += 2)
      if (inner.at<std::uint8_t>(row, column)) values.push_back(gradient.at<float>(row, column));
  if (values.empty()) return cv::Mat::zeros(floor.grey.size(), CV_8U);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  cv::bitwise_and(gradient > std::max(least, kGrainFactor * *middle), inner, edges);
  return edges;
}

/// Groups of edges that hang together across small gaps.
struct Groups {
  cv::Mat closed;  ///< 255 where an edge is near
  double longest_px = 0.0;
};

Groups groupsOf(const cv::Mat& edges, const double step) {
  constexpr double kGap = 0.003;  // metres
  const int reach = std::max(1, static_cast<int>(std::lround(kGap / step)));
  Groups groups;
  cv::morphologyEx(edges, groups.closed, cv::MORPH_CLOSE,
                   cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * reach + 1, 2 * reach + 1}));
  cv::Mat labels, statistics, centers;
  const int count = cv::connectedComponentsWithStats(groups.closed, labels, statistics, centers);
  for (int i = 1; i < count; ++i) {
    const double diagonal = std::hypot(statistics.at<int>(i, cv::CC_STAT_WIDTH),
                                       statistics.at<int>(i, cv::CC_STAT_HEIGHT));
    groups.longest_px = std::max(groups.longest_px, diagonal);
  }
  return groups;
}

/// 255 where the floor is not connected to its rim past the edges.
cv::Mat surroundedBy(const cv::Mat& closed) {
  cv::Mat open;  // 255: free, with a free rim around it from which it is flooded
  cv::copyMakeBorder(255 - closed, open, 1, 1, 1, 1, cv::BORDER_CONSTANT, 255);
  cv::floodFill(open, {0, 0}, 128);
  return open(cv::Rect(1, 1, closed.cols, closed.rows)) != 128;
}

/// Adds what a located part hides of the floor, as seen from the camera.
void cover(const std::vector<Eigen::Vector3d>& outline, const BinBox& bin, const double step,
           cv::Mat* covered) {
  const Eigen::Isometry3d T_bin_camera = bin.T_camera_bin.inverse();
  const Eigen::Vector3d eye = T_bin_camera.translation();
  std::vector<cv::Point> points;
  for (const Eigen::Vector3d& p_camera : outline) {
    const Eigen::Vector3d x_bin = T_bin_camera * p_camera;
    const double drop = eye.z() - x_bin.z();
    if (drop <= 0.0) return;
    const Eigen::Vector3d x_floor = eye + (x_bin - eye) * ((eye.z() - bin.min.z()) / drop);
    const Eigen::Vector3d pixel =
        ((x_floor - bin.min).array() - kInset) / step - 0.5;  // of the flat floor
    // What lies nearly as high as the eye reaches farther than whole numbers do.
    constexpr double kFarthest = 1e4;  // pixels
    points.emplace_back(
        static_cast<int>(std::lround(std::clamp(pixel.x(), -kFarthest, kFarthest))),
        static_cast<int>(std::lround(std::clamp(pixel.y(), -kFarthest, kFarthest))));
  }
  if (points.size() > 2)
    cv::fillPoly(*covered, std::vector<std::vector<cv::Point>>{points}, cv::Scalar(255));
}

}  // namespace

FloorCover findFloorCover(const cv::Mat& image, const Camera& camera, const BinBox& bin,
                          const std::vector<std::vector<Eigen::Vector3d>>& located) {
  // What is out of focus shows in larger pixels only.
  constexpr int kCoarse = 4;
  constexpr double kLeast = 4.0, kLeastCoarse = 8.0;
  FloorCover found;
  const FlatFloor floor = layOut(image, camera, bin);
  if (floor.grey.empty() || cv::countNonZero(floor.seen) == 0) {
    found.doubt = "the bin's floor is not in view";
    return found;
  }
  const Groups fine = groupsOf(edgesOf(floor, kLeast), floor.step);
  const FlatFloor coarse = coarser(floor, kCoarse);
  const Groups blurred = groupsOf(edgesOf(coarse, kLeastCoarse), coarse.step);
  found.longest = std::max(fine.longest_px * floor.step, blurred.longest_px * coarse.step);
  cv::Mat covered = surroundedBy(fine.closed);
  for (const auto& outline : located) cover(outline, bin, floor.step, &covered);
  found.covered = shareOfFloor(floor, covered);
  found.doubt = whyBlind(floor);
  return found;
}

}  // namespace planar_bin_picking
