// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part_file.h"

#include "yaml_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

std::string extensionOf(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; });
  return extension;
}

bool isYaml(const fs::path& path) {
  return extensionOf(path) == ".yaml" || extensionOf(path) == ".yml";
}

Eigen::Vector3d readTriple(const YAML::Node& node, const std::string& where,
                           const std::string& key) {
  const std::string expected = "three finite numbers: [0.0, 0.0, 0.0]";
  const auto values = valueAs<std::vector<double>>(node, where, key, expected);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
  if (values.size() != 3 || !finite) throwBadValue(where, key, node, expected);
  return {values[0], values[1], values[2]};
}

FaceFilter readFace(const YAML::Node& node, const std::string& where) {
  const std::string expected = "any, front or back";
  const auto word = valueAs<std::string>(node, where, "face", expected);
  if (word == "any") return FaceFilter::kAny;
  if (word == "front") return FaceFilter::kFront;
  if (word == "back") return FaceFilter::kBack;
  throwBadValue(where, "face", node, expected);
}

PickPose readPickPose(const YAML::Node& node, const std::string& where) {
  if (!node.IsMap())
    throw std::runtime_error(where + ": is " + inOneLine(node) + ", must be a map");
  refuseRepeatedKeys(node, where);
  refuseUnknownKeys(node, where, {"name", "position_mm", "rpy_deg", "face", "symmetric"});
  PickPose pick;
  pick.name = valueAs<std::string>(node["name"], where, "name", "a word");
  // A copy's number, and the pose's frame on tf, are set apart by these.
  if (pick.name.empty() || pick.name.find_first_of("@/ ") != std::string::npos)
    throwBadValue(where, "name", node["name"], "a word without @ and /");
  if (node["face"]) pick.face = readFace(node["face"], where);
  if (node["symmetric"])
    pick.symmetric = valueAs<bool>(node["symmetric"], where, "symmetric", "true or false");
  pick.T_part_pick.translation() = 1e-3 * readTriple(node["position_mm"], where, "position_mm");
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  if (node["rpy_deg"]) rpy = readTriple(node["rpy_deg"], where, "rpy_deg") * (EIGEN_PI / 180.0);
  // Fixed axes, as everywhere in ROS: first about x, then y, then z of the part.
  pick.T_part_pick.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
  return pick;
}

std::vector<PickPose> readPickPoses(const YAML::Node& list, const std::string& path) {
  if (!list.IsSequence()) throwBadValue(path, "pick_poses", list, "a list of poses");
  std::vector<PickPose> picks;
  std::set<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string where = path + ": pick_poses[" + std::to_string(i) + "]";
    picks.push_back(readPickPose(list[i], where));
    if (!names.insert(picks.back().name).second) {
      throw std::runtime_error(where + ": name \"" + picks.back().name + "\" stands there twice");
    }
  }
  return picks;
}

/// @return  metres; nothing where the key is not there
std::optional<double> readMillimetres(const YAML::Node& root, const std::string& key,
                                      const std::string& zero, const std::string& path) {
  constexpr double kMost = 1000.0;
  if (!root[key]) return std::nullopt;
  const std::string expected = "between 0 " + zero + " and 1000";
  const double value = valueAs<double>(root[key], path, key, expected);
  if (!(value >= 0.0 && value <= kMost)) throwBadValue(path, key, root[key], expected);
  return 1e-3 * value;
}

DrawingParams readDrawingParams(const YAML::Node& root, const std::string& path) {
  DrawingParams params;
  const auto read = [&](const char* key, std::vector<std::string>* patterns) {
    if (root[key])
      *patterns = valueAs<std::vector<std::string>>(root[key], path, key, "a list of layers");
  };
  // Who names the layers to keep means these, whatever the default list says.
  if (root["keep_layers"]) params.skip_layers.clear();
  read("keep_layers", &params.keep_layers);
  read("skip_layers", &params.skip_layers);
  read("print_layers", &params.print_layers);
  return params;
}

PartFile loadYamlPart(const fs::path& path) {
  const std::string name = path.string();
  const YAML::Node root = loadYamlMap(name);
  refuseUnknownKeys(root, name,
                    {"drawing", "thickness_mm", "keep_layers", "skip_layers", "print_layers",
                     "pick_poses", "tool_radius_mm", "tool_height_mm"});
  PartFile part;
  const auto drawing =
      valueAs<std::string>(root["drawing"], name, "drawing", "a DXF file beside this one");
  part.thickness = readMillimetres(root, "thickness_mm", "(unknown)", name).value_or(0.0);
  part.tool.radius = readMillimetres(root, "tool_radius_mm", "(not looked at)", name);
  part.tool.height = readMillimetres(root, "tool_height_mm", "(no end)", name);
  if (root["pick_poses"]) part.pick_poses = readPickPoses(root["pick_poses"], name);
  const DrawingParams params = readDrawingParams(root, name);
  const fs::path drawing_path = path.parent_path() / drawing;
  if (!fs::is_regular_file(drawing_path)) {
    throw std::runtime_error(name + ": drawing " + drawing_path.string() +
                             " does not exist; the path is relative to this file");
  }
  part.drawing = loadDrawing(drawing_path.string(), params);
  return part;
}

}  // namespace

PartFile loadPartFile(const std::string& path) {
  const fs::path given(path);
  if (!fs::is_regular_file(given))
    throw std::runtime_error(path + ": does not exist; give a part's .yaml or .dxf");
  if (!isYaml(given) && extensionOf(given) != ".dxf") {
    throw std::runtime_error(path + ": is no part; give a part's .yaml or .dxf");
  }
  PartFile part;
  const fs::path yaml = fs::path(given).replace_extension(".yaml");
  if (isYaml(given)) {
    part = loadYamlPart(given);
  } else if (fs::is_regular_file(yaml)) {
    part = loadYamlPart(yaml);
  } else {
    part.drawing = loadDrawing(path);
  }
  part.name = given.stem().string();
  return part;
}

}  // namespace planar_bin_picking
