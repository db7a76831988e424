// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/camera_file.h"

#include "base/yaml_file.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking {
namespace {

std::vector<double> readData(const YAML::Node& root, const std::string& path,
                             const std::string& key) {
  const bool written = root[key].IsDefined() && root[key].IsMap() && root[key]["data"].IsDefined();
  if (!written) throw std::runtime_error(path + ": " + key + "/data is missing");
  const YAML::Node data = root[key]["data"];
  return valueAs<std::vector<double>>(data, path, key + "/data", "a list of numbers");
}

}  // namespace

Camera loadCamera(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  if (root["K"] && !root["camera_matrix"]) {
    throw std::runtime_error(path +
                             ": is a printed CameraInfo message (key \"K\"); give the file "
                             "that the calibration wrote (key \"camera_matrix\")");
  }
  const int width = valueAs<int>(root["image_width"], path, "image_width", "a number of pixels");
  const int height = valueAs<int>(root["image_height"], path, "image_height", "a number of pixels");
  const std::vector<double> k = readData(root, path, "camera_matrix");
  std::array<double, 9> K{};
  if (k.size() != K.size()) {
    throwBadValue(path, "camera_matrix/data", root["camera_matrix"]["data"],
                  "[fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  }
  std::copy(k.begin(), k.end(), K.begin());
  Camera::Model model;
  try {
    model = pinholeModel(width, height, K);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(path + ": camera_matrix/data: " + e.what());
  }
  const YAML::Node distortion_model = root["distortion_model"];
  model.distortion_model = distortion_model.IsDefined() && distortion_model.IsNull()
                               ? ""
                               : valueAs<std::string>(distortion_model, path, "distortion_model",
                                                      "plumb_bob or rational_polynomial");
  model.distortion = readData(root, path, "distortion_coefficients");
  try {
    return Camera(model);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

}  // namespace planar_bin_picking
