// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/hand_eye_error.h"

#include "base/yaml_file.h"

#include <cmath>

namespace planar_bin_picking {
namespace {

double positive(const YAML::Node& root, const std::string& path, const std::string& key) {
  const std::string expected = "a number, at least 0, as the calibrator writes it";
  const auto value = valueAs<double>(root[key], path, key, expected);
  if (!(std::isfinite(value) && value >= 0.0)) throwBadValue(path, key, root[key], expected);
  return value;
}

}  // namespace

HandEyeError loadHandEyeError(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  const double per_axis = 1.0 / std::sqrt(3.0);
  return {1e-3 * per_axis * positive(root, path, "expected_error_mm"),
          per_axis * positive(root, path, "expected_error_deg")};
}

}  // namespace planar_bin_picking
