// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "truth.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

namespace planar_bin_picking_ros {

Truth::Truth(const std::string& path) {
  const YAML::Node file = YAML::LoadFile(path);
  const auto vector = [](const YAML::Node& node) {
    return Eigen::Vector3d(node[0].as<double>(), node[1].as<double>(), node[2].as<double>());
  };
  center_ = vector(file["center"]);
  for (const YAML::Node& node : file["parts"]) {
    Instance instance;
    instance.part = node["part"].as<std::string>();
    instance.front = node["face"].as<std::string>() == "front";
    instance.visible = node["visible"].as<double>();
    const YAML::Node q = node["orientation"];
    const Eigen::Quaterniond rotation(q[3].as<double>(), q[0].as<double>(), q[1].as<double>(),
                                      q[2].as<double>());
    instance.T_camera_part = Eigen::Translation3d(vector(node["position"])) * rotation.normalized();
    instances_.push_back(instance);
  }
}

bool Truth::take(const std::string& part, const bool front, const Eigen::Isometry3d& T_camera_part,
                 const TruthTolerance& tolerance) {
  const auto lies_there = [&](const Instance& instance) {
    if (instance.taken || instance.part != part || instance.front != front) return false;
    const Eigen::Vector3d position = instance.T_camera_part * center_;
    const Eigen::Vector3d error = T_camera_part * center_ - position;
    const double depth = error.dot(position.normalized());  // along the line of sight
    const double lateral = std::sqrt(std::max(0.0, error.squaredNorm() - depth * depth));
    const Eigen::AngleAxisd turn(T_camera_part.linear() *
                                 instance.T_camera_part.linear().transpose());
    return lateral <= tolerance.lateral && std::abs(depth) <= tolerance.depth &&
           turn.angle() <= tolerance.angle;
  };
  const auto found = std::find_if(instances_.begin(), instances_.end(), lies_there);
  if (found == instances_.end()) return false;
  found->taken = true;
  return true;
}

int Truth::pickable() const {
  return static_cast<int>(std::count_if(instances_.begin(), instances_.end(),
                                        [](const Instance& i) { return i.pickable(); }));
}

int Truth::pickableTaken() const {
  return static_cast<int>(std::count_if(instances_.begin(), instances_.end(),
                                        [](const Instance& i) { return i.pickable() && i.taken; }));
}

}  // namespace planar_bin_picking_ros
