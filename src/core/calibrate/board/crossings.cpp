// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/board/crossings.h"

#include "calibrate/board/board_grid.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Pixels about a crossing, in which it has no other one, and all four of its squares are seen.
constexpr int kRadius = 4;
/// Grey levels between light and dark, far above what grain leaves after smoothing.
constexpr float kContrast = 20.0F;

float greyOf(const cv::Mat& image, const cv::Point2f& p) {
  return image.at<float>(std::clamp(cvRound(p.y), 0, image.rows - 1),
                         std::clamp(cvRound(p.x), 0, image.cols - 1));
}

/// Whether a circle about the point runs through light, dark, light and dark, and light lies across
/// from light.
bool isCrossing(const cv::Mat& image, const cv::Point2f& p) {
  constexpr std::size_t kSteps = 24, kHalf = kSteps / 2;
  std::array<float, kSteps> grey{};
  for (std::size_t i = 0; i < kSteps; ++i) {
    const auto angle = static_cast<float>(2.0 * CV_PI * static_cast<double>(i) / kSteps);
    grey[i] = greyOf(image, p + kRadius * cv::Point2f(std::cos(angle), std::sin(angle)));
  }
  const auto [low, high] = std::minmax_element(grey.begin(), grey.end());
  if (*high - *low < kContrast) return false;
  const float middle = 0.5F * (*low + *high);
  std::size_t changes = 0, alike = 0;
  for (std::size_t i = 0; i < kSteps; ++i) {
    const bool is_light = grey[i] > middle;
    changes += is_light != (grey[(i + 1) % kSteps] > middle) ? 1 : 0;
    alike += is_light == (grey[(i + kHalf) % kSteps] > middle) ? 1 : 0;
  }
  constexpr std::size_t kAlikeLeast = 16;  // the place is known to a pixel only
  return changes == 4 && alike >= kAlikeLeast;
}

/// Where the grey values have a saddle, the steepest within reach.
std::vector<cv::Point2f> saddles(const cv::Mat& image) {
  cv::Mat xx, yy, xy, highest;
  cv::Sobel(image, xx, CV_32F, 2, 0);
  cv::Sobel(image, yy, CV_32F, 0, 2);
  cv::Sobel(image, xy, CV_32F, 1, 1);
  const cv::Mat saddle = xy.mul(xy) - xx.mul(yy);
  cv::dilate(saddle, highest, cv::Mat::ones(2 * kRadius + 1, 2 * kRadius + 1, CV_8U));
  std::vector<cv::Point2f> found;
  for (int y = kRadius; y < image.rows - kRadius; ++y) {
    for (int x = kRadius; x < image.cols - kRadius; ++x) {
      const float here = saddle.at<float>(y, x);
      const cv::Point2f p(static_cast<float>(x), static_cast<float>(y));
      if (here > 0.0F && here == highest.at<float>(y, x) && isCrossing(image, p)) {
        found.push_back(p);
      }
    }
  }
  return found;
}

/// Whether one side of a square joins them: all along it one hand is light, the other one dark.
bool areJoined(const cv::Mat& image, const cv::Point2f& p, const cv::Point2f& q) {
  const cv::Point2f along = q - p;
  const cv::Point2f aside = 0.2F * cv::Point2f(-along.y, along.x);
  float least = 1e9F, most = -1e9F;
  for (const float share : {0.3F, 0.5F, 0.7F}) {
    const cv::Point2f middle = p + share * along;
    const float step = greyOf(image, middle + aside) - greyOf(image, middle - aside);
    least = std::min(least, step);
    most = std::max(most, step);
  }
  return least > kContrast || most < -kContrast;
}

/// The nearest ones, at most `count`.
std::vector<std::size_t> nearest(const std::vector<cv::Point2f>& all, std::size_t to,
                                 std::size_t count) {
  std::vector<std::pair<double, std::size_t>> others;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i != to) others.emplace_back(cv::norm(all[i] - all[to]), i);
  }
  count = std::min(count, others.size());
  std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count),
                    others.end());
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < count; ++i) out.push_back(others[i].second);
  return out;
}

bool isJoinedTo(const Crossing& crossing, std::size_t other) {
  return std::find(crossing.next.begin(), crossing.next.end(), other) != crossing.next.end();
}

/// Whether four corners, in order, form a square as one sees it aslant: nearly a parallelogram, and
/// no flat one.
bool isSquare(const std::array<cv::Point2f, 4>& p) {
  constexpr double kOff = 0.25, kSineLeast = 0.3;  // off: a share of the shorter side
  const cv::Point2f u = p[1] - p[0], v = p[3] - p[0];
  const double off = cv::norm(p[0] - p[1] + p[2] - p[3]);
  const double a = cv::norm(u), b = cv::norm(v);
  return off < kOff * std::min(a, b) && std::abs(u.cross(v)) > kSineLeast * a * b;
}

}  // namespace

std::vector<Crossing> findCrossings(const cv::Mat& image) {
  const Shrunk small(image, kSectorSearch);
  cv::Mat smooth;
  small.image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {}, 1.0);
  const std::vector<cv::Point2f> found = saddles(smooth);
  // A texture of more is no board, and would take long.
  constexpr std::size_t kMost = 4000;
  if (found.size() > kMost) return {};
  std::vector<cv::Point2f> places = found;
  small.restore(&places);
  std::vector<Crossing> crossings;
  for (std::size_t i = 0; i < found.size(); ++i) {
    Crossing crossing{places[i], {}};
    constexpr std::size_t kAround = 8;
    for (const std::size_t k : nearest(found, i, kAround)) {
      if (areJoined(smooth, found[i], found[k])) crossing.next.push_back(k);
    }
    crossings.push_back(crossing);
  }
  return crossings;
}

std::vector<bool> onSquares(const std::vector<Crossing>& crossings) {
  std::vector<bool> on(crossings.size(), false);
  for (std::size_t p = 0; p < crossings.size(); ++p) {
    for (const std::size_t q : crossings[p].next) {
      for (const std::size_t r : crossings[q].next) {
        for (const std::size_t s : crossings[r].next) {
          if (!isJoinedTo(crossings[s], p)) continue;
          if (!isSquare({crossings[p].at, crossings[q].at, crossings[r].at, crossings[s].at}))
            continue;
          on[p] = on[q] = on[r] = on[s] = true;
        }
      }
    }
  }
  return on;
}

bool leavePicture(const std::vector<Crossing>& crossings, const std::vector<bool>& on_squares,
                  const cv::Size& image) {
  constexpr float kSides = 1.2F;  // at the very border a crossing is not found
  const cv::Rect2f picture(0.0F, 0.0F, static_cast<float>(image.width - 1),
                           static_cast<float>(image.height - 1));
  for (const Crossing& crossing : crossings) {
    for (const std::size_t k : crossing.next) {
      const cv::Point2f beyond = crossing.at + kSides * (crossing.at - crossings[k].at);
      if (on_squares[k] && !picture.contains(beyond)) return true;
    }
  }
  return false;
}

}  // namespace planar_bin_picking
