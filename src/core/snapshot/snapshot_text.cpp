// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "snapshot/snapshot_text.h"

#include "base/yaml_file.h"
#include "base/yaml_text.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <locale>
#include <sstream>
#include <type_traits>

namespace planar_bin_picking {
namespace {

std::string list(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + allDigits(value);
  return "[" + text + "]";
}

std::string list(const Eigen::Vector3d& v) {
  return list(std::vector<double>{v.x(), v.y(), v.z()});
}

std::string matrix(const std::string& key, int rows, int columns, const std::vector<double>& data) {
  return key + ":\n  rows: " + std::to_string(rows) + "\n  cols: " + std::to_string(columns) +
         "\n  data: " + list(data) + "\n";
}

const char* nameOf(FaceFilter face) {
  if (face == FaceFilter::kFront) return "front";
  return face == FaceFilter::kBack ? "back" : "any";
}

std::string line(const Detection& detection) {
  const Eigen::Matrix4d T = detection.T_camera_part.matrix();
  std::vector<double> values;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) values.push_back(T(row, column));
  return "{part: " + yamlText(detection.part_name) +
         ", face: " + (detection.face == Face::kFront ? "front" : "back") +
         ", score: " + allDigits(detection.score) +
         ", visible_fraction: " + allDigits(detection.visible_fraction) +
         ", T_camera_part: " + list(values) + "}";
}

Eigen::Vector3d triple(const YAML::Node& node, const std::string& path, const std::string& key) {
  const auto values = valueAs<std::vector<double>>(node, path, key, "three numbers");
  if (values.size() != 3) throwBadValue(path, key, node, "three numbers");
  return {values[0], values[1], values[2]};
}

}  // namespace

std::string allDigits(const double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << value;
  const std::string text = out.str();
  return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;
}

std::string cameraText(const Camera& camera) {
  const Camera::Model& model = camera.model();
  const std::vector<double> K{model.fx, 0, model.cx, 0, model.fy, model.cy, 0, 0, 1};
  const std::vector<double> P{model.fx, 0, model.cx, 0, 0, model.fy, model.cy, 0, 0, 0, 1, 0};
  return "image_width: " + std::to_string(model.width) +
         "\nimage_height: " + std::to_string(model.height) + "\ncamera_name: snapshot\n" +
         matrix("camera_matrix", 3, 3, K) +
         "distortion_model: " + yamlText(model.distortion_model) + "\n" +
         matrix("distortion_coefficients", 1, static_cast<int>(model.distortion.size()),
                model.distortion) +
         matrix("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1}) +
         matrix("projection_matrix", 3, 4, P);
}

std::string paramsText(const LocatorParams& params) {
  std::string text, stage;
  forEachField(params, [&](const std::string& key, const auto& member, auto, auto) {
    const std::size_t slash = key.find('/');
    const std::string of = slash == std::string::npos ? "" : key.substr(0, slash);
    if (!of.empty() && of != stage) text += of + ":\n";
    stage = of;
    text += (of.empty() ? key : "  " + key.substr(slash + 1)) + ": ";
    using Member = std::decay_t<decltype(member)>;
    if constexpr (std::is_same_v<Member, bool>) {
      text += member ? "true\n" : "false\n";
    } else if constexpr (std::is_integral_v<Member>) {
      text += std::to_string(member) + "\n";
    } else {
      text += allDigits(member) + "\n";
    }
  });
  return text;
}

std::string requestText(const LocateRequest& request, const std::string& version,
                        const std::vector<std::string>& parts) {
  std::string text = "version: " + yamlText(version) + "\nparts: " + yamlList(parts) +
                     "\nface: " + nameOf(request.face) +
                     "\nmax_parts: " + std::to_string(request.max_parts) +
                     "\ndistance_min: " + allDigits(request.distance_min) +
                     "\ndistance_max: " + allDigits(request.distance_max) + "\n";
  if (request.window) {
    const PixelBox& window = *request.window;
    text += "window: [" + std::to_string(window.left) + ", " + std::to_string(window.top) + ", " +
            std::to_string(window.width) + ", " + std::to_string(window.height) + "]\n";
  }
  if (request.plane) {
    text += "plane_normal: " + list(request.plane->normal_camera) +
            "\nplane_distance: " + allDigits(request.plane->distance) + "\n";
  }
  if (request.floor_normal) text += "floor_normal: " + list(*request.floor_normal) + "\n";
  return text;
}

RequestFile readRequestFile(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path,
                    {"version", "parts", "face", "max_parts", "distance_min", "distance_max",
                     "window", "plane_normal", "plane_distance", "floor_normal"});
  RequestFile file;
  file.version = valueAs<std::string>(root["version"], path, "version", "a version");
  file.parts = valueAs<std::vector<std::string>>(root["parts"], path, "parts", "a list of files");
  const auto face = valueAs<std::string>(root["face"], path, "face", "any, front or back");
  if (face != "any" && face != "front" && face != "back")
    throwBadValue(path, "face", root["face"], "any, front or back");
  file.request.face = face == "any"     ? FaceFilter::kAny
                      : face == "front" ? FaceFilter::kFront
                                        : FaceFilter::kBack;
  const int most = valueAs<int>(root["max_parts"], path, "max_parts", "a whole number, 0 for all");
  if (most < 0) throwBadValue(path, "max_parts", root["max_parts"], "a whole number, 0 for all");
  file.request.max_parts = static_cast<std::size_t>(most);
  file.request.distance_min = valueAs<double>(root["distance_min"], path, "distance_min", "metres");
  file.request.distance_max = valueAs<double>(root["distance_max"], path, "distance_max", "metres");
  if (root["window"]) {
    const auto box = valueAs<std::vector<int>>(root["window"], path, "window", "four numbers");
    constexpr int kMost = 100000;  // pixels; far more than any camera has
    const bool good = box.size() == 4 && std::all_of(box.begin(), box.end(), [](const int pixels) {
                        return pixels >= 0 && pixels <= kMost;
                      });
    if (!good) throwBadValue(path, "window", root["window"], "four numbers of pixels");
    file.request.window = PixelBox{box[0], box[1], box[2], box[3]};
  }
  if (root["plane_distance"]) {
    file.request.plane =
        Plane{triple(root["plane_normal"], path, "plane_normal"),
              valueAs<double>(root["plane_distance"], path, "plane_distance", "metres")};
  }
  if (root["floor_normal"]) {
    const Eigen::Vector3d normal = triple(root["floor_normal"], path, "floor_normal");
    constexpr double kOff = 1e-6;
    if (!(std::abs(normal.norm() - 1.0) <= kOff))
      throwBadValue(path, "floor_normal", root["floor_normal"], "a direction of length 1");
    file.request.floor_normal = normal;
  }
  return file;
}

std::string detectionsText(const LocateResult& result) {
  std::string text = "detections:";
  if (result.detections.empty()) text += " []";
  for (const Detection& detection : result.detections) text += "\n  - " + line(detection);
  text += "\nwithheld:";
  if (result.withheld.empty()) text += " []";
  for (const auto& withheld : result.withheld) text += "\n  - " + line(withheld.detection);
  return text + "\n";
}

}  // namespace planar_bin_picking
