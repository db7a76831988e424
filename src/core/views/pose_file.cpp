// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/pose_file.h"

#include "base/yaml_file.h"

namespace planar_bin_picking {

Eigen::Isometry3d loadPose(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path, {"position", "orientation"});
  return poseIn(root, path);
}

}  // namespace planar_bin_picking
