// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Reading YAML so that every complaint names the file, the key and what was expected there.

#include <yaml-cpp/yaml.h>
#include <Eigen/Geometry>

#include <cstddef>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// Whoever walks the tree that this returns, following aliases, comes to an end.
/// @throws std::runtime_error  no regular file, too large, unreadable, not YAML, nested too deep or
///         within itself, too many values (aliases written out)
YAML::Node loadYaml(const std::string& path);

/// The same of a text. @param path  where it stands, for messages
YAML::Node parseYaml(const std::string& text, const std::string& path);

/// @throws std::runtime_error  as loadYaml, or not a map at its top, or one of its keys twice
YAML::Node loadYamlMap(const std::string& path);

/// Refuses keys that nobody reads: most are typing errors.
/// @param where  "path" or "path: key" of the map, for the message
void refuseUnknownKeys(const YAML::Node& map, const std::string& where,
                       const std::vector<std::string>& known);

/// Refuses a key that is written twice, where the parser would keep one of them silently.
void refuseRepeatedKeys(const YAML::Node& map, const std::string& where);

/// The node in one line, as the user wrote it, shortened.
std::string inOneLine(const YAML::Node& node);

[[noreturn]] void throwBadValue(const std::string& where, const std::string& key,
                                const YAML::Node& node, const std::string& expected);

/// Whether the node holds such a value. The library's own conversion follows the process's locale:
/// where that has decimal commas it would not read 0.5.
bool convert(const YAML::Node& node, double* value);
bool convert(const YAML::Node& node, int* value);
bool convert(const YAML::Node& node, bool* value);
bool convert(const YAML::Node& node, std::string* value);

template <class T>
bool convert(const YAML::Node& node, std::vector<T>* values) {
  if (!node.IsSequence()) return false;
  values->resize(node.size());
  for (std::size_t i = 0; i < node.size(); ++i) {
    if (!convert(node[i], &(*values)[i])) return false;
  }
  return true;
}

/// @param expected  completes "... must be <expected>"
template <class T>
T valueAs(const YAML::Node& node, const std::string& where, const std::string& key,
          const std::string& expected) {
  T value{};
  if (!node.IsDefined() || !convert(node, &value)) throwBadValue(where, key, node, expected);
  return value;
}

/// Exactly `count` finite numbers.
std::vector<double> numbersAt(const YAML::Node& map, const std::string& where,
                              const std::string& key, std::size_t count);

/// The map's position: [x, y, z], metres, and orientation: [x, y, z, w], a unit quaternion.
Eigen::Isometry3d poseIn(const YAML::Node& map, const std::string& where);

}  // namespace planar_bin_picking
