// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/load_params.h"

#include "calibrator/calibrator_params.h"
#include "hdr/hdr_node_params.h"
#include "locator/settings/settings.h"
#include "locator/settings/yaml_edit.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::LocatorParams;
using planar_bin_picking::refuses;
using XmlRpc::XmlRpcValue;

XmlRpcValue emptyTree() {
  XmlRpcValue tree;
  tree.begin();  // makes it a struct
  return tree;
}

XmlRpcValue list(const std::vector<double>& numbers) {
  XmlRpcValue value;
  value.setSize(static_cast<int>(numbers.size()));
  for (std::size_t i = 0; i < numbers.size(); ++i) value[static_cast<int>(i)] = numbers[i];
  return value;
}

XmlRpcValue cellTree() {
  XmlRpcValue tree;
  tree["parts_folder"] = "parts";
  tree["distance_min"] = 0.5;
  tree["distance_max"] = 1;  // as YAML gives a number without a point
  return tree;
}

XmlRpcValue binTree() {
  XmlRpcValue tree;
  tree["parts_folder"] = "parts";
  tree["bin_frame"] = "bin";
  tree["bin_min"] = list({-0.2, -0.1, 0.0});
  tree["bin_max"] = list({0.2, 0.1, 0.3});
  return tree;
}

TEST(LoadHdrNodeParams, NothingSetGivesDefaults) {
  EXPECT_EQ(describe(loadHdrNodeParams(emptyTree())), describe(HdrNodeParams{}));
}

TEST(LoadHdrNodeParams, RefusesByKey) {
  XmlRpcValue one = emptyTree(), negative = emptyTree(), service = emptyTree(), merge = emptyTree();
  one["exposures_ms"] = list({8.0});
  EXPECT_TRUE(refuses([&] { loadHdrNodeParams(one); }, {"at least two"}));
  negative["exposures_ms"] = list({8.0, -1.0});
  EXPECT_TRUE(refuses([&] { loadHdrNodeParams(negative); }, {"~hdr/exposures_ms"}));
  XmlRpcValue triggers = emptyTree();
  triggers["triggers_max"] = 2;
  EXPECT_EQ(loadHdrNodeParams(triggers).triggers_max, 2);
  triggers["trigger_service"] = "trigger";
  EXPECT_TRUE(
      refuses([&] { loadHdrNodeParams(triggers); }, {"~hdr/triggers_max is 2", "which is 3"}));
  service["exposure_service"] = "set_exposure";
  EXPECT_TRUE(refuses([&] { loadHdrNodeParams(service); }, {"~hdr/single_ms"}));
  service["single_ms"] = 10.0;
  EXPECT_EQ(loadHdrNodeParams(service).exposure_service, "set_exposure");
  merge["merge"]["compression"] = -1.0;
  EXPECT_TRUE(refuses([&] { loadHdrNodeParams(merge); }, {"~hdr/merge/compression"}));
}

TEST(LoadLocatorParams, NothingSetGivesDefaults) {
  EXPECT_EQ(describe(loadLocatorParams(emptyTree())), describe(LocatorParams{}));
}

TEST(LoadLocatorParams, EveryFieldCanBeSet) {
  // Every number to the lower end of its range and every bool to its opposite, through ROS's types.
  LocatorParams expected;
  XmlRpcValue tree = emptyTree();
  const auto setLowest = [&](const std::string& key, auto& member, auto min, auto) {
    if constexpr (std::is_same_v<std::decay_t<decltype(member)>, bool>) {
      member = !member;
    } else {
      member = min;
    }
    const auto slash = key.find('/');
    if (slash == std::string::npos) {
      tree[key] = XmlRpcValue(member);
    } else {
      tree[key.substr(0, slash)][key.substr(slash + 1)] = XmlRpcValue(member);
    }
  };
  planar_bin_picking::forEachField(expected, setLowest);
  EXPECT_EQ(describe(loadLocatorParams(tree)), describe(expected));
}

TEST(LoadLocatorParams, RefusesByName) {
  XmlRpcValue typo = emptyTree(), range = emptyTree(), type = emptyTree(), place = emptyTree();
  typo["score"]["treshold"] = 0.5;
  range["score"]["threshold"] = 1.5;
  type["threads"] = "two";
  place["threshold"] = 0.5;
  EXPECT_TRUE(refuses([&] { loadLocatorParams(typo); }, {"~locator/score/treshold", "unknown"}));
  EXPECT_TRUE(
      refuses([&] { loadLocatorParams(range); }, {"~locator/score/threshold", "1.5", "0 .. 1"}));
  EXPECT_TRUE(
      refuses([&] { loadLocatorParams(type); }, {"~locator/threads", "two", "whole number"}));
  EXPECT_TRUE(refuses([&] { loadLocatorParams(place); }, {"~locator/threshold", "unknown"}));
  EXPECT_TRUE(refuses([&] { loadLocatorParams(XmlRpcValue(3)); }, {"~locator"}));
}

TEST(LoadCellParams, Distances) {
  const CellParams cell = loadCellParams(cellTree());
  EXPECT_EQ(cell.parts_folder, "parts");
  EXPECT_EQ(cell.distance_min, 0.5);
  EXPECT_EQ(cell.distance_max, 1.0);
  EXPECT_FALSE(cell.hasBin());
}

TEST(LoadCellParams, Bin) {
  const CellParams cell = loadCellParams(binTree());
  EXPECT_TRUE(cell.hasBin());
  EXPECT_EQ(cell.bin_max, (std::vector<double>{0.2, 0.1, 0.3}));
}

TEST(LoadCellParams, RefusesByName) {
  const auto refused = [](XmlRpcValue tree, const std::string& key, const XmlRpcValue& value,
                          const std::string& word) {
    tree[key] = value;
    return refuses([&] { loadCellParams(tree); }, {"~cell", word});
  };
  EXPECT_TRUE(refused(cellTree(), "distance", 1.0, "distance"));
  EXPECT_TRUE(refused(cellTree(), "parts_folder", "", "parts_folder"));
  EXPECT_TRUE(refused(cellTree(), "parts_folder", 7, "parts_folder"));
  EXPECT_TRUE(refused(cellTree(), "distance_min", 2.0, "distance_min"));
  EXPECT_TRUE(refused(cellTree(), "distance_max", -1.0, "distance_max"));
  EXPECT_TRUE(refused(cellTree(), "distance_max", "far", "distance_max"));
  EXPECT_TRUE(refused(cellTree(), "image_timeout", -1.0, "image_timeout"));
  EXPECT_TRUE(refused(cellTree(), "tf_gap_max", 0.0, "tf_gap_max"));
  EXPECT_TRUE(refused(cellTree(), "distance_min", 1e-12, "distance_min"));
  EXPECT_TRUE(refused(cellTree(), "distance_min", 0.01, "distance_min"));  // ratio
  EXPECT_TRUE(refused(cellTree(), "bin_frame", "bin", "either"));
  EXPECT_TRUE(refused(cellTree(), "bin_min", list({0, 0, 0}), "bin_frame"));
  EXPECT_TRUE(refused(binTree(), "distance_min", 0.5, "either"));
  EXPECT_TRUE(refused(binTree(), "bin_min", list({0, 0}), "bin_min"));
  EXPECT_TRUE(refused(binTree(), "bin_min", list({0, 0, 0.4}), "bin_min"));
  EXPECT_TRUE(refused(binTree(), "bin_found", list({0, 0, 0, 0, 0, 1}), "bin_found"));
  EXPECT_TRUE(refused(binTree(), "bin_found", list({0, 0, 0, 0, 0, 1, 1}), "length 1"));
  EXPECT_TRUE(refused(cellTree(), "bin_found", list({0, 0, 0, 0, 0, 0, 1}), "bin_frame"));
  EXPECT_TRUE(refuses([] { loadCellParams(emptyTree()); }, {"parts_folder"}));
}

TEST(LoadCellParams, TakesTheLimitsOfTheNextView) {
  XmlRpcValue tree = cellTree();
  tree["next_view_min"] = list({-0.5, -0.5, 0.4});
  const auto refused = [&](const std::string& word) {
    return refuses([&] { loadCellParams(tree); }, {"~cell", word});
  };
  EXPECT_TRUE(refused("next_view_max"));
  tree["next_view_max"] = list({0.5, 0.5, 0.4});
  tree["focus_min"] = 0.5;
  tree["focus_max"] = 0.9;
  EXPECT_TRUE(refused("less than"));
  tree["next_view_max"] = list({0.5, 0.5, 1.0});
  tree["next_view_cone_deg"] = 20.0;
  const CellParams cell = loadCellParams(tree);
  EXPECT_EQ(cell.next_view_max, (std::vector<double>{0.5, 0.5, 1.0}));
  EXPECT_EQ(cell.next_view_cone_deg, 20.0);
  EXPECT_EQ(cell.focus_max, 0.9);
  tree["focus_min"] = 0.9;
  EXPECT_TRUE(refused("focus_min"));
}

TEST(LoadCellParams, TakesTheOtherCameraAndTheHandEyeFile) {
  XmlRpcValue tree = cellTree();
  tree["second_camera_topic"] = "second/image_raw";
  tree["second_camera_frame"] = "second_camera";
  tree["hand_eye_file"] = "hand_eye.yaml";
  const CellParams cell = loadCellParams(tree);
  EXPECT_EQ(cell.second_camera_topic, "second/image_raw");
  EXPECT_EQ(cell.second_camera_frame, "second_camera");
  EXPECT_EQ(cell.hand_eye_file, "hand_eye.yaml");
}

// --- all together --------------------------------------------------------------------------------

TEST(Settings, TheCellsOwnValuesWin) {
  XmlRpcValue locator = emptyTree(), pick = emptyTree(), cell = cellTree();
  locator["score"]["threshold"] = 0.6;
  locator["score"]["points"] = 100;
  pick["score_min"] = 0.7;
  pick["tilt_max_deg"] = 30.0;
  cell["locator"]["score"]["threshold"] = 0.8;
  cell["pick"]["score_min"] = 0.9;
  const Settings settings = loadSettings(locator, pick, cell);
  EXPECT_EQ(settings.locator.score.threshold, 0.8);
  EXPECT_EQ(settings.locator.score.points, 100);
  EXPECT_EQ(settings.pick.score_min, 0.9);
  EXPECT_EQ(settings.pick.tilt_max_deg, 30.0);
  EXPECT_EQ(settings.cell.distance_min, 0.5);
  cell["pick"] = "none";
  EXPECT_TRUE(refuses([&] { loadSettings(locator, pick, cell); }, {"~cell/pick", "tree"}));
  cell["pick"] = emptyTree();
  cell["pick"]["scoremin"] = 0.9;
  EXPECT_TRUE(refuses([&] { loadSettings(locator, pick, cell); }, {"scoremin", "unknown"}));
}

TEST(Settings, ChangeAsAWholeOrNotAtAll) {
  const Settings before = loadSettings(emptyTree(), emptyTree(), binTree());
  const auto numbers = numbersOf(before);
  EXPECT_EQ(numbers.at("score_threshold").value, LocatorParams{}.score.threshold);
  EXPECT_EQ(numbers.at("score_threshold").max, 1.0);
  EXPECT_EQ(numbers.at("bin_max_z").value, 0.3);
  EXPECT_EQ(numbers.at("failures_max").min, 1.0);
  const Settings after =
      withNumbers(before, {{"score_threshold", 0.7}, {"bin_max_z", 0.4}, {"max_parts", 3.0}});
  EXPECT_EQ(after.locator.score.threshold, 0.7);
  EXPECT_EQ(after.cell.bin_max[2], 0.4);
  EXPECT_EQ(after.pick.max_parts, 3);
  const auto refused = [&](const std::map<std::string, double>& values, const std::string& a,
                           const std::string& b) {
    return refuses([&] { withNumbers(before, values); }, {a, b});
  };
  EXPECT_TRUE(refused({{"score_threshold", 1.5}}, "score_threshold is 1.5", "0 .. 1"));
  EXPECT_TRUE(refused({{"score_threshold", std::nan("")}}, "score_threshold", "0 .. 1"));
  EXPECT_TRUE(refused({{"max_parts", 1.5}}, "max_parts is 1.5", "whole number"));
  EXPECT_TRUE(refused({{"bin_max_z", -1.0}}, "bin_min", "less than"));
  EXPECT_TRUE(refused({{"distance_min", 0.5}}, "distance_min", "bin_frame"));
  EXPECT_TRUE(refused({{"nonesuch", 1.0}}, "nonesuch", "no such list"));
  const Settings flat = loadSettings(emptyTree(), emptyTree(), cellTree());
  EXPECT_TRUE(refuses([&] { withNumbers(flat, {{"bin_min_x", 0.1}}); }, {"bin_min_x is 0.1"}));
  EXPECT_EQ(withNumbers(flat, {{"bin_min_x", 0.0}, {"distance_min", 0.6}}).cell.distance_min, 0.6);
}

TEST(Settings, StandInTheCellsFileWhereTheyAreRead) {
  const auto values = yamlOf(loadSettings(emptyTree(), emptyTree(), binTree()));
  EXPECT_EQ(values.at({"locator", "score", "threshold"}), "0.4");
  EXPECT_EQ(values.at({"pick", "failures_max"}), "2");
  EXPECT_EQ(values.at({"bin_min"}), "[-0.2, -0.1, 0.0]");
  EXPECT_EQ(values.at({"locator", "plane", "normal_z"}), "-1.0");
}

// --- the file ------------------------------------------------------------------------------------

TEST(YamlEdit, NumbersAreReadByEveryReader) {
  EXPECT_EQ(yamlNumber(0.65), "0.65");
  EXPECT_EQ(yamlNumber(2.0), "2.0");
  EXPECT_EQ(yamlNumber(1e-6), "0.000001");
  EXPECT_EQ(yamlNumber(-100.0), "-100.0");
}

TEST(YamlEdit, KeepsAllElse) {
  const std::string before =
      "# The cell at gate 3\n"
      "distance_min: 0.78   # measured\n"
      "pick:\n"
      "    score_min: 0.5\n"
      "    # what the gripper needs\n"
      "    tool_radius: 0.01\n"
      "\n"
      "target_frame: base\n";
  EXPECT_EQ(withYamlValues(before, {{{"distance_min"}, "0.8"},
                                    {{"bin_min"}, "[0.0, 1.0, 2.0]"},
                                    {{"locator", "score", "threshold"}, "0.7"},
                                    {{"pick", "score_min"}, "0.75"},
                                    {{"pick", "max_parts"}, "3"}}),
            "# The cell at gate 3\n"
            "distance_min: 0.8    # measured\n"
            "pick:\n"
            "    score_min: 0.75\n"
            "    # what the gripper needs\n"
            "    tool_radius: 0.01\n"
            "    max_parts: 3\n"
            "\n"
            "target_frame: base\n"
            "bin_min: [0.0, 1.0, 2.0]\n"
            "locator:\n"
            "  score:\n"
            "    threshold: 0.7\n");
  EXPECT_EQ(withYamlValues("", {{{"a"}, "1"}}), "a: 1\n");
  EXPECT_EQ(withYamlValues("# only a comment", {{{"a"}, "1"}}), "# only a comment\na: 1\n");
}

TEST(YamlEdit, RefusesWhatItCannotChange) {
  const auto refused = [](const std::string& text, const std::string& word) {
    return refuses([&] { withYamlValues(text, {{{"pick", "score_min"}, "0.5"}}); }, {word});
  };
  EXPECT_TRUE(refused("pick: {score_min: 0.1}\n", "pick/score_min"));
  EXPECT_TRUE(refused("\"pick\":\n  score_min: 0.1\n", "pick/score_min"));
  EXPECT_TRUE(refused("pick:\n  score_min:\n    0.1\n", "pick/score_min"));
  EXPECT_TRUE(refused("pick: 3\n", "no map"));
  EXPECT_TRUE(refused("- 1\n", "no map"));
  EXPECT_TRUE(refused("a: [1\n", "yaml"));
}

TEST(YamlEdit, SavesInOneStepAndKeepsWhatWasThere) {
  const planar_bin_picking::TempDir dir;
  const std::string path = dir.write("cell.yaml", "a: 1  # one\n");
  saveYamlValues(path, {{{"a"}, "2"}});
  const auto contents = [](const std::string& name) {
    std::ifstream file(name);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(contents(path), "a: 2  # one\n");
  EXPECT_EQ(contents(path + ".before"), "a: 1  # one\n");
  EXPECT_TRUE(refuses(
      [&] {
        saveYamlValues(dir.path("none.yaml"), {{{"a"}, "2"}});
      },
      {"none.yaml", "cannot be read"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
