// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/settings.h"

#include "locator/settings/load_params.h"
#include "locator/settings/yaml_edit.h"
#include "shared/names.h"
#include "shared/param_reader.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <type_traits>

namespace planar_bin_picking_ros {

using XmlRpc::XmlRpcValue;

namespace {

constexpr const char* kAxes[] = {"_x", "_y", "_z"};

/// `over` wins; maps are joined.
void mergeInto(XmlRpcValue* tree, const XmlRpcValue& over) {
  for (const auto& [key, value] : over) {
    XmlRpcValue& mine = (*tree)[key];
    const bool both =
        mine.getType() == XmlRpcValue::TypeStruct && value.getType() == XmlRpcValue::TypeStruct;
    if (both) {
      mergeInto(&mine, value);
    } else {
      mine = value;
    }
  }
}

YamlPath pathOf(YamlPath path, const std::string& key) {
  std::istringstream parts(key);
  for (std::string part; std::getline(parts, part, '/');) path.push_back(part);
  return path;
}

/// Calls visit(path, key, member, min, max) for numbers, and visit(path, key, member) for the rest.
template <class Any, class Visit>
void forEachField(Any& settings, Visit&& visit) {
  const auto below = [&visit](const YamlPath& path) {
    return [&visit, path](const std::string& key, auto& member, auto... range) {
      visit(pathOf(path, key), key, member, range...);
    };
  };
  planar_bin_picking::forEachField(settings.locator, below({kLocatorParams}));
  CellParams::fields(settings.cell, below({}));
  planar_bin_picking::PickParams::fields(settings.pick, below({kPickParams}));
}

std::string nameOf(std::string key) {
  std::replace(key.begin(), key.end(), '/', '_');
  return key;
}

struct Collect {
  std::map<std::string, Number> numbers;

  template <class Member>
  void operator()(const YamlPath&, const std::string& key, const Member& member, const Member min,
                  const Member max) {
    numbers[nameOf(key)] = {static_cast<double>(member), static_cast<double>(min),
                            static_cast<double>(max)};
  }
  void operator()(const YamlPath&, const std::string& key, const std::vector<double>& list) {
    constexpr double kFar = 1000.0;  // metres; nothing in a cell is farther off
    for (std::size_t i = 0; list.size() == std::size(kAxes) && i < list.size(); ++i)
      numbers[key + kAxes[i]] = {list[i], -kFar, kFar};
  }
  void operator()(const YamlPath&, const std::string&, const std::string&) {}
};

/// Puts values in, and takes them out of the list of those that are left.
struct Assign {
  std::map<std::string, double> values;

  template <class Member>
  void operator()(const YamlPath&, const std::string& key, Member& member, const Member min,
                  const Member max) {
    const auto found = values.find(nameOf(key));
    if (found == values.end()) return;
    const double value = found->second;
    const bool is_whole = std::is_floating_point_v<Member> || value == std::floor(value);
    if (!(value >= min && value <= max) || !is_whole) {
      std::ostringstream text;
      text << found->first << " is " << value << ", but must "
           << (is_whole ? "lie in " : "be a whole number in ") << min << " .. " << max;
      throw std::invalid_argument(text.str());
    }
    member = static_cast<Member>(value);
    values.erase(found);
  }
  void operator()(const YamlPath&, const std::string& key, std::vector<double>& list) {
    for (std::size_t i = 0; list.size() == std::size(kAxes) && i < list.size(); ++i) {
      const auto found = values.find(key + kAxes[i]);
      if (found == values.end()) continue;
      list[i] = found->second;
      values.erase(found);
    }
  }
  void operator()(const YamlPath&, const std::string&, std::string&) {}
};

struct Write {
  std::map<YamlPath, std::string> values;

  template <class Member>
  void operator()(const YamlPath& path, const std::string&, const Member& member, Member, Member) {
    if constexpr (std::is_same_v<Member, bool>) {
      values[path] = member ? "true" : "false";
    } else if constexpr (std::is_integral_v<Member>) {
      values[path] = std::to_string(member);
    } else {
      values[path] = yamlNumber(member);
    }
  }
  void operator()(const YamlPath& path, const std::string&, const std::vector<double>& list) {
    std::string text;
    for (const double number : list) text += (text.empty() ? "" : ", ") + yamlNumber(number);
    values[path] = "[" + text + "]";
  }
  void operator()(const YamlPath&, const std::string&, const std::string&) {}
};

}  // namespace

Settings loadSettings(const XmlRpcValue& locator, const XmlRpcValue& pick,
                      const XmlRpcValue& cell) {
  if (cell.getType() != XmlRpcValue::TypeStruct)
    throw std::invalid_argument("~cell is not a tree of parameters");
  XmlRpcValue trees, own;
  trees[kLocatorParams] = locator;
  trees[kPickParams] = pick;
  own.begin();  // makes it an empty struct
  for (const auto& [key, value] : cell) {
    if (key != kLocatorParams && key != kPickParams) {
      own[key] = value;
    } else if (value.getType() == XmlRpcValue::TypeStruct) {
      mergeInto(&trees[key], value);
    } else {
      throw std::invalid_argument("~cell/" + key + " is not a tree of parameters");
    }
  }
  return {loadLocatorParams(trees[kLocatorParams]), loadCellParams(own),
          loadPickParams(trees[kPickParams])};
}

Settings loadSettings(const ros::NodeHandle& pnh) {
  return loadSettings(readTree(pnh, kLocatorParams), readTree(pnh, kPickParams),
                      readTree(pnh, kCellParams));
}

std::string describe(const Settings& settings) {
  return "locator:" + describe(settings.locator) + "\ncell:" + describe(settings.cell) +
         "\npick:" + describe(settings.pick) + "\n";
}

std::map<std::string, Number> numbersOf(const Settings& settings) {
  Collect collect;
  forEachField(settings, collect);
  return collect.numbers;
}

Settings withNumbers(Settings settings, const std::map<std::string, double>& values) {
  Assign assign{values};
  forEachField(settings, assign);
  for (const auto& [name, value] : assign.values) {
    if (value == 0.0) continue;
    std::ostringstream text;
    text
        << name << " is " << value
        << ", but this cell has no such list of three numbers; write it into the cell's file first";
    throw std::invalid_argument(text.str());
  }
  planar_bin_picking::validate(settings.locator);
  validate(settings.cell);
  planar_bin_picking::PickPolicy{settings.pick};  // throws
  return settings;
}

std::map<YamlPath, std::string> yamlOf(const Settings& settings) {
  Write write;
  forEachField(settings, write);
  return write.values;
}

}  // namespace planar_bin_picking_ros
