// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/show/part_picture.h"

#include "planar_bin_picking/part/part_summary.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr int kSide = 640, kMargin = 70, kLine = 22;  // pixels: of a face, about it, of text
constexpr int kShift = 4;  ///< binary digits behind the point in OpenCV's drawing coordinates
const cv::Scalar kPaper(255, 255, 255), kMetal(225, 220, 215), kInk(40, 40, 40);
const cv::Scalar kPrint(200, 120, 30), kPick(30, 30, 220), kWarning(0, 60, 200);  // BGR
const cv::Scalar kAxisX(40, 40, 255), kAxisY(40, 170, 40);

/// One face on the canvas.
class Panel {
 public:
  Panel(cv::Mat* canvas, const PartModel& part, const Face face, const int left)
      : canvas_(canvas), part_(part), face_(face), left_(left) {
    for (const Eigen::Vector2d& p : part.file().drawing.loops.front().points) box_.extend(p);
    scale_ = (kSide - 2 * kMargin) / box_.sizes().maxCoeff();
  }

  /// Seen from behind, x runs to the left.
  cv::Point pixel(const Eigen::Vector2d& p) const {
    const Eigen::Vector2d from_center = scale_ * (p - box_.center());
    const double x = face_ == Face::kFront ? from_center.x() : -from_center.x();
    return {static_cast<int>(std::lround((left_ + 0.5 * kSide + x) * (1 << kShift))),
            static_cast<int>(std::lround((0.5 * kSide - from_center.y()) * (1 << kShift)))};
  }

  void contours() const {
    for (const Loop& loop : part_.file().drawing.loops) {
      if (loop.kind == LoopKind::kPrint && face_ == Face::kBack) continue;
      std::vector<std::vector<cv::Point>> line(1);
      for (const Eigen::Vector2d& p : loop.points) line[0].push_back(pixel(p));
      const bool is_print = loop.kind == LoopKind::kPrint;
      const cv::Scalar fill = loop.kind == LoopKind::kOuter ? kMetal : kPaper;
      if (!is_print) cv::fillPoly(*canvas_, line, fill, cv::LINE_AA, kShift);
      cv::polylines(*canvas_, line, loop.closed, is_print ? kPrint : kInk, is_print ? 1 : 2,
                    cv::LINE_AA, kShift);
    }
  }

  void axes() const {
    const double length = 0.2 * box_.sizes().maxCoeff();
    arrow({length, 0.0}, kAxisX);
    arrow({0.0, length}, kAxisY);
  }

  void size() const {
    char words[60];
    std::snprintf(words, sizeof words, "%.1f x %.1f mm", 1e3 * box_.sizes().x(),
                  1e3 * box_.sizes().y());
    write(words, {left_ + kMargin, kSide - 20}, kInk);
    write(face_ == Face::kFront ? "front up" : "back up", {left_ + kMargin, 30}, kInk);
  }

  void picks() const {
    const FaceFilter other = face_ == Face::kFront ? FaceFilter::kBack : FaceFilter::kFront;
    for (const PickPose& pick : part_.pickPoses()) {
      if (pick.face == other) continue;
      const Eigen::Vector2d contact = pick.T_part_pick.translation().head<2>();
      const cv::Point at = pixel(contact);
      constexpr int kDot = 4;
      cv::circle(*canvas_, at, kDot << kShift, kPick, cv::FILLED, cv::LINE_AA, kShift);
      const double radius = part_.file().tool.radius.value_or(0.0);
      if (radius > 0.0) {
        const int pixels = static_cast<int>(std::lround(radius * scale_ * (1 << kShift)));
        cv::circle(*canvas_, at, pixels, kPick, 1, cv::LINE_AA, kShift);
      }
      const Eigen::Vector2d x = pick.T_part_pick.linear().col(0).head<2>();
      cv::line(*canvas_, at, pixel(contact + 0.06 * box_.sizes().maxCoeff() * x), kPick, 2,
               cv::LINE_AA, kShift);
      write(pick.name, {(at.x >> kShift) + 8, (at.y >> kShift) - 8}, kPick);
    }
  }

  void write(const std::string& words, const cv::Point& at, const cv::Scalar& color) const {
    constexpr double kSize = 0.5;
    cv::putText(*canvas_, words, at, cv::FONT_HERSHEY_SIMPLEX, kSize, color, 1, cv::LINE_AA);
  }

 private:
  void arrow(const Eigen::Vector2d& tip, const cv::Scalar& color) const {
    cv::arrowedLine(*canvas_, pixel(Eigen::Vector2d::Zero()), pixel(tip), color, 2, cv::LINE_AA,
                    kShift, 0.15);
  }

  cv::Mat* canvas_;
  const PartModel& part_;
  Face face_;
  int left_;
  Eigen::AlignedBox2d box_;
  double scale_ = 1.0;
};

/// Words in lines of so many characters.
std::vector<std::string> wrapped(const std::string& text) {
  constexpr std::size_t kMost = 2 * kSide / 9;
  std::vector<std::string> lines;
  for (std::string rest = text; !rest.empty();) {
    std::size_t end = rest.size() > kMost ? rest.rfind(' ', kMost) : rest.size();
    if (end == std::string::npos || end == 0) end = std::min(rest.size(), kMost);
    lines.push_back(rest.substr(0, end));
    rest.erase(0, end + 1);
  }
  return lines;
}

}  // namespace

cv::Mat drawPart(const PartModel& part) {
  const PartSummary summary = describePart(part);
  const std::vector<std::string> facts = wrapped(summary.part + ": " + toLine(summary));
  std::vector<std::string> warnings;
  for (const std::string& warning : summary.warnings)
    for (const std::string& line : wrapped(warning)) warnings.push_back(line);
  const int lines = static_cast<int>(facts.size() + warnings.size()) + 1;
  cv::Mat canvas(kSide + kLine * lines, 2 * kSide, CV_8UC3, kPaper);
  for (const Face face : {Face::kFront, Face::kBack}) {
    const Panel panel(&canvas, part, face, face == Face::kFront ? 0 : kSide);
    panel.contours();
    panel.axes();
    panel.picks();
    panel.size();
  }
  const Panel below(&canvas, part, Face::kFront, 0);
  int y = kSide - kLine / 3;
  for (const std::string& line : facts) below.write(line, {kLine, y += kLine}, kInk);
  for (const std::string& line : warnings) below.write(line, {kLine, y += kLine}, kWarning);
  return canvas;
}

}  // namespace planar_bin_picking
