// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "yaml_file.h"

#include <algorithm>
#include <limits>
#include <locale>
#include <set>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

template <class T>
bool parse(const std::string& text, T* value) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  return in >> *value && in.eof();
}

}  // namespace

bool convert(const YAML::Node& node, double* value) {
  if (!node.IsScalar()) return false;
  const std::string& text = node.Scalar();
  if (parse(text, value)) return true;
  // YAML's words for what is not finite, which the caller refuses with a better message.
  if (text == ".nan" || text == ".inf" || text == "-.inf") {
    *value = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  return false;
}

bool convert(const YAML::Node& node, int* value) {
  return node.IsScalar() && parse(node.Scalar(), value);
}

bool convert(const YAML::Node& node, bool* value) {
  if (!node.IsScalar()) return false;
  *value = node.Scalar() == "true";
  return *value || node.Scalar() == "false";
}

bool convert(const YAML::Node& node, std::string* value) {
  if (!node.IsScalar()) return false;
  *value = node.Scalar();
  return true;
}

YAML::Node loadYamlMap(const std::string& path) {
  YAML::Node root;
  try {
    root = YAML::LoadFile(path);
  } catch (const YAML::BadFile&) {
    throw std::runtime_error(path + ": cannot be read; check the path and its permissions");
  } catch (const YAML::Exception& e) {
    throw std::runtime_error(path + ": is not valid YAML: " + e.what());
  }
  if (!root.IsMap()) throw std::runtime_error(path + ": has no \"key: value\" lines at its top");
  refuseRepeatedKeys(root, path);
  return root;
}

void refuseUnknownKeys(const YAML::Node& map, const std::string& where,
                       const std::vector<std::string>& known) {
  for (const auto& entry : map) {
    const auto key = valueAs<std::string>(entry.first, where, "a key", "a word");
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string list;
    for (const std::string& name : known) list += (list.empty() ? "" : ", ") + name;
    throw std::runtime_error(where + ": unknown key \"" + key + "\"; known are " + list);
  }
}

void refuseRepeatedKeys(const YAML::Node& map, const std::string& where) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar() || seen.insert(entry.first.Scalar()).second) continue;
    throw std::runtime_error(where + ": key \"" + entry.first.Scalar() +
                             "\" stands there twice; keep one");
  }
}

std::string inOneLine(const YAML::Node& node) {
  if (!node.IsDefined()) return "missing";
  if (node.IsNull()) return "empty";
  YAML::Emitter out;
  out << YAML::Flow << node;
  std::string text = out.c_str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() <= 80 ? text : text.substr(0, 77) + "...";
}

void throwBadValue(const std::string& where, const std::string& key, const YAML::Node& node,
                   const std::string& expected) {
  throw std::runtime_error(where + ": " + key + " is " + inOneLine(node) + ", must be " + expected);
}

}  // namespace planar_bin_picking
