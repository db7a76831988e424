// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/params.h"

#include "base/yaml_file.h"

#include <map>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

template <class T>
std::string toText(const T& value) {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::boolalpha << value;
  return text.str();
}

template <class T>
std::string expectedType() {
  if (std::is_same<T, bool>::value) return "true or false";
  return std::is_integral<T>::value ? "a whole number" : "a number";
}

/// Collects the values of nested maps under keys such as "hough/yaw_step_deg".
void flattenMap(const YAML::Node& map, const std::string& prefix, const std::string& path,
                std::map<std::string, YAML::Node>* values) {
  refuseRepeatedKeys(map, path);
  for (const auto& entry : map) {
    const std::string key = prefix + valueAs<std::string>(entry.first, path, "a key", "a word");
    if (entry.second.IsMap()) {
      flattenMap(entry.second, key + "/", path, values);
    } else {
      values->emplace(key, entry.second);
    }
  }
}

}  // namespace

void validate(const LocatorParams& params) {
  forEachField(params, [](const std::string& key, const auto& value, auto min, auto max) {
    // Written so that NaN fails too.
    if (value >= min && value <= max) return;
    throw std::invalid_argument(key + " is " + toText(value) + ", must be between " + toText(min) +
                                " and " + toText(max));
  });
}

LocatorParams loadLocatorParams(const std::string& path) {
  // Not a vector: assigning one YAML::Node to another, as erase would, writes into the tree itself.
  std::map<std::string, YAML::Node> values;
  flattenMap(loadYamlMap(path), "", path, &values);
  LocatorParams params;
  std::string known;
  forEachField(params, [&](const std::string& key, auto& member, auto, auto) {
    // A stage whose lines are all commented out.
    const auto stage = values.find(key.substr(0, key.find('/')));
    if (stage != values.end() && stage->first != key && stage->second.IsNull()) values.erase(stage);
    known += (known.empty() ? "" : ", ") + key;
    const auto it = values.find(key);
    if (it == values.end()) return;
    using Value = std::decay_t<decltype(member)>;
    member = valueAs<Value>(it->second, path, key, expectedType<Value>());
    values.erase(it);
  });
  if (!values.empty()) {
    throw std::runtime_error(path + ": unknown key \"" + values.begin()->first + "\"; known are " +
                             known);
  }
  try {
    validate(params);
  } catch (const std::invalid_argument& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
  return params;
}

}  // namespace planar_bin_picking
