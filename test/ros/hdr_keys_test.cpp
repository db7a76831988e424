// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// Each key of config/hdr.yaml below `merge`, loaded as the node loads it, changes the merged
/// image.

#include "load_params.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>
#include <opencv2/core.hpp>

#include <cmath>
#include <map>
#include <set>

namespace planar_bin_picking_ros {
namespace {

/// 1 to 1000 of light over the width, and a camera that is full at 1000 after a second.
cv::Mat expose(const double seconds) {
  cv::Mat image(20, 400, CV_8U);
  for (int x = 0; x < image.cols; ++x) {
    const double light = std::pow(1000.0, x / (image.cols - 1.0));
    image.col(x).setTo(std::min(255.0, 255.0 * light * seconds / 1000.0));
  }
  return image;
}

cv::Mat merge(const std::string& key, const double value) {
  XmlRpc::XmlRpcValue tree;
  tree.begin();  // makes it an empty struct
  if (!key.empty()) tree["merge"][key] = value;
  std::vector<planar_bin_picking::Exposure> bracket;
  for (const double seconds : {0.5, 4.0, 32.0}) bracket.push_back({expose(seconds), seconds});
  return mergeExposures(bracket, loadHdrNodeParams(tree).merge, 1);
}

TEST(HdrKeys, OfTheMergeChangeTheImage) {
  const std::map<std::string, double> changes = {
      {"merge/response_gamma", 2.2},    {"merge/black_level", 0.05},
      {"merge/saturation_from", 0.5},   {"merge/saturation_to", 0.92},
      {"merge/white_percentile", 90.0}, {"merge/compression", 0.0}};
  const cv::Mat unchanged = merge("", 0.0);
  std::set<std::string> tried, known;
  for (const auto& [key, value] : changes) {
    const std::string name = key.substr(key.find('/') + 1);
    EXPECT_GT(cv::norm(merge(name, value), unchanged, cv::NORM_INF), 0.0) << key;
    tried.insert(name);
  }
  const YAML::Node root = YAML::LoadFile(std::string(PACKAGE_DIR) + "/config/hdr.yaml");
  for (const auto& entry : root["merge"]) known.insert(entry.first.as<std::string>());
  EXPECT_EQ(tried, known);
}

}  // namespace
}  // namespace planar_bin_picking_ros
