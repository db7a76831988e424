// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// The files that the package ships say what the code says: a default stands in the structs alone,
/// and the YAML that documents it cannot drift from them.

#include "calibrator/calibrator_params.h"
#include "hdr/hdr_node_params.h"
#include "locator/parts/part_library.h"
#include "locator/settings/load_params.h"
#include "locator/settings/settings.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::LocatorParams;

const std::string kConfig = std::string(PACKAGE_DIR) + "/config/";

std::set<std::string> keysOf(const YAML::Node& node, const std::string& prefix = "") {
  std::set<std::string> keys;
  for (const auto& entry : node) {
    const std::string key = prefix + entry.first.as<std::string>();
    if (entry.second.IsMap()) {
      keys.merge(keysOf(entry.second, key + "/"));
    } else {
      keys.insert(key);
    }
  }
  return keys;
}

TEST(Config, LocatorYamlEqualsDefaults) {
  EXPECT_EQ(describe(planar_bin_picking::loadLocatorParams(kConfig + "locator.yaml")),
            describe(LocatorParams{}));
}

TEST(Config, LocatorYamlListsEveryKey) {
  std::set<std::string> fields;
  const LocatorParams params;
  planar_bin_picking::forEachField(params,
                                   [&](const std::string& key, auto&&...) { fields.insert(key); });
  EXPECT_EQ(keysOf(YAML::LoadFile(kConfig + "locator.yaml")), fields);
}

TEST(Config, PickYamlEqualsDefaults) {
  const planar_bin_picking::PickParams params;
  std::set<std::string> keys;
  const YAML::Node root = YAML::LoadFile(kConfig + "pick.yaml");
  planar_bin_picking::PickParams::fields(
      params, [&](const std::string& key, const auto& member, auto&&...) {
        ASSERT_TRUE(root[key]) << key;
        EXPECT_EQ(root[key].as<std::decay_t<decltype(member)>>(), member) << key;
        keys.insert(key);
      });
  EXPECT_EQ(keysOf(root), keys);
}

// An operator may change every rule of the pick policy; of the rest, what the list names.
TEST(Config, TuningNamesParameters) {
  std::ifstream file(kConfig + "Tuning.cfg");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::set<std::string> names;
  const std::regex entry("\"(\\w+)\": \"");
  for (std::sregex_iterator i(text.begin(), text.end(), entry); i != std::sregex_iterator(); ++i)
    names.insert((*i)[1]);
  Settings settings;
  settings.cell.bin_min = settings.cell.bin_max = {0.0, 0.0, 0.0};
  const auto numbers = numbersOf(settings);
  for (const std::string& name : names) EXPECT_EQ(numbers.count(name), 1u) << name;
  planar_bin_picking::PickParams::fields(
      settings.pick, [&](const std::string& key, const auto& member, auto&&... range) {
        if (std::is_arithmetic_v<std::decay_t<decltype(member)>> && sizeof...(range) == 2) {
          EXPECT_EQ(names.count(key), 1u) << key << " is missing in config/Tuning.cfg";
        }
      });
}

TEST(Config, HdrYamlEqualsDefaults) {
  const HdrNodeParams params;
  int keys = 0;
  const YAML::Node root = YAML::LoadFile(kConfig + "hdr.yaml");
  HdrNodeParams::fields(params, [&](const std::string& key, const auto& member, auto&&...) {
    const bool is_merge = key.rfind("merge/", 0) == 0;
    const YAML::Node node = is_merge ? root["merge"][key.substr(6)] : root[key];
    ASSERT_TRUE(node) << key;
    EXPECT_EQ(node.as<std::decay_t<decltype(member)>>(), member) << key;
    ++keys;
  });
  EXPECT_EQ(keysOf(root).size(), static_cast<std::size_t>(keys));
}

// The lines that are commented out in cell.yaml are keys, too.
TEST(Config, CellYamlHasKnownKeys) {
  std::set<std::string> fields;
  const CellParams params;
  CellParams::fields(params, [&](const std::string& key, auto&&...) { fields.insert(key); });
  std::ifstream file(kConfig + "cell.yaml");
  int keys = 0;
  for (std::string line; std::getline(file, line);) {
    const auto start = line.compare(0, 2, "# ") == 0 ? 2 : 0;
    const auto colon = line.find(": ", start);
    const std::string key = line.substr(start, colon - start);
    if (colon == std::string::npos || key.find(' ') != std::string::npos) continue;
    EXPECT_EQ(fields.count(key), 1u) << key;
    ++keys;
  }
  EXPECT_GE(keys, 8);
}

/// A parameter as the YAML file has it.
template <class T>
T valueIn(const YAML::Node& root, const std::string& key) {
  const auto slash = key.find('/');
  return slash == std::string::npos ? root[key].as<T>()
                                    : root[key.substr(0, slash)][key.substr(slash + 1)].as<T>();
}

TEST(Config, CalibratorYamlEqualsDefaults) {
  const YAML::Node root = YAML::LoadFile(kConfig + "calibrator.yaml");
  std::set<std::string> fields;
  const CalibratorParams params;
  CalibratorParams::fields(params, [&](const std::string& key, const auto& member, auto&&...) {
    fields.insert(key);
    EXPECT_EQ(valueIn<std::decay_t<decltype(member)>>(root, key), member) << key;
  });
  EXPECT_EQ(keysOf(root), fields);
}

TEST(Config, PartsLoad) {
  const PartLibrary library(kConfig + "parts");
  EXPECT_TRUE(library.errors().empty());
  EXPECT_EQ(library.parts().count("bracket"), 1u);
}

}  // namespace
}  // namespace planar_bin_picking_ros
