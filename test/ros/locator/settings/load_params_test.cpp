// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/load_params.h"

#include "calibrator/calibrator_params.h"
#include "hdr/hdr_node_params.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace planar_bin_picking_ros
