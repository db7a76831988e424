// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/report_plots.h"

#include "calibrate/hand_eye/verdict.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace planar_bin_picking {
namespace {

constexpr double kPlot = 320.0;  // height of the drawings, SVG units

void dot(Page* page, double x, double y, double radius, const std::string& colour) {
  *page << "<circle cx='";
  page->number(x) << "' cy='";
  page->number(y) << "' r='" << radius << "' fill='" << colour << "'/>\n";
}

std::string colourOf(std::size_t i) { return "hsl(" + std::to_string(i * 137 % 360) + ",70%,40%)"; }

void label(Page* page, double x, double y, const std::string& text, const char* anchor = "start") {
  *page << "<text class=t text-anchor='" << anchor << "' x='";
  page->number(x) << "' y='";
  (page->number(y) << "'>").text(text) << "</text>\n";
}

std::string shortNumber(double value) {
  Page text;
  text.number(value, 3);
  return text.str();
}

/// Begins a drawing of the image, `kPlot` high, with its size on its axes. @return  its scale
double beginImage(const HandEyeProblem& problem, Page* page) {
  const double scale = kPlot / problem.height, width = scale * problem.width;
  (*page << "<figure><svg viewBox='-2 -14 ").number(width + 4.0) << " 336'><rect height='320' "
                                                                 << "class=f width='";
  page->number(width) << "'/>\n";
  label(page, width, -3.0, "u " + std::to_string(problem.width) + " px", "end");
  label(page, 0.0, -3.0, "0, v down to " + std::to_string(problem.height) + " px");
  return scale;
}

void line(Page* page, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
          const std::string& colour) {
  *page << "<path stroke='" << colour << "' stroke-width='.8' d='M";
  page->number(from.x()) << " ";
  page->number(from.y()) << "L";
  page->number(to.x()) << " ";
  page->number(to.y()) << "'/>\n";
}

}  // namespace

/// Residuals of all corners about zero; the ring is three standard deviations.
void residualPlot(const HandEyeResult& r, Page* page) {
  double largest = 3.0 * r.sigma_px;
  for (const ViewResult& view : r.views) {
    for (const Eigen::Vector2d& e : view.residuals) largest = std::max(largest, e.norm());
  }
  const double scale = 0.48 * kPlot / largest, middle = 0.5 * kPlot;
  (*page << "<figure><svg viewBox='0 0 320 320'><rect width='320' height='320' class=f />"
            "<path d='M0 160H320M160 0V320' class=l /><circle cx='160' cy='160' class=l r='")
          .number(3.0 * r.sigma_px * scale)
      << "'/>\n";
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    for (const Eigen::Vector2d& e : r.views[i].residuals) {
      dot(page, middle + scale * e.x(), middle + scale * e.y(), 1.2, colourOf(i));
    }
  }
  label(page, 316.0, 155.0, "u " + shortNumber(middle / scale) + " px", "end");
  label(page, 164.0, 314.0, "v " + shortNumber(middle / scale) + " px");
  (*page << "</svg><figcaption>Residuals, a colour per view; the frame is &plusmn;")
          .number(middle / scale, 3)
      << " px, the ring three standard deviations</figcaption></figure>\n";
}

void residualVectorPlot(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  const double scale = beginImage(problem, page);
  // Three standard deviations are as long as this, SVG units.
  constexpr double kLong = 18.0;
  const double enlarged = kLong / std::max(1e-6, 3.0 * r.sigma_px);
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    const ViewResult& view = r.views[i];
    const std::string colour = view.used ? colourOf(i) : "#ccc";
    const std::vector<Eigen::Vector2d>& corners = problem.observations[i].corners;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Eigen::Vector2d at = scale * corners[k];
      dot(page, at.x(), at.y(), 1.2, colour);
      if (k < view.residuals.size()) line(page, at, at + enlarged * view.residuals[k], colour);
    }
  }
  line(page, {4.0, kPlot - 6.0}, {4.0 + kLong, kPlot - 6.0}, "#000");
  label(page, 8.0 + kLong, kPlot - 3.0, shortNumber(kLong / enlarged) + " px");
  (*page << "</svg><figcaption>Corners in the image with their residuals, enlarged ")
          .number(enlarged / scale, 3)
      << " times; grey: not used</figcaption></figure>\n";
}

void uncertaintyMap(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  constexpr int kCols = 16, kRows = 12;
  std::vector<double> errors;
  const Chain chain = chainOf(problem, r);
  for (int row = 0; row < kRows; ++row) {
    for (int col = 0; col < kCols; ++col) {
      const Eigen::Vector2d place((col + 0.5) / kCols, (row + 0.5) / kRows);
      const ErrorModel model(chain, problem.width, problem.height, r.working_distance, {place});
      errors.push_back(1e3 * model.of(r.covariance).metres);
    }
  }
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  const double scale = beginImage(problem, page);
  const double width = scale * problem.width / kCols, height = kPlot / kRows;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const double share = (errors[i] - *least) / std::max(1e-9, *most - *least);
    // Blue is good, red is bad.
    *page << "<rect fill='hsl(" << static_cast<int>(220.0 * (1.0 - share)) << ",70%,60%)' x='";
    page->number(width * static_cast<double>(i % kCols)) << "' y='";
    page->number(height * static_cast<double>(i / kCols)) << "' width='";
    page->number(width) << "' height='";
    page->number(height) << "'><title>" << shortNumber(errors[i]) << " mm</title></rect>\n";
  }
  const std::size_t middle = static_cast<std::size_t>(kRows / 2 * kCols + kCols / 2);
  label(page, 4.0, 14.0, shortNumber(errors.front()) + " mm");
  label(page, width * kCols - 4.0, 14.0, shortNumber(errors[kCols - 1]) + " mm", "end");
  label(page, 4.0, kPlot - 6.0, shortNumber(errors[errors.size() - kCols]) + " mm");
  label(page, width * kCols - 4.0, kPlot - 6.0, shortNumber(errors.back()) + " mm", "end");
  label(page, 0.5 * width * kCols, 0.5 * kPlot, shortNumber(errors[middle]) + " mm", "middle");
  (*page << "</svg><figcaption>Uncertainty map: expected error of a part's position at ")
          .number(r.working_distance, 3)
      << " m, one standard deviation of its length; red: " << shortNumber(*most)
      << " mm, blue: " << shortNumber(*least) << " mm</figcaption></figure>\n";
}

void posesPlot(const Board& board, const HandEyeResult& r, int across, const char* caption,
               Page* page) {
  std::vector<Eigen::Vector2d> points;  // in the drawing's plane, metres
  const auto flat = [across](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(p.x(), p[across]);
  };
  const double right = board.square * board.cols, down = board.square * board.rows;
  for (const auto& [x, y] : {std::pair(-board.square, -board.square), {right, down}}) {
    points.push_back(flat({x, y, 0.0}));
  }
  std::vector<std::size_t> views;
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    if (!r.views[i].used) continue;
    const Eigen::Isometry3d T_board_camera = r.views[i].T_camera_board.inverse();
    views.push_back(i);
    points.push_back(flat(T_board_camera.translation()));
    // A part of the way along the optical axis.
    points.push_back(flat(T_board_camera * Eigen::Vector3d(0.0, 0.0, 0.15 * r.working_distance)));
  }
  Eigen::Vector2d low = points[0], high = points[0];
  for (const Eigen::Vector2d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double scale = 0.85 * kPlot / std::max(1e-3, (high - low).maxCoeff());
  const Eigen::Vector2d middle = 0.5 * (low + high), frame = Eigen::Vector2d::Constant(0.5 * kPlot);
  for (Eigen::Vector2d& p : points) p = frame + scale * (p - middle);
  *page << "<figure><svg viewBox='0 0 320 320'><rect width='320' height='320' class=f />\n";
  const Eigen::Vector2d &near = points[0], &far = points[1];
  line(page, near, {far.x(), near.y()}, "#000");
  line(page, {far.x(), near.y()}, far, "#000");
  line(page, far, {near.x(), far.y()}, "#000");
  line(page, {near.x(), far.y()}, near, "#000");
  for (std::size_t k = 0; k < views.size(); ++k) {
    dot(page, points[2 + 2 * k].x(), points[2 + 2 * k].y(), 3.0, colourOf(views[k]));
    line(page, points[2 + 2 * k], points[3 + 2 * k], "#888");
  }
  const Eigen::Vector2d first = middle - frame / scale, last = middle + frame / scale;
  const auto range = [&](const std::string& axis, int i) {
    return "board " + axis + " " + shortNumber(first[i]) + " to " + shortNumber(last[i]) + " m";
  };
  label(page, 316.0, 316.0, range("x", 0), "end");
  label(page, 4.0, 12.0, range(across == 1 ? "y" : "z", 1) + ", down");
  *page << "</svg><figcaption>" << caption << "; black: the board, lines: where they look"
        << "</figcaption></figure>\n";
}

}  // namespace planar_bin_picking
