// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Reading YAML so that every complaint names the file, the key and what was expected there.

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace planar_bin_picking {

/// @throws std::runtime_error  file unreadable, not YAML, or not a map at its top
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

/// @param expected  completes "... must be <expected>"
template <class T>
T valueAs(const YAML::Node& node, const std::string& where, const std::string& key,
          const std::string& expected) {
  try {
    if (node.IsDefined() && !node.IsNull()) return node.as<T>();
  } catch (const YAML::Exception&) {
  }
  throwBadValue(where, key, node, expected);
}

}  // namespace planar_bin_picking
