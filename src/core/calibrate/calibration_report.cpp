// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration_report.h"

#include "calibrate/hand_eye/verdict.h"
#include "calibrate/report_plots.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace planar_bin_picking {
namespace {

void row(Page* page, const std::string& name, double value, const std::string& unit,
         const std::string& remark, int digits = 4) {
  (*page << "<tr><td>").text(name) << "</td><td class=n>";
  page->number(value, digits) << " " << unit << "</td><td>" << remark << "</td></tr>\n";
}

std::string plusMinus(double sigma, const std::string& unit) {
  Page text;
  text << "&plusmn; ";
  text.number(sigma, 2) << " " << unit;
  return text.str();
}

/// @param what  "limit", "at least", or what it is beyond the limit
std::string limitText(double limit, const std::string& unit, const std::string& key,
                      const std::string& what = "limit") {
  Page text;
  text << what << " ";
  text.number(limit) << unit << " (" << key << ")";
  return text.str();
}

/// Digits of what other programs use: finer than any sigma.
constexpr int kFine = 7;

/// Transform and camera.
void resultRows(const HandEyeResult& r, Page* page) {
  const auto sigma = [&r](int i) { return std::sqrt(r.covariance(i, i)); };
  const char axes[] = "xyz";
  for (int i = 0; i < 3; ++i) {
    row(page, r.transform_name + " " + axes[i], 1e3 * r.T_mount_camera.translation()[i], "mm",
        plusMinus(1e3 * sigma(kHandEye + i), "mm, along the camera's axis"), kFine);
  }
  Eigen::Quaterniond q(r.T_mount_camera.linear());
  for (int i = 0; i < 4; ++i) {
    row(page, r.transform_name + " q" + "xyzw"[i], q.coeffs()[i], "",
        i < 3 ? plusMinus(57.29578 * sigma(kHandEye + 3 + i), "deg about the camera's axis") : "",
        kFine);
  }
  const double intrinsics[] = {r.camera.fx, r.camera.fy, r.camera.cx, r.camera.cy};
  const char* const names[] = {"fx", "fy", "cx", "cy"};
  for (int i = 0; i < 4; ++i) {
    row(page, names[i], intrinsics[i], "px", plusMinus(sigma(kIntrinsics + i), "px"), kFine);
  }
  const std::string coefficients = "k1k2p1p2k3k4k5k6";
  for (std::size_t i = 0; i < r.camera.distortion.size() && i < 8; ++i) {
    row(page, coefficients.substr(2 * i, 2), r.camera.distortion[i], "",
        plusMinus(sigma(4 + static_cast<int>(i)), ""));
  }
}

const char kPoorAbove[] = "POOR above", kRefusedAbove[] = "REFUSED above";

/// What it was judged by.
void qualityRows(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  const HandEyeParams& limits = r.params;
  row(page, "expected error, position", r.expected_error_mm, "mm",
      limitText(limits.tolerance_mm, " mm", "tolerance_mm") +
          "; RMS of a part's pose at the working distance, with a robot that goes where it says");
  row(page, "expected error, rotation", r.expected_error_deg, "deg",
      limitText(limits.tolerance_deg, " deg", "tolerance_deg"));
  row(page, "with the robot's noise, position", r.with_robot_mm, "mm",
      "looking and going there with the noise below");
  row(page, "with the robot's noise, rotation", r.with_robot_deg, "deg", "");
  row(page, "working distance", r.working_distance, "m", "");
  row(page, "residual", r.rms_px, "px", "robot poses corrected");
  if (r.own_camera_px > 0.0) {
    row(page, "residual with an own camera", r.own_camera_px, "px",
        "the pictures contradict the given one");
  }
  row(page, "residual of the chain", r.chain_px, "px", "robot poses as reported");
  row(page, "floor", r.pnp_floor_px, "px", "each board placed freely");
  row(page, "robot noise", r.robot_mm, "mm",
      "per axis, estimated; " +
          limitText(limits.robot_poor_mm, " mm", "robot_poor_mm", kPoorAbove) + ", " +
          limitText(limits.robot_refused_mm, " mm", "robot_refused_mm", kRefusedAbove));
  row(page, "robot noise", r.robot_deg, "deg",
      "per axis, estimated; " +
          limitText(limits.robot_poor_deg, " deg", "robot_poor_deg", kPoorAbove) + ", " +
          limitText(limits.robot_refused_deg, " deg", "robot_refused_deg", kRefusedAbove));
  row(page, "square that fits", 1e3 * problem.board.square * r.square_ratio, "mm",
      plusMinus(1e3 * problem.board.square * r.square_ratio_sigma, "mm") + "; " +
          limitText(100.0 * limits.scale_tolerance, " % off", "scale_tolerance"));
  row(page, "turn about the second axis", r.axes_deg, "deg",
      limitText(limits.axes_min_deg, " deg", "axes_min_deg", "at least"));
  row(page, "views used", r.views_used, "",
      limitText(limits.min_views, "", "min_views", "at least"));
  for (const LensTrial& trial : r.lens_trials) {
    row(page, "lens of " + std::to_string(trial.coefficients) + " coefficients", trial.held_out_px,
        "px",
        std::string("held-out pictures, boards placed freely") +
            (trial.is_chosen ? "; chosen" : ""));
  }
  const LeaveOneOutLimits moves = leaveOneOutLimits(limits, r);
  row(page, "leave one view out", r.leave_one_out_mm, "mm",
      "largest move of the camera; " +
          limitText(moves.poor, " mm", "by sigma and tolerance_mm", kPoorAbove) + ", " +
          limitText(moves.refused, " mm", "likewise", kRefusedAbove));
  row(page, "leave one view out", r.leave_one_out_deg, "deg", "");
}

void numbers(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  *page << "<h2>Numbers</h2><table>\n";
  qualityRows(problem, r, page);
  resultRows(r, page);
  *page << "</table>\n";
}

void viewTable(const HandEyeProblem& problem, const HandEyeResult& r, Page* page) {
  *page << "<h2>Views</h2><table><tr><th>view</th><th>corners</th><th>residual "
           "px</th><th>mm</th><th>floor px</th>"
           "<th>robot off mm</th><th>deg</th><th></th></tr>\n";
  for (std::size_t i = 0; i < r.views.size(); ++i) {
    const ViewResult& view = r.views[i];
    (*page << "<tr><td>").text(problem.observations[i].name) << "</td>";
    if (view.used) {
      for (const double value :
           {1.0 * problem.observations[i].corners.size(), view.rms_px, view.rms_mm, view.floor_px,
            1e3 * view.correction.head<3>().norm(), 57.29578 * view.correction.tail<3>().norm()}) {
        *page << "<td class=n>";
        page->number(value, 3) << "</td>";
      }
      *page << "<td></td></tr>\n";
    } else {
      (*page << "<td colspan=6></td><td>not used: ").text(view.why_not) << "</td></tr>\n";
    }
  }
  *page << "</table>\n";
}

/// Where they lie; whoever moves the report has no pictures in it.
void pictureTable(const HandEyeProblem& problem, const std::string& pictures, Page* page) {
  *page << "<h2>Pictures</h2>\n";
  for (const Observation& observation : problem.observations) {
    (*page << "<img loading='lazy' alt='").text(observation.name) << "' title='";
    (page->text(observation.name) << "' src='").text(pictures + observation.name) << "'>\n";
  }
}

}  // namespace

std::string calibrationReport(const HandEyeProblem& problem, const HandEyeResult& result,
                              const std::string& made, const std::string& pictures) {
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
          ".l{stroke:#888;fill:none;stroke-width:.7}.t{font-size:11px;fill:#333}"
          "img{width:24%;margin:0 .5% .5% 0}figcaption{color:#555;font-size:12px}</style>"
          "</head><body>\n<h1 style='color:"
       << colour << "'>" << nameOf(result.verdict) << "</h1>\n";
  if (!made.empty()) (page << "<p>").text(made) << "</p>\n";
  (page << "<p>").text(result.transform_name) << ", board " << problem.board.cols << " x "
                                              << problem.board.rows << " inner corners, square ";
  page.number(1e3 * problem.board.square)
      << " mm, " << result.views_used << " of " << problem.observations.size()
      << " views used</p>\n<ul>\n";
  for (const std::string& reason : result.reasons) (page << "<li>").text(reason) << "</li>\n";
  for (const std::string& note : result.notes) (page << "<li>note: ").text(note) << "</li>\n";
  page << "</ul>\n";
  if (result.solved) {
    residualPlot(result, &page);
    residualVectorPlot(problem, result, &page);
    uncertaintyMap(problem, result, &page);
    posesPlot(problem.board, result, 2, "Cameras about the board, from the side", &page);
    posesPlot(problem.board, result, 1, "The same as the cameras see the board", &page);
    numbers(problem, result, &page);
  }
  viewTable(problem, result, &page);
  pictureTable(problem, pictures, &page);
  page << "</body></html>\n";
  return page.str();
}

}  // namespace planar_bin_picking
