// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_file.h"

#include "base/atomic_file.h"
#include "base/yaml_file.h"

#include <cmath>
#include <filesystem>
#include <iomanip>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

using Values = std::vector<double>;

Values positionOf(const Eigen::Isometry3d& T) {
  const Eigen::Vector3d p = T.translation();
  return {p.x(), p.y(), p.z()};
}

/// x y z w, w not negative.
Values orientationOf(const Eigen::Isometry3d& T) {
  Eigen::Quaterniond q(T.linear());
  q.normalize();
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  return {q.x(), q.y(), q.z(), q.w()};
}

bool isRational(const Camera::Model& camera) {
  return camera.distortion_model == "rational_polynomial";
}

Values distortionOf(const Camera::Model& camera) {
  Values d = camera.distortion;
  d.resize(isRational(camera) ? 8 : 5, 0.0);
  return d;
}

/// As text: the emitter's own conversion follows the process's locale, and where that has decimal
/// commas or groups digits nobody could read the file.
template <class Number>
std::string numberText(const Number value) {
  if (std::isnan(static_cast<double>(value))) return ".nan";
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::setprecision(10) << value;
  return out.str();
}

void put(YAML::Emitter& out, const std::string& key, const std::string& value) {
  out << YAML::Key << key << YAML::Value << value;
}

void put(YAML::Emitter& out, const std::string& key, const char* value) {
  put(out, key, std::string(value));
}

void put(YAML::Emitter& out, const std::string& key, bool value) {
  out << YAML::Key << key << YAML::Value << value;
}

template <class Number>
void put(YAML::Emitter& out, const std::string& key, const Number& value) {
  put(out, key, numberText(value));
}

void putList(YAML::Emitter& out, const std::string& key, const Values& values) {
  out << YAML::Key << key << YAML::Value << YAML::Flow << YAML::BeginSeq;
  for (const double value : values) out << numberText(value);
  out << YAML::EndSeq;
}

void putMatrix(YAML::Emitter& out, const std::string& key, int rows, const Values& values) {
  out << YAML::Key << key << YAML::Value << YAML::BeginMap;
  put(out, "rows", rows);
  put(out, "cols", static_cast<int>(values.size()) / rows);
  putList(out, "data", values);
  out << YAML::EndMap;
}

void putNumbers(YAML::Emitter& out, const HandEyeResult& result) {
  out << YAML::Key << "transform" << YAML::Value << YAML::BeginMap;
  put(out, "name", result.transform_name);
  putList(out, "position", positionOf(result.T_mount_camera));
  putList(out, "orientation", orientationOf(result.T_mount_camera));
  out << YAML::EndMap;
  const Camera::Model& c = result.camera;
  putList(out, "camera_matrix", {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0});
  putList(out, "distortion", distortionOf(c));
  put(out, "rms_px", result.rms_px);
  put(out, "chain_px", result.chain_px);
  put(out, "pnp_floor_px", result.pnp_floor_px);
  if (result.own_camera_px > 0.0) put(out, "own_camera_px", result.own_camera_px);
  put(out, "sigma_px", result.sigma_px);
  put(out, "robot_mm", result.robot_mm);
  put(out, "robot_deg", result.robot_deg);
  put(out, "working_distance", result.working_distance);
  put(out, "expected_error_mm", result.expected_error_mm);
  put(out, "expected_error_deg", result.expected_error_deg);
  put(out, "leave_one_out_mm", result.leave_one_out_mm);
  put(out, "leave_one_out_deg", result.leave_one_out_deg);
  Values sigmas;
  for (Eigen::Index i = 0; i < kBoard; ++i) sigmas.push_back(std::sqrt(result.covariance(i, i)));
  putList(out, "sigma_camera", {sigmas.begin(), sigmas.begin() + kHandEye});
  putList(out, "sigma_transform", {sigmas.begin() + kHandEye, sigmas.end()});
}

void putViews(YAML::Emitter& out, const HandEyeProblem& problem, const HandEyeResult& result) {
  out << YAML::Key << "views" << YAML::Value << YAML::BeginSeq;
  for (std::size_t i = 0; i < result.views.size(); ++i) {
    const ViewResult& view = result.views[i];
    out << YAML::Flow << YAML::BeginMap;
    put(out, "name", problem.observations[i].name);
    put(out, "used", view.used);
    if (view.used) {
      put(out, "rms_px", view.rms_px);
      put(out, "robot_off_mm", 1e3 * view.correction.head<3>().norm());
    } else {
      put(out, "why_not", view.why_not);
    }
    out << YAML::EndMap;
  }
  out << YAML::EndSeq;
}

std::string calibrationYaml(const HandEyeProblem& problem, const HandEyeResult& result) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "verdict", nameOf(result.verdict));
  out << YAML::Key << "reasons" << YAML::Value << YAML::BeginSeq;
  for (const std::string& reason : result.reasons) out << reason;
  out << YAML::EndSeq;
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

std::string cameraInfoYaml(const Camera::Model& c, const std::string& name) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "image_width", c.width);
  put(out, "image_height", c.height);
  put(out, "camera_name", name);
  putMatrix(out, "camera_matrix", 3, {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0});
  put(out, "distortion_model", isRational(c) ? "rational_polynomial" : "plumb_bob");
  putMatrix(out, "distortion_coefficients", 1, distortionOf(c));
  putMatrix(out, "rectification_matrix", 3, {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0});
  putMatrix(out, "projection_matrix", 3,
            {c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0});
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

std::string handEyeYaml(const HandEyeResult& result, const CalibrationNames& names) {
  YAML::Emitter out;
  out << YAML::BeginMap;
  put(out, "parent_frame", names.mount_frame);
  put(out, "child_frame", names.camera_frame);
  putList(out, "position", positionOf(result.T_mount_camera));
  putList(out, "orientation", orientationOf(result.T_mount_camera));
  put(out, "expected_error_mm", result.expected_error_mm);
  put(out, "expected_error_deg", result.expected_error_deg);
  out << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

Values numbers(const YAML::Node& root, const std::string& path, const std::string& key,
               std::size_t count) {
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const Values values = valueAs<Values>(root[key], path, key, expected);
  bool finite = values.size() == count;
  for (const double value : values) finite = finite && std::isfinite(value);
  if (!finite) throwBadValue(path, key, root[key], expected);
  return values;
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

void saveCalibration(const std::string& folder, const HandEyeProblem& problem,
                     const HandEyeResult& result, const CalibrationNames& names) {
  checkCalibrationFolder(folder);
  const std::string at = folder + "/";
  std::vector<NamedContent> files{{at + "report.html", calibrationReport(problem, result)}};
  if (result.verdict != Verdict::kRefused) {
    files.push_back({at + "camera_info.yaml", cameraInfoYaml(result.camera, names.camera_name)});
    files.push_back({at + "hand_eye.yaml", handEyeYaml(result, names)});
  }
  // Last: where it stands, all others do.
  files.push_back({at + "calibration.yaml", calibrationYaml(problem, result)});
  writeTogether(files);
}

HandEyeFile loadHandEye(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path,
                    {"parent_frame", "child_frame", "position", "orientation", "expected_error_mm",
                     "expected_error_deg"});
  HandEyeFile out;
  out.parent_frame = valueAs<std::string>(root["parent_frame"], path, "parent_frame", "a frame");
  out.child_frame = valueAs<std::string>(root["child_frame"], path, "child_frame", "a frame");
  const Values p = numbers(root, path, "position", 3), o = numbers(root, path, "orientation", 4);
  const Eigen::Quaterniond q(o[3], o[0], o[1], o[2]);
  if (std::abs(q.norm() - 1.0) > 1e-3) {
    throwBadValue(path, "orientation", root["orientation"], "a quaternion x y z w of length 1");
  }
  out.T_parent_child = rigid(q.normalized().toRotationMatrix(), {p[0], p[1], p[2]});
  return out;
}

}  // namespace planar_bin_picking
