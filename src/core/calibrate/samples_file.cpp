// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/samples_file.h"

#include "base/yaml_file.h"

#include <stdexcept>

namespace planar_bin_picking {
namespace {

Sample readSample(const YAML::Node& node, const std::string& where) {
  if (!node.IsMap()) throw std::runtime_error(where + ": is no {image, position, orientation}");
  refuseRepeatedKeys(node, where);
  refuseUnknownKeys(node, where, {"image", "position", "orientation"});
  Sample sample;
  sample.name = valueAs<std::string>(node["image"], where, "image", "the path of a picture");
  sample.T_base_flange = poseIn(node, where);
  return sample;
}

}  // namespace

std::vector<Sample> loadSamples(const std::string& path) {
  const YAML::Node root = loadYaml(path);
  if (!root.IsSequence() || root.size() == 0) {
    throw std::runtime_error(path + ": must be a list of {image, position, orientation}");
  }
  std::vector<Sample> samples;
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  for (std::size_t i = 0; i < root.size(); ++i) {
    samples.push_back(readSample(root[i], path + ": sample " + std::to_string(i + 1)));
    samples.back().image = folder / samples.back().name;
  }
  return samples;
}

}  // namespace planar_bin_picking
