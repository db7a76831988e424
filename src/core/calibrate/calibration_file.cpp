// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_file.h"

#include "base/atomic_file.h"
#include "base/yaml_file.h"
#include "base/yaml_text.h"
#include "calibrate/calibration_report.h"
#include "calibrate/fixed_link.h"
#include "planar_bin_picking/base/se3.h"
#include "planar_bin_picking/calibrate/board/board_file.h"

#include <cmath>
#include <ctime>
#include <filesystem>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

using Values = std::vector<double>;

bool isRational(const Camera::Model& camera) {
  return camera.distortion_model == "rational_polynomial";
}

Values distortionOf(const Camera::Model& camera) {
  Values d = camera.distortion;
  d.resize(isRational(camera) ? 8 : 5, 0.0);
  return d;
}

/// What all files of a calibration say of it.
struct Made {
  CalibrationNames names;
  std::string date;
};

void put(YAML::Emitter& out, const std::string& key, const std::string& value) {
  out << YAML::Key << key << YAML::Value << value;
}

void put(YAML::Emitter& out, const std::string& key, const char* value) {
  put(out, key, std::string(value));
}

void put(YAML::Emitter& out, const std::string& key, bool value) {
  out << YAML::Key << key << YAML::Value << value;
}

/// As text: the emitter's own conversion follows the process's locale.
template <class Number>
void put(YAML::Emitter& out, const std::string& key, const Number& value) {
  put(out, key, yamlNumber(static_cast<double>(value)));
}

void putList(YAML::Emitter& out, const std::string& key, const Values& values) {
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double value : values) out << yamlNumber(value);
  out << YAML::EndSeq;
}

/// Of the map that is open.
void putPose(YAML::Emitter& out, const Eigen::Isometry3d& T) {
  const Eigen::Vector3d p = T.translation();
  const Eigen::Quaterniond q = quaternionOf(T.linear());
  putList(out, "position", {p.x(), p.y(), p.z()});
  putList(out, "orientation", {q.x(), q.y(), q.z(), q.w()});
}

void putMatrix(YAML::Emitter& out, const std::string& key, int rows, const Values& values) {
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
  put(out, "rows", rows);
  put(out, "cols", static_cast<int>(values.size()) / rows);
  putList(out, "data", values);
  out << YAML::EndMap;
}

/// Where the board is: on the table, or on the flange.
void putBoard(YAML::Emitter& out, const HandEyeResult& result) {
  const bool in_hand = result.transform_name == "T_flange_camera";
  out << YAML::Key << "board_transform" << YAML::Value << YAML::BeginMap;
  put(out, "name", in_hand ? "T_base_board" : "T_flange_board");
  putPose(out, result.T_other_board);
  out << YAML::EndMap;
}

/// Row by row: translation, then rotation, about the camera's own axes; metres and radians.
void putCovariance(YAML::Emitter& out, const HandEyeResult& result) {
  const Matrix6d covariance = result.covariance.block<6, 6>(kHandEye, kHandEye);
  Values values;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) values.push_back(covariance(i, k));
  }
  putList(out, "covariance", values);
}

void putNumbers(YAML::Emitter& out, const HandEyeResult& result) {
  out << YAML::Key << "transform" << YAML::Value << YAML::BeginMap;
  put(out, "name", result.transform_name);
  putPose(out, result.T_mount_camera);
  out << YAML::EndMap;
  const Camera::Model& c = result.camera;
  putList(out, "camera_matrix", {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0});
  putList(out, "distortion", distortionOf(c));
  put(out, "rms_px", result.rms_px);
  put(out, "chain_px", result.chain_px);
  if (result.held_out_px > 0.0) put(out, "held_out_px", result.held_out_px);
  put(out, "pnp_floor_px", result.pnp_floor_px);
  if (result.own_camera_px > 0.0) put(out, "own_camera_px", result.own_camera_px);
  put(out, "sigma_px", result.sigma_px);
  put(out, "robot_mm", result.robot_mm);
  put(out, "robot_deg", result.robot_deg);
  put(out, "working_distance", result.working_distance);
  put(out, "expected_error_mm", result.expected_error_mm);
  put(out, "expected_error_deg", result.expected_error_deg);
  put(out, "with_robot_mm", result.with_robot_mm);
  put(out, "with_robot_deg", result.with_robot_deg);
  put(out, "leave_one_out_mm", result.leave_one_out_mm);
  put(out, "leave_one_out_deg", result.leave_one_out_deg);
  if (!result.leave_one_out_view.empty()) put(out, "leave_one_out_view", result.leave_one_out_view);
  Values sigmas;
  for (Eigen::Index i = 0; i < kBoard; ++i) sigmas.push_back(std::sqrt(result.covariance(i, i)));
  // As many as the camera has numbers.
  putList(out, "sigma_camera", {sigmas.begin(), sigmas.begin() + 4 + (isRational(c) ? 8 : 5)});
  putList(out, "sigma_transform", {sigmas.begin() + kHandEye, sigmas.end()});
  putCovariance(out, result);
  putBoard(out, result);
}

void putViews(YAML::Emitter& out, const HandEyeProblem& problem, const HandEyeResult& result) {
  out << YAML::Key << "views" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const ViewResult& view = result.views[i];
    out << YAML::Flow << YAML::BeginMap;
    put(out, "name", problem.observations[i].name);
    put(out, "used", view.used);
    if (view.used) {
      put(out, "corners", static_cast<int>(problem.observations[i].corners.size()));
      put(out, "rms_px", view.rms_px);
      put(out, "rms_mm", view.rms_mm);
      put(out, "robot_off_mm", 1e3 * view.correction.head<3>().norm());
    } else {
      put(out, "why_not", view.why_not);
    }
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

void putNotes(YAML::Emitter& out, const HandEyeResult& result) {
  if (result.notes.empty()) return;
  out << YAML::Key << "notes" << YAML::Value << YAML::BeginSeq;
  for (const std::string& note : result.notes) out << note;
  out << YAML::EndSeq;
}

/// Which lens models were tried, and how far they are off on pictures that they were not made from.
void putLensTrials(YAML::Emitter& out, const HandEyeResult& result) {
  if (result.lens_trials.empty()) return;
  out << YAML::Key << "lens_trials" << YAML::Value << YAML::BeginSeq;
  for (const LensTrial& trial : result.lens_trials) {
    out << YAML::Flow << YAML::BeginMap;
    put(out, "coefficients", trial.coefficients);
    put(out, "held_out_px", trial.held_out_px);
    put(out, "chosen", trial.is_chosen);
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

std::string calibrationYaml(const HandEyeProblem& problem, const HandEyeResult& result,
                            const Made& made) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "verdict", nameOf(result.verdict));
  put(out, "date", made.date);
  put(out, "camera_name", made.names.camera_name);
  putList(out, "image_size", {1.0 * problem.width, 1.0 * problem.height});
  put(out, "board", std::to_string(problem.board.cols) + "x" + std::to_string(problem.board.rows));
  put(out, "square", problem.board.square);
  put(out, "board_kind", nameOf(problem.board.kind));
  out << YAML::Key << "reasons" << YAML::Value << YAML::BeginSeq;
  for (const std::string& reason : result.reasons) out << reason;
  out << YAML::EndSeq;
  putNotes(out, result);
  putLensTrials(out, result);
  put(out, "views_used", result.views_used);
  put(out, "axes_deg", result.axes_deg);
  if (result.square_ratio > 0.0) {
    put(out, "square_ratio", result.square_ratio);
    put(out, "square_ratio_sigma", result.square_ratio_sigma);
  }
  if (result.solved) putNumbers(out, result);
  putViews(out, problem, result);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

/// What a file was made of, as one line for people.
std::string madeOf(const HandEyeResult& result, const Made& made) {
  std::string camera = made.names.camera_name;
  for (char& c : camera) c = c == '\n' || c == '\r' ? ' ' : c;
  std::string text =
      "camera '" + camera + "', calibrated " + made.date + ": " + nameOf(result.verdict);
  if (!result.solved) return text;
  return text + ", expected error " + yamlNumber(result.expected_error_mm, 3) + " mm and " +
         yamlNumber(result.expected_error_deg, 3) + " deg";
}

std::string cameraInfoYaml(const HandEyeResult& result, const Made& made) {
  const Camera::Model& c = result.camera;
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "image_width", c.width);
  put(out, "image_height", c.height);
  put(out, "camera_name", made.names.camera_name);
  putMatrix(out, "camera_matrix", 3, {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0});
  put(out, "distortion_model", isRational(c) ? "rational_polynomial" : "plumb_bob");
  putMatrix(out, "distortion_coefficients", 1, distortionOf(c));
  putMatrix(out, "rectification_matrix", 3, {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
  putMatrix(out, "projection_matrix", 3,
            {c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0});
  out << YAML::EndMap;
  // As a comment: the keys are those of ROS.
  return "# " + madeOf(result, made) + "\n" + out.c_str() + "\n";
}

std::string handEyeYaml(const HandEyeResult& result, const Made& made) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "parent_frame", made.names.mount_frame);
  put(out, "child_frame", made.names.camera_frame);
  putPose(out, result.T_mount_camera);
  put(out, "expected_error_mm", result.expected_error_mm);
  put(out, "expected_error_deg", result.expected_error_deg);
  put(out, "verdict", nameOf(result.verdict));
  put(out, "date", made.date);
  put(out, "camera_name", made.names.camera_name);
  putCovariance(out, result);
  putBoard(out, result);
  putNotes(out, result);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::string now() {
  const std::time_t seconds = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// Whether a GOOD calibration stands in the folder. One that cannot be read is none.
bool isGood(const std::string& folder) {
  try {
    return loadHandEye(folder + "/hand_eye.yaml").verdict == nameOf(Verdict::kGood);
  } catch (const std::runtime_error&) {
    return false;
  }
}

/// Beside a refusal no older calibration may look valid.
void putAside(const std::string& at) {
  for (const char* name :
       {"hand_eye.yaml", "camera_info.yaml", "hand_eye.xacro", "static_transform.launch"}) {
    const std::string path = at + name;
    std::error_code error;
    if (!std::filesystem::exists(path, error)) continue;
    std::filesystem::rename(path, path + ".before", error);
    if (!error) continue;
    throw std::runtime_error(path + ": is of an older calibration and cannot be renamed: " +
                             error.message() + "; move it away, the new calibration is REFUSED");
  }
}

}  // namespace

void checkCalibrationFolder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw std::runtime_error(folder + ": this folder for the calibration cannot be made: " +
                             (error ? error.message() : "something else is there"));
  }
  checkWritable(folder);
}

std::string saveCalibration(const std::string& folder, const HandEyeProblem& problem,
                            const HandEyeResult& result, const CalibrationNames& names,
                            const SaveOptions& options) {
  const Made made{names, options.date.empty() ? now() : options.date};
  const bool aside = result.verdict == Verdict::kPoor && !options.replace_good && isGood(folder);
  const std::string target = aside ? folder + "/poor" : folder, at = target + "/";
  checkCalibrationFolder(target);
  std::vector<NamedContent> files{
      {at + "report.html",
       calibrationReport(problem, result, madeOf(result, made), options.pictures)}};
  const bool refused = result.verdict == Verdict::kRefused;
  if (!refused) {
    const FixedLink link{names.mount_frame, names.camera_frame, result.T_mount_camera,
                         madeOf(result, made)};
    files.push_back({at + "camera_info.yaml", cameraInfoYaml(result, made)});
    files.push_back({at + "hand_eye.yaml", handEyeYaml(result, made)});
    files.push_back({at + "hand_eye.xacro", handEyeXacro(link)});
    files.push_back({at + "static_transform.launch", staticTransformLaunch(link)});
  }
  // Last: where it stands, all others do.
  files.push_back({at + "calibration.yaml", calibrationYaml(problem, result, made)});
  writeTogether(files);
  if (refused) putAside(at);
  return target;
}

HandEyeFile loadHandEye(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path,
                    {"parent_frame", "child_frame", "position", "orientation", "expected_error_mm",
                     "expected_error_deg", "verdict", "date", "camera_name", "covariance",
                     "board_transform", "notes"});
  HandEyeFile out;
  out.parent_frame = valueAs<std::string>(root["parent_frame"], path, "parent_frame", "a frame");
  out.child_frame = valueAs<std::string>(root["child_frame"], path, "child_frame", "a frame");
  const auto text = [&](const char* key) {
    return root[key] ? valueAs<std::string>(root[key], path, key, "a text") : std::string();
  };
  out.date = text("date");
  out.verdict = text("verdict");
  out.camera_name = text("camera_name");
  const auto number = [&](const char* key) {
    return root[key] ? valueAs<double>(root[key], path, key, "a number") : 0.0;
  };
  out.expected_error_mm = number("expected_error_mm");
  out.expected_error_deg = number("expected_error_deg");
  out.T_parent_child = poseIn(root, path);
  return out;
}

}  // namespace planar_bin_picking
