// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/hand_eye/verdict.h"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace planar_bin_picking {
namespace {

/// exp(Ad * xi) = T * exp(xi) * T^-1.
Matrix6d adjoint(const Eigen::Isometry3d& T) {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = m.bottomRightCorner<3, 3>() = T.linear();
  m.topRightCorner<3, 3>() = skew<double>(T.translation()) * T.linear();
  return m;
}

/// How the pose of a part that is seen at T_camera_part follows [intrinsics, xi of T_mount_camera].
Eigen::Matrix<double, 6, kBoard> partByCalibration(const Chain& chain,
                                                   const Eigen::Isometry3d& T_camera_part) {
  Chain seen;
  seen.mounting = Mounting::kEyeToHand;
  seen.intrinsics = chain.intrinsics;
  const Board part{2, 2, 0.1 * T_camera_part.translation().z()};
  seen.T_other_board.translation() = Eigen::Vector3d(-0.5, -0.5, 0.0) * part.square;
  Eigen::Matrix<double, 6, kBoard> out = Eigen::Matrix<double, 6, kBoard>::Zero();
  const auto prediction = predict(seen, T_camera_part, Increment(), part.points(), true);
  if (!prediction) return out;
  // The pixels stay: what the intrinsics move, the pose has to move back.
  out.leftCols<kHandEye>() = -prediction->correction.colPivHouseholderQr().solve(
      prediction->shared.middleCols(kIntrinsics, kHandEye));
  out.rightCols<6>() = adjoint(T_camera_part.inverse());
  return out;
}

std::string number(double value, int digits) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::setprecision(digits) << value;
  return out.str();
}

std::string millimetres(double value) { return number(value, 3) + " mm"; }
std::string degrees(double value) { return number(value, 3) + " deg"; }

/// Reasons of both weights, the refusing ones first.
struct Reasons {
  std::vector<std::string> refusing, limiting;
};

void judgeViews(const HandEyeProblem& problem, const HandEyeParams& params,
                const Findings& findings, const HandEyeResult& result, Reasons* reasons) {
  std::size_t unused = 0;
  for (const ViewResult& view : result.views) unused += view.why_not.empty() ? 0 : 1;
  const std::size_t count = problem.observations.size() - findings.repeated;
  const std::size_t wrong = unused - findings.repeated;
  if (findings.late_by_one) {
    reasons->refusing.push_back(
        "tf is stale: the robot poses fit the pictures taken one pose before; look the robot up at "
        "the "
        "image's stamp, and wait until it stands still");
  } else if (!findings.stale.empty()) {
    const std::string text =
        "tf is stale: the board moved between pictures whose robot poses are the same (" +
        findings.stale.front() + ")";
    (4 * findings.stale.size() > count ? reasons->refusing : reasons->limiting).push_back(text);
  }
  if (count == 1 && findings.repeated >= 2) {
    reasons->refusing.push_back(
        "the robot does not move: the board stands at the same place in all " +
        std::to_string(problem.observations.size()) +
        " pictures; check that the robot carries out its moves, and that the pictures are new");
  } else if (4 * findings.frozen.size() > problem.observations.size()) {
    reasons->refusing.push_back(
        "the pictures are old: they are the same while the robot went elsewhere (" +
        findings.frozen.front() + "); check the camera's driver and that the board is fixed");
  }
  if (result.views_used < params.min_views) {
    reasons->refusing.push_back("too few views: " + std::to_string(result.views_used) +
                                " can be used of " + std::to_string(problem.observations.size()) +
                                (findings.repeated > 0 ? " (" + std::to_string(findings.repeated) +
                                                             " show a view once more)"
                                                       : "") +
                                ", needed are " + std::to_string(params.min_views));
  }
  if (4 * wrong > count) {
    reasons->refusing.push_back(
        "wrong pairs: in " + std::to_string(wrong) + " of " + std::to_string(count) +
        " views picture and robot pose do not belong together; check the frames of the robot poses "
        "(base and flange, and which way round), the mounting, and that the board is fixed");
  }
  if (!findings.turns.empty()) reasons->refusing.push_back(findings.turns);
}

void judgeSquare(const HandEyeProblem& problem, const HandEyeParams& params,
                 const HandEyeResult& result, Reasons* reasons) {
  if (!(result.square_ratio > 0.0)) return;
  const double off = std::abs(std::log(result.square_ratio));
  const double sigma = result.square_ratio_sigma / result.square_ratio;
  if (off < 4.0 * sigma || off < 0.25 * params.scale_tolerance) return;
  const double stated_mm = 1e3 * problem.board.square;
  const std::string text =
      "square size wrong: " + millimetres(stated_mm) + " is stated, but the robot's moves say " +
      millimetres(stated_mm * result.square_ratio) + " +- " +
      millimetres(stated_mm * result.square_ratio_sigma) + "; measure it over many squares";
  (off > params.scale_tolerance ? reasons->refusing : reasons->limiting).push_back(text);
}

void judgeRobot(const HandEyeParams& params, const HandEyeResult& result, Reasons* reasons) {
  const std::string noise = millimetres(result.robot_mm) + " and " + degrees(result.robot_deg) +
                            " per axis (chain " + number(result.chain_px, 3) + " px, corners " +
                            number(result.pnp_floor_px, 3) + " px)";
  if (result.robot_mm > params.robot_refused_mm || result.robot_deg > params.robot_refused_deg) {
    reasons->refusing.push_back("robot noise too large: poses and pictures disagree by " + noise +
                                "; check the robot's own calibration, its tool frame, and that "
                                "board and camera sit firmly");
  } else if (result.robot_mm > params.robot_poor_mm || result.robot_deg > params.robot_poor_deg) {
    reasons->limiting.push_back("robot and pictures disagree by " + noise);
  }
}

void judgeCamera(const HandEyeResult& result, Reasons* reasons) {
  constexpr double kMuchBetter = 0.8;
  if (!(result.own_camera_px > 0.0 && result.own_camera_px < kMuchBetter * result.rms_px)) return;
  reasons->limiting.push_back(
      "the given camera does not fit the pictures: residual " + number(result.rms_px, 3) +
      " px, with one estimated from them about " + number(result.own_camera_px, 2) +
      " px; let the calibration estimate it");
}

void judgeError(const HandEyeParams& params, const HandEyeResult& result, Reasons* reasons) {
  if (result.expected_error_mm > params.tolerance_mm ||
      result.expected_error_deg > params.tolerance_deg) {
    reasons->limiting.push_back("expected error " + millimetres(result.expected_error_mm) +
                                " and " + degrees(result.expected_error_deg) + " at " +
                                number(result.working_distance, 3) + " m, allowed are " +
                                millimetres(params.tolerance_mm) + " and " +
                                degrees(params.tolerance_deg) +
                                "; take more views, nearer ones, more "
                                "tilted ones");
  }
  const LeaveOneOutLimits limits = leaveOneOutLimits(params, result);
  const bool refused = result.leave_one_out_mm > limits.refused;
  if (refused || result.leave_one_out_mm > limits.poor) {
    (refused ? reasons->refusing : reasons->limiting)
        .push_back("one view alone moves the camera by " + millimetres(result.leave_one_out_mm) +
                   " (" + result.leave_one_out_view + "; the stated sigma is " +
                   millimetres(limits.sigma) + "); take more views, or leave this one out");
  }
}

/// The other mounting and inverted poses together cancel out in all pictures: only the lengths
/// differ. "" where these are as usual: what is on the flange is near it.
std::string doubtOfMounting(const HandEyeResult& result) {
  const bool in_hand = result.transform_name == "T_flange_camera";
  const double camera = result.T_mount_camera.translation().norm();
  const double board = result.T_other_board.translation().norm();
  constexpr double kFarther = 3.0;
  if (in_hand ? camera < kFarther * board : board < kFarther * camera) return "";
  return std::string("the camera is ") + number(camera, 3) + " m from the " +
         (in_hand ? "flange" : "base") + " and the board " + number(board, 3) + " m from the " +
         (in_hand ? "base" : "flange") +
         ": check the mounting and which way round the robot poses are; with both the other way "
         "the pictures fit as well";
}

/// What else a user has to know.
void addNotes(const HandEyeParams& params, HandEyeResult* result) {
  std::vector<std::string>& notes = result->notes;
  notes.clear();
  if (!result->solved) return;
  if (params.four_axis) {
    notes.push_back(
        "4-axis robot: the height is not from the pictures; it holds as well as board_z, " +
        number(params.board_z, 5) + " m +- " + millimetres(params.board_z_sigma_mm));
  }
  const std::string doubt = doubtOfMounting(*result);
  if (!doubt.empty()) notes.push_back(doubt);
  // The pictures fit the corrected poses only.
  constexpr double kLarge = 3.0;
  if (result->verdict == Verdict::kGood && result->chain_px > kLarge * result->rms_px) {
    notes.push_back(
        "the residual of the chain, " + number(result->chain_px, 3) +
        " px, is the robot's: its poses are off by " + millimetres(result->robot_mm) + " and " +
        degrees(result->robot_deg) + " per axis; the calibration averages that out (residual " +
        number(result->rms_px, 3) + " px with corrected poses), but each move has it again");
  }
  for (const LensTrial& trial : result->lens_trials) {
    if (trial.is_chosen && trial.coefficients != 5) {
      notes.push_back("lens of " + std::to_string(trial.coefficients) +
                      " coefficients: held-out pictures are off by " +
                      number(trial.held_out_px, 3) + " px, with another model by " +
                      number(result->lens_trials.front().held_out_px, 3) +
                      " px, or that one folds the image over");
    }
  }
}

}  // namespace

ErrorModel::ErrorModel(const Chain& chain, int width, int height, double distance)
    : ErrorModel(chain, width, height, distance,
                 {{0.5, 0.5}, {0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}}) {}

ErrorModel::ErrorModel(const Chain& chain, int width, int height, double distance,
                       const std::vector<Eigen::Vector2d>& places) {
  const Camera camera(toModel(chain.intrinsics, width, height));
  for (const Eigen::Vector2d& place : places) {
    const Eigen::Vector2d p_ideal = camera.undistort({place.x() * width, place.y() * height});
    Eigen::Isometry3d T_camera_part = Eigen::Isometry3d::Identity();
    T_camera_part.translation() = distance * Eigen::Vector3d(p_ideal.x(), p_ideal.y(), 1.0);
    by_calibration_.push_back(partByCalibration(chain, T_camera_part));
  }
}

ExpectedError ErrorModel::of(const Eigen::MatrixXd& covariance) const {
  double square_t = 0.0, square_r = 0.0;
  for (const auto& L : by_calibration_) {
    const Matrix6d of_part = L * covariance.topLeftCorner<kBoard, kBoard>() * L.transpose();
    square_t += of_part.topLeftCorner<3, 3>().trace();
    square_r += of_part.bottomRightCorner<3, 3>().trace();
  }
  const auto count = static_cast<double>(by_calibration_.size());
  return {std::sqrt(square_t / count), std::sqrt(square_r / count)};
}

LeaveOneOutLimits leaveOneOutLimits(const HandEyeParams& params, const HandEyeResult& result) {
  const double sigma = 1e3 * std::sqrt(result.covariance.block<3, 3>(kHandEye, kHandEye).trace());
  // Beyond ten sigmas nothing that is stated holds.
  return {sigma, std::max(3.0 * sigma, 0.5 * params.tolerance_mm),
          std::max(10.0 * sigma, params.tolerance_mm)};
}

void judge(const HandEyeProblem& problem, const HandEyeParams& params, const Findings& findings,
           HandEyeResult* result) {
  Reasons reasons;
  judgeViews(problem, params, findings, *result, &reasons);
  if (result->solved) {
    judgeSquare(problem, params, *result, &reasons);
    judgeRobot(params, *result, &reasons);
    judgeCamera(*result, &reasons);
    judgeError(params, *result, &reasons);
  }
  if (!findings.camera_error.empty()) reasons.refusing.push_back(findings.camera_error);
  if (!result->solved && reasons.refusing.empty()) {
    reasons.refusing.push_back(
        "no solution: robot poses and pictures leave it open; take more views, tilted about "
        "different axes");
  }
  // What explains all the rest stands alone.
  if (!findings.mistake.empty()) reasons = {{findings.mistake}, {}};
  result->verdict = !reasons.refusing.empty()   ? Verdict::kRefused
                    : !reasons.limiting.empty() ? Verdict::kPoor
                                                : Verdict::kGood;
  result->reasons = reasons.refusing;
  result->reasons.insert(result->reasons.end(), reasons.limiting.begin(), reasons.limiting.end());
  addNotes(params, result);
}

}  // namespace planar_bin_picking
