// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// `samples.yaml`: pictures and robot poses on disk, as calibrate_samples takes them.

#include "planar_bin_picking/base/se3.h"

#include <filesystem>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct Sample {
  std::string name;
  std::filesystem::path image;
  Eigen::Isometry3d T_base_flange = Eigen::Isometry3d::Identity();
};

/// @throws std::runtime_error  naming file, sample, key and value
std::vector<Sample> loadSamples(const std::string& path);

}  // namespace planar_bin_picking
