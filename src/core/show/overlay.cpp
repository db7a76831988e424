// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/show/overlay.h"

#include "planar_bin_picking/image/grey.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking {
namespace {

const cv::Scalar kFrontColor(80, 220, 60), kBackColor(30, 140, 255);      // BGR: green, orange
const cv::Scalar kOcclusionColor(60, 60, 230);                            // red
const cv::Scalar kRefusedColor(170, 170, 170), kPickColor(255, 60, 255);  // grey, magenta
const cv::Scalar kRegionColor(255, 230, 60);                              // light blue
const cv::Scalar kDark(0, 0, 0), kLight(255, 255, 255);
constexpr double kSmall = 0.7;  // letters of the legend and of reasons; ranks have 1
constexpr int kShift = 4;       ///< binary digits behind the point in OpenCV's drawing coordinates

/// 8-bit colour; 16 bits are stretched so that the brightest thousandth saturates.
cv::Mat toColor(const cv::Mat& image) {
  if (image.channels() != 1 || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw std::invalid_argument("drawOverlay: the image must be 8- or 16-bit with one channel");
  }
  cv::Mat grey = toEightBits(image);
  if (image.depth() == CV_16U) {
    std::vector<std::uint8_t> values;
    for (int row = 0; row < grey.rows; row += 4) {
      for (int col = 0; col < grey.cols; col += 4)
        values.push_back(grey.at<std::uint8_t>(row, col));
    }
    const auto bright = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 999 / 1000);
    std::nth_element(values.begin(), bright, values.end());
    grey.convertTo(grey, CV_8U, 255.0 / std::max<int>(1, *bright));
  }
  cv::Mat color;
  cv::cvtColor(grey, color, cv::COLOR_GRAY2BGR);
  return color;
}

/// Draws lines given in the camera frame, bent as the lens bends them.
class Pen {
 public:
  Pen(cv::Mat* canvas, const Camera& camera) : canvas_(canvas), camera_(camera) {
    const double width = canvas->cols, height = canvas->rows;
    for (const double u : {0.0, width}) {
      for (const double v : {0.0, height}) {
        const double corner = camera.undistort({u, v}).norm();
        field_radius_ = std::max(field_radius_, 1.5 * corner);
      }
    }
    unit_ = std::max(1, static_cast<int>(std::lround(std::max(width, height) / 1200.0)));
  }

  /// Line width and the like grow with the image.
  int unit() const { return unit_; }

  std::optional<cv::Point> pixel(const Eigen::Vector3d& p_camera) const {
    // Far outside the view a lens model says nothing, or folds back into the image.
    if (p_camera.z() <= 0.0 || (p_camera.head<2>() / p_camera.z()).norm() > field_radius_)
      return {};
    const Eigen::Vector2d p = camera_.project(p_camera) * (1 << kShift);
    return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  }

  /// The polyline in pixels, bent, in the sections that lie within the view. Points nearer than
  /// anyone sees are left out: drawing is what takes the time.
  std::vector<std::vector<cv::Point>> trace(const std::vector<Eigen::Vector3d>& points) const {
    constexpr int kPieces = 8;  // per side; short ones merge again
    std::vector<std::vector<cv::Point>> sections(1);
    const auto add = [&](const Eigen::Vector3d& p_camera, bool corner) {
      const auto p = pixel(p_camera);
      std::vector<cv::Point>& section = sections.back();
      if (!p) {
        if (!section.empty()) sections.emplace_back();
      } else if (section.empty() || cv::norm(*p - section.back()) > (corner ? 3 : 40) << kShift) {
        section.push_back(*p);
      }
    };
    for (std::size_t i = 1; i < points.size(); ++i) {
      for (int k = 0; k < kPieces; ++k) {
        add(points[i - 1] + (points[i] - points[i - 1]) * (static_cast<double>(k) / kPieces),
            k == 0);
      }
    }
    const auto last = pixel(points.back());
    if (last && !sections.back().empty()) sections.back().push_back(*last);
    return sections;
  }

  void draw(const std::vector<std::vector<cv::Point>>& sections, const cv::Scalar& color,
            int width) {
    cv::polylines(*canvas_, sections, false, color, width, cv::LINE_AA, kShift);
  }

  void dot(const Eigen::Vector3d& p_camera, const cv::Scalar& color) {
    if (const auto p = pixel(p_camera))
      cv::circle(*canvas_, *p, unit_ << kShift, color, cv::FILLED, cv::LINE_AA, kShift);
  }

  void circle(const Eigen::Vector3d& p_camera, int radius, const cv::Scalar& color) {
    if (const auto p = pixel(p_camera))
      cv::circle(*canvas_, *p, (radius * unit_) << kShift, color, 2 * unit_, cv::LINE_AA, kShift);
  }

  /// Text centred on a pixel, readable on any ground.
  /// @param size  of its letters; 1 for ranks
  void label(const std::string& text, const cv::Point& center, const cv::Scalar& color,
             const double relative_size = 1.0) {
    const double scale = 0.8 * relative_size * unit_;
    const int stroke = relative_size < 1.0 ? unit_ : 2 * unit_;
    int below = 0;
    const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, scale, stroke, &below);
    const cv::Point corner(center.x - size.width / 2, center.y + size.height / 2);
    const cv::Rect box(corner.x - 3 * unit_, corner.y - size.height - 3 * unit_,
                       size.width + 6 * unit_, size.height + 6 * unit_ + below / 2);
    cv::rectangle(*canvas_, box, kDark, cv::FILLED);
    cv::rectangle(*canvas_, box, color, unit_);
    cv::putText(*canvas_, text, corner, cv::FONT_HERSHEY_SIMPLEX, scale, kLight, stroke,
                cv::LINE_AA);
  }

  /// Lines of text, each beside a patch of its colour, in the lower left corner.
  void legend(const std::vector<std::pair<std::string, cv::Scalar>>& lines) {
    const int line = 24 * unit_, count = static_cast<int>(lines.size());
    int width = 0, below = 0;
    for (const auto& [text, color] : lines) {
      const auto size =
          cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kSmall * unit_, unit_, &below);
      width = std::max(width, size.width);
    }
    const int top = canvas_->rows - line * count - 8 * unit_;
    const cv::Rect all(0, 0, canvas_->cols, canvas_->rows);
    const cv::Rect box =
        cv::Rect(4 * unit_, top, width + 34 * unit_, line * count + 4 * unit_) & all;
    if (box.area() == 0) return;
    (*canvas_)(box) *= 0.35;
    for (int i = 0; i < count; ++i) {
      const int y = top + line * (i + 1) - 5 * unit_;
      cv::rectangle(*canvas_, {10 * unit_, y - 9 * unit_}, {22 * unit_, y}, lines[i].second,
                    cv::FILLED);
      cv::putText(*canvas_, lines[i].first, {30 * unit_, y}, cv::FONT_HERSHEY_SIMPLEX,
                  kSmall * unit_, kLight, unit_, cv::LINE_AA);
    }
  }

 private:
  cv::Mat* canvas_;
  const Camera& camera_;
  double field_radius_ = 0.0;
  int unit_ = 1;
};

Eigen::Vector3d onFace(const PartModel& part, const Detection& detection,
                       const Eigen::Vector2d& p) {
  return detection.T_camera_part * Eigen::Vector3d(p.x(), p.y(), part.faceZ(detection.face));
}

cv::Scalar colorOf(const Detection& detection) {
  return detection.face == Face::kFront ? kFrontColor : kBackColor;
}

void drawOutline(Pen* pen, const PartModel& part, const Detection& detection,
                 const cv::Scalar& color) {
  for (const Loop& loop : part.file().drawing.loops) {
    const bool print = loop.kind == LoopKind::kPrint;
    if (print && detection.face == Face::kBack) continue;
    std::vector<Eigen::Vector3d> points;
    for (const Eigen::Vector2d& p : loop.points) points.push_back(onFace(part, detection, p));
    if (loop.closed) points.push_back(points.front());
    const auto sections = pen->trace(points);
    if (!print) pen->draw(sections, kDark, 3 * pen->unit());
    pen->draw(sections, color, print ? pen->unit() : 2 * pen->unit());
  }
}

/// A dot on each cell that something covers.
void drawOcclusion(Pen* pen, const PartModel& part, const Detection& detection) {
  for (const int cell : detection.covered)
    pen->dot(onFace(part, detection, part.faceGrid().cells().at(cell)), kOcclusionColor);
}

/// The part frame's axes at the drawing's origin: x red, y green, z blue.
void drawAxes(Pen* pen, const PartModel& part, const Detection& detection) {
  const cv::Scalar colors[] = {{40, 40, 255}, {40, 200, 40}, {255, 100, 40}};
  const Eigen::Isometry3d& T_camera_part = detection.T_camera_part;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d tip = 0.4 * part.radius() * Eigen::Vector3d::Unit(axis);
    pen->draw(pen->trace({T_camera_part.translation(), T_camera_part * tip}), colors[axis],
              2 * pen->unit());
  }
}

/// Its contact, and from where the tool comes.
void drawPick(Pen* pen, const Eigen::Isometry3d& T_camera_pick) {
  constexpr double kStroke = 0.02;  // metres
  const Eigen::Vector3d from = T_camera_pick * Eigen::Vector3d(0.0, 0.0, -kStroke);
  pen->draw(pen->trace({from, T_camera_pick.translation()}), kPickColor, 2 * pen->unit());
  pen->circle(T_camera_pick.translation(), 4, kPickColor);
}

/// Of what may be in the picture.
void drawLegend(const OverlayMore& more, Pen* pen) {
  std::vector<std::pair<std::string, cv::Scalar>> lines = {
      {"front up, with its rank", kFrontColor},
      {"back up, with its rank", kBackColor},
      {"something covers it", kOcclusionColor}};
  if (!more.refused.empty()) lines.emplace_back("refused, with the reason", kRefusedColor);
  if (!more.T_camera_pick.empty()) lines.emplace_back("pick pose", kPickColor);
  if (!more.outlines.empty()) lines.emplace_back("bin, region", kRegionColor);
  pen->legend(lines);
}

/// The middle of the visible face.
std::optional<cv::Point> middleOf(const Pen& pen, const PartModel& part,
                                  const Detection& detection) {
  const auto center = pen.pixel(onFace(part, detection, part.symmetry().center));
  if (!center) return std::nullopt;
  return cv::Point(center->x >> kShift, center->y >> kShift);
}

void drawRefused(Pen* pen, const PartModel& part, const OverlayMore::Refused& refused) {
  drawOutline(pen, part, refused.detection, kRefusedColor);
  if (const auto center = middleOf(*pen, part, refused.detection))
    pen->label(refused.reason, *center, kRefusedColor, kSmall);
}

}  // namespace

cv::Mat drawOverlay(const cv::Mat& image, const Camera& camera,
                    const std::vector<std::shared_ptr<const PartModel>>& parts,
                    const std::vector<Detection>& detections, const OverlayMore& more) {
  cv::Mat canvas = toColor(image);
  Pen pen(&canvas, camera);
  for (std::vector<Eigen::Vector3d> outline : more.outlines) {
    if (outline.empty()) continue;
    outline.push_back(outline.front());
    pen.draw(pen.trace(outline), kRegionColor, 2 * pen.unit());
  }
  for (const auto& refused : more.refused)
    drawRefused(&pen, *parts.at(refused.detection.part), refused);
  // From the last to the first: the best is never painted over.
  for (std::size_t rank = detections.size(); rank-- > 0;) {
    const Detection& detection = detections[rank];
    const PartModel& part = *parts.at(detection.part);
    drawOcclusion(&pen, part, detection);
    drawOutline(&pen, part, detection, colorOf(detection));
    drawAxes(&pen, part, detection);
  }
  for (std::size_t rank = detections.size(); rank-- > 0;) {
    const Detection& detection = detections[rank];
    const auto center = middleOf(pen, *parts.at(detection.part), detection);
    if (!center) continue;
    const std::string name = parts.size() > 1 ? " " + detection.part_name : "";
    pen.label(std::to_string(rank + 1) + name, *center, colorOf(detection));
  }
  for (const Eigen::Isometry3d& T_camera_pick : more.T_camera_pick) drawPick(&pen, T_camera_pick);
  if (more.has_legend) drawLegend(more, &pen);
  return canvas;
}

}  // namespace planar_bin_picking
