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

/// The camera about the board: from above, and from the side.
void posesPlot(const HandEyeResult& r, int across, const char* caption, Page* page) {
  double reach = 1e-3;
  std::vector<std::pair<Eigen::Isometry3d, std::size_t>> cameras;
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    if (!r.views[i].used) continue;
    cameras.emplace_back(r.views[i].T_camera_board.inverse(), i);
    reach = std::max(reach, cameras.back().first.translation().cwiseAbs().maxCoeff());
  }
  const double scale = 0.45 * kPlot / reach, middle = 0.5 * kPlot;
  const auto place = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2d(middle + scale * p.x(), middle + scale * p[across]);
  };
  *page << "<figure><svg viewBox='0 0 320 320'><rect width='320' height='320' class=f />"
           "<path d='M150 160H170M160 150V170' class=l />\n";
  for (const auto& [T_board_camera, i] : cameras) {
    const Eigen::Vector2d from = place(T_board_camera.translation());
    const Eigen::Vector2d to = place(T_board_camera * Eigen::Vector3d(0.0, 0.0, 0.15 * reach));
    dot(page, from.x(), from.y(), 3.0, colourOf(i));
    (*page << "<path class=l d='M").number(from.x()) << " ";
    page->number(from.y()) << "L";
    page->number(to.x()) << " ";
    page->number(to.y()) << "'/>\n";
  }
  label(page, 316.0, 316.0, "board x, m", "end");
  label(page, 4.0, 12.0, across == 1 ? "board y, m" : "board z, m");
  (*page << "</svg><figcaption>" << caption
         << "; the cross is the board's corner, half the frame is ")
          .number(reach / 0.9, 3)
      << " m</figcaption></figure>\n";
}

}  // namespace planar_bin_picking
