// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/samples_file.h"

#include "base/yaml_file.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

std::vector<double> numbers(const YAML::Node& node, const std::string& where,
                            const std::string& key, std::size_t count) {
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const auto values = valueAs<std::vector<double>>(node, where, key, expected);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (values.size() != count || !finite) throwBadValue(where, key, node, expected);
  return values;
}

Sample readSample(const YAML::Node& node, const std::string& where) {
  if (!node.IsMap()) throw std::runtime_error(where + ": is no {image, position, orientation}");
  refuseRepeatedKeys(node, where);
  refuseUnknownKeys(node, where, {"image", "position", "orientation"});
  Sample sample;
  sample.name = valueAs<std::string>(node["image"], where, "image", "the path of a picture");
  const auto p = numbers(node["position"], where, "position", 3);
  const auto o = numbers(node["orientation"], where, "orientation", 4);
  const Eigen::Quaterniond q(o[3], o[0], o[1], o[2]);
  if (std::abs(q.norm() - 1.0) > 1e-3) {
    throwBadValue(where, "orientation", node["orientation"], "a quaternion x y z w of length 1");
  }
  sample.T_base_flange = rigid(q.normalized().toRotationMatrix(), {p[0], p[1], p[2]});
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
