// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration_report.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace planar_bin_picking {
namespace {

/// Text for HTML; numbers with points, whatever the locale.
class Page {
 public:
  Page() { out_.imbue(std::locale::classic()); }
  template <class T>
  Page& operator<<(const T& value) {
    out_ << value;
    return *this;
  }
  Page& text(const std::string& raw) {
    for (const char c : raw) {
      if (c == '&')
        out_ << "&amp;";
      else if (c == '<')
        out_ << "&lt;";
      else if (c == '>')
        out_ << "&gt;";
      else
        out_ << c;
    }
    return *this;
  }
  Page& number(double value, int digits = 4) {
    out_ << std::setprecision(digits) << value;
    return *this;
  }
  std::string str() const { return out_.str(); }

 private:
  std::ostringstream out_;
};

constexpr double kPlot = 320.0;  // height of the drawings, SVG units

void row(Page* page, const std::string& name, double value, const std::string& unit,
         const std::string& remark) {
  (*page << "<tr><td>").text(name) << "</td><td class=n>";
  page->number(value) << " " << unit << "</td><td>" << remark << "</td></tr>\n";
}

void numbers(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  const auto sigma = [&r](int i) { return std::sqrt(r.covariance(i, i)); };
  const auto plus_minus = [](double s, const std::string& unit) {
    Page text;
    text << "&plusmn; ";
    text.number(s, 2) << " " << unit;
    return text.str();
  };
  *page << "<h2>Numbers</h2><table>\n";
  row(page, "expected error, position", r.expected_error_mm, "mm",
      "RMS of a part's pose at the working distance");
  row(page, "expected error, rotation", r.expected_error_deg, "deg", "");
  row(page, "working distance", r.working_distance, "m", "");
  const char axes[] = "xyz";
  for (int i = 0; i < 3; ++i) {
    row(page, r.transform_name + " " + axes[i], 1e3 * r.T_mount_camera.translation()[i], "mm",
        plus_minus(1e3 * sigma(kHandEye + i), "mm, along the camera's axis"));
  }
  Eigen::Quaterniond q(r.T_mount_camera.linear());
  for (int i = 0; i < 4; ++i) {
    row(page, r.transform_name + " q" + "xyzw"[i], q.coeffs()[i], "",
        i < 3 ? plus_minus(57.29578 * sigma(kHandEye + 3 + i), "deg about the camera's axis") : "");
  }
  const double intrinsics[] = {r.camera.fx, r.camera.fy, r.camera.cx, r.camera.cy};
  const char* const names[] = {"fx", "fy", "cx", "cy"};
  for (int i = 0; i < 4; ++i) {
    row(page, names[i], intrinsics[i], "px", plus_minus(sigma(kIntrinsics + i), "px"));
  }
  const std::string coefficients = "k1k2p1p2k3k4k5k6";
  for (std::size_t i = 0; i < r.camera.distortion.size() && i < 8; ++i) {
    row(page, coefficients.substr(2 * i, 2), r.camera.distortion[i], "",
        i < 5 ? plus_minus(sigma(4 + static_cast<int>(i)), "") : "");
  }
  row(page, "residual", r.rms_px, "px", "robot poses corrected");
  if (r.own_camera_px > 0.0) {
    row(page, "residual with an own camera", r.own_camera_px, "px",
        "the pictures contradict the given one");
  }
  row(page, "residual of the chain", r.chain_px, "px", "robot poses as reported");
  row(page, "floor", r.pnp_floor_px, "px", "each board placed freely");
  row(page, "robot noise", r.robot_mm, "mm", "per axis, estimated");
  row(page, "robot noise", r.robot_deg, "deg", "per axis, estimated");
  row(page, "square that fits", 1e3 * problem.board.square * r.square_ratio, "mm",
      plus_minus(1e3 * problem.board.square * r.square_ratio_sigma, "mm"));
  row(page, "leave one view out", r.leave_one_out_mm, "mm", "largest move of the camera");
  row(page, "leave one view out", r.leave_one_out_deg, "deg", "");
  *page << "</table>\n";
}

void dot(Page* page, double x, double y, double radius, const std::string& colour) {
  *page << "<circle cx='";
  page->number(x) << "' cy='";
  page->number(y) << "' r='" << radius << "' fill='" << colour << "'/>\n";
}

std::string colourOf(std::size_t i) { return "hsl(" + std::to_string(i * 137 % 360) + ",70%,40%)"; }

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
  (*page << "</svg><figcaption>Residuals, a colour per view; the frame is &plusmn;")
          .number(middle / scale, 3)
      << " px, the ring three standard deviations</figcaption></figure>\n";
}

/// Where in the image corners were seen.
void coveragePlot(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  const double scale = kPlot / problem.height, width = scale * problem.width;
  (*page << "<figure><svg viewBox='0 0 ").number(width)
      << " 320'><rect height='320' class=f width='";
  page->number(width) << "'/>\n";
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    const std::string colour = r.views[i].used ? colourOf(i) : "#ccc";
    for (const Eigen::Vector2d& p : problem.observations[i].corners) {
      dot(page, scale * p.x(), scale * p.y(), 1.5, colour);
    }
  }
  *page << "</svg><figcaption>Corners in the image; grey: not used</figcaption></figure>\n";
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
  (*page << "</svg><figcaption>" << caption
         << "; the cross is the board's corner, half the frame is ")
          .number(reach / 0.9, 3)
      << " m</figcaption></figure>\n";
}

void viewTable(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  *page << "<h2>Views</h2><table><tr><th>view</th><th>residual px</th><th>floor px</th>"
           "<th>robot off mm</th><th>deg</th><th></th></tr>\n";
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    const ViewResult& view = r.views[i];
    (*page << "<tr><td>").text(problem.observations[i].name) << "</td>";
    if (view.used) {
      for (const double value : {view.rms_px, view.floor_px, 1e3 * view.correction.head<3>().norm(),
                                 57.29578 * view.correction.tail<3>().norm()}) {
        *page << "<td class=n>";
        page->number(value, 3) << "</td>";
      }
      *page << "<td></td></tr>\n";
    } else {
      (*page << "<td colspan=4></td><td>not used: ").text(view.why_not) << "</td></tr>\n";
    }
  }
  *page << "</table>\n";
}

}  // namespace

std::string calibrationReport(const HandEyeProblem& problem, const HandEyeResult& result,
                              const std::string& made) {
  const std::string colour = result.verdict == Verdict::kGood   ? "#2a7d2a"
                             : result.verdict == Verdict::kPoor ? "#b37700"
                                                                : "#b02020";
  Page page;
  page << "<!DOCTYPE html><html><head><meta charset='utf-8'><title>Calibration: "
       << nameOf(result.verdict)
       << "</title><style>body{font:14px sans-serif;max-width:1050px;margin:1em auto}"
          "table{border-collapse:collapse}td,th{padding:1px 9px;border-bottom:1px solid #ddd}"
          ".n{text-align:right}figure{display:inline-block;width:32%;margin:0 .5% 1em 0;"
          "vertical-align:top}svg{width:100%}.f{fill:#fafafa;stroke:#999}"
          ".l{stroke:#888;fill:none;stroke-width:.7}figcaption{color:#555;font-size:12px}</style>"
          "</head><body>\n<h1 style='color:"
       << colour << "'>" << nameOf(result.verdict) << "</h1>\n";
  if (!made.empty()) (page << "<p>").text(made) << "</p>\n";
  (page << "<p>").text(result.transform_name) << ", board " << problem.board.cols << " x "
                                              << problem.board.rows << " inner corners, square ";
  page.number(1e3 * problem.board.square)
      << " mm, " << result.views_used << " of " << problem.observations.size()
      << " views used</p>\n<ul>\n";
  for (const std::string& reason : result.reasons) (page << "<li>").text(reason) << "</li>\n";
  page << "</ul>\n";
  if (result.solved) {
    residualPlot(result, &page);
    coveragePlot(problem, result, &page);
    posesPlot(result, 2, "Cameras about the board, from the side", &page);
    posesPlot(result, 1, "The same from above", &page);
    numbers(problem, result, &page);
  }
  viewTable(problem, result, &page);
  page << "</body></html>\n";
  return page.str();
}

}  // namespace planar_bin_picking
