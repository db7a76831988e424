// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/pose_file.h"

#include "base/yaml_file.h"
#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <cmath>

namespace planar_bin_picking {
namespace {

std::vector<double> numbers(const YAML::Node& root, const std::string& path, const std::string& key,
                            std::size_t count) {
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const auto values = valueAs<std::vector<double>>(root[key], path, key, expected);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (values.size() != count || !finite) throwBadValue(path, key, root[key], expected);
  return values;
}

}  // namespace

Eigen::Isometry3d loadPose(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path, {"position", "orientation"});
  const auto p = numbers(root, path, "position", 3);
  const auto o = numbers(root, path, "orientation", 4);
  const Eigen::Quaterniond q(o[3], o[0], o[1], o[2]);
  if (std::abs(q.norm() - 1.0) > 1e-3)
    throwBadValue(path, "orientation", root["orientation"], "a quaternion x y z w of length 1");
  return rigid(q.normalized().toRotationMatrix(), {p[0], p[1], p[2]});
}

}  // namespace planar_bin_picking
