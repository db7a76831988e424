// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/yaml_file.h"

#include "base/regular_file.h"
#include "planar_bin_picking/base/se3.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <set>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

// What no file of this package needs, and what would exhaust stack, memory or time.
constexpr std::size_t kBytesMost = 2u << 20;  // some 10,000 samples of a calibration
constexpr int kLevelsMost = 32;
constexpr int kColumnsMost = 2 * kLevelsMost;  // of indentation
constexpr std::size_t kNodesMost = 200000;     // with aliases written out

constexpr double kUnit = 1e-3;  // off the length 1 of a quaternion, by rounding to four digits

template <class T>
bool parse(const std::string& text, T* value) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  return in >> *value && in.eof();
}

std::string shortened(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.size() <= 80 ? text : text.substr(0, 77) + "...";
}

[[noreturn]] void refuseDepth(const std::string& path) {
  throw std::runtime_error(path + ": is nested deeper than " + std::to_string(kLevelsMost) +
                           " levels, or an alias in it (*name) stands within what it refers to");
}

/// How deep brackets open; what is quoted or a comment does not count. The library reads levels
/// recursively, some versions without a limit.
class BracketDepth {
 public:
  void read(char c, char before, char before_space) {
    if (quote_ != 0) {
      if (skip_) {
        skip_ = false;
      } else if (quote_ == '"' && c == '\\') {
        skip_ = true;
      } else if (c == quote_) {
        quote_ = 0;
      }
    } else if (comment_) {
      comment_ = c != '\n';
    } else if (c == '#' && (before == ' ' || before == '\t' || before == '\n')) {
      comment_ = true;
    } else if ((c == '"' || c == '\'') &&
               std::string("[{,:-?\n").find(before_space) != std::string::npos) {
      quote_ = c;
    } else if (c == '[' || c == '{') {
      deepest_ = std::max(deepest_, ++depth_);
    } else if ((c == ']' || c == '}') && depth_ > 0) {
      --depth_;
    }
  }
  int deepest() const { return deepest_; }

 private:
  char quote_ = 0;
  bool skip_ = false, comment_ = false;
  int depth_ = 0, deepest_ = 0;
};

void refuseDeepText(const std::string& text, const std::string& path) {
  BracketDepth brackets;
  char before = '\n', before_space = '\n';
  std::size_t line = 0;
  bool indenting = true;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    brackets.read(c, before, before_space);
    before = c;
    if (c != ' ' && c != '\t' && c != '\r') before_space = c;
    if (c == '\n') line = i + 1;
    indenting = c == '\n' || (indenting && (c == ' ' || c == '-' || c == '?' || c == ':'));
    // Only as far as another level could begin there: a line of dashes is none.
    if (indenting && c == ' ' && i - line > kColumnsMost) refuseDepth(path);
  }
  if (brackets.deepest() > kLevelsMost) refuseDepth(path);
}

/// Walks as a reader would that follows every alias.
void refuseDeepTree(const YAML::Node& node, const std::string& path, int level,
                    std::size_t* count) {
  if (level > kLevelsMost) refuseDepth(path);
  if (++*count > kNodesMost) {
    throw std::runtime_error(path + ": has more than " + std::to_string(kNodesMost) +
                             " values, its aliases (*name) written out; is it the right file?");
  }
  if (node.IsSequence()) {
    for (const auto& entry : node) refuseDeepTree(entry, path, level + 1, count);
  } else if (node.IsMap()) {
    for (const auto& entry : node) {
      refuseDeepTree(entry.first, path, level + 1, count);
      refuseDeepTree(entry.second, path, level + 1, count);
    }
  }
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

YAML::Node loadYaml(const std::string& path) {
  return parseYaml(readRegularFile(path, kBytesMost), path);
}

YAML::Node parseYaml(const std::string& text, const std::string& path) {
  refuseDeepText(text, path);
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const YAML::Exception& e) {
    throw std::runtime_error(path + ": is not valid YAML: " + e.what());
  }
  std::size_t count = 0;
  refuseDeepTree(root, path, 0, &count);
  return root;
}

YAML::Node loadYamlMap(const std::string& path) {
  YAML::Node root = loadYaml(path);
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
    throw std::runtime_error(where + ": unknown key \"" + shortened(key) + "\"; known are " + list);
  }
}

void refuseRepeatedKeys(const YAML::Node& map, const std::string& where) {
  std::set<std::string> seen;
  for (const auto& entry : map) {
    if (!entry.first.IsScalar() || seen.insert(entry.first.Scalar()).second) continue;
    throw std::runtime_error(where + ": key \"" + shortened(entry.first.Scalar()) +
                             "\" stands there twice; keep one");
  }
}

std::string inOneLine(const YAML::Node& node) {
  if (!node.IsDefined()) return "missing";
  if (node.IsNull()) return "empty";
  YAML::Emitter out;
  out << YAML::Flow << node;
  return shortened(out.c_str());
}

void throwBadValue(const std::string& where, const std::string& key, const YAML::Node& node,
                   const std::string& expected) {
  throw std::runtime_error(where + ": " + key + " is " + inOneLine(node) + ", must be " + expected);
}

std::vector<double> numbersAt(const YAML::Node& map, const std::string& where,
                              const std::string& key, std::size_t count) {
  const std::string expected = "a list of " + std::to_string(count) + " numbers";
  const auto values = valueAs<std::vector<double>>(map[key], where, key, expected);
  const bool finite =
      std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (values.size() != count || !finite) throwBadValue(where, key, map[key], expected);
  return values;
}

Eigen::Isometry3d poseIn(const YAML::Node& map, const std::string& where) {
  const auto p = numbersAt(map, where, "position", 3), o = numbersAt(map, where, "orientation", 4);
  const Eigen::Quaterniond q(o[3], o[0], o[1], o[2]);
  if (std::abs(q.norm() - 1.0) > kUnit) {
    throwBadValue(where, "orientation", map["orientation"], "a quaternion x y z w of length 1");
  }
  return rigid(q.normalized().toRotationMatrix(), {p[0], p[1], p[2]});
}

}  // namespace planar_bin_picking
