// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// The keys below `merge` of config/hdr.yaml, and `threads`: changed in the parameters as ROS has
/// them, each changes the merged image as its comment there says.

#include "hdr/hdr_node_params.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::Exposure;
using XmlRpc::XmlRpcValue;
using Changes = std::vector<std::pair<std::string, XmlRpcValue>>;

/// Linear and unclipped but for the changes.
HdrNodeParams with(const Changes& changes) {
  XmlRpcValue tree;
  tree["merge"]["compression"] = 0.0;
  tree["merge"]["white_percentile"] = 100.0;
  for (const auto& [key, value] : changes) {
    if (key.rfind("merge/", 0) == 0) {
      tree["merge"][key.substr(6)] = value;
    } else {
      tree[key] = value;
    }
  }
  return loadHdrNodeParams(tree);
}

cv::Mat grey(const std::vector<int>& levels) {
  cv::Mat image(9, 3 * static_cast<int>(levels.size()), CV_8U);
  for (int x = 0; x < image.cols; ++x) image.col(x).setTo(levels[static_cast<std::size_t>(x) / 3]);
  return image;
}

/// Grey of the first place; the last one is the brightest.
int merged(const std::vector<Exposure>& bracket, const Changes& changes) {
  const HdrNodeParams params = with(changes);
  return mergeExposures(bracket, params.merge, params.threads > 0 ? params.threads : 1)
      .at<uchar>(0);
}

const std::vector<Exposure> kOne{{grey({128, 255}), 1.0}};
/// Four times as long, the first place is nearly saturated: it had 100, and has 240 in place of
/// 400.
const std::vector<Exposure> kTwo{{grey({100, 250}), 1.0}, {grey({240, 255}), 4.0}};

TEST(HdrKeys, ResponseGamma) {
  EXPECT_NEAR(merged(kOne, {}), 128, 1);
  EXPECT_NEAR(merged(kOne, {{"merge/response_gamma", 2.2}}), 56, 1);  // 255 * 0.502^2.2
}

TEST(HdrKeys, BlackLevel) {
  EXPECT_NEAR(merged(kOne, {{"merge/black_level", 0.2}}), 96, 1);  // (0.502 - 0.2) / 0.8
}

TEST(HdrKeys, Saturation) {
  const int by_default = merged(kTwo, {});
  EXPECT_LT(by_default, 80);  // the long one counts, and darkens it
  EXPECT_NEAR(merged(kTwo, {{"merge/saturation_to", 0.93}}), 102, 1);  // it counts no more
  const int less = merged(kTwo, {{"merge/saturation_from", 0.5}});
  EXPECT_GT(less, by_default + 5);
  EXPECT_LT(less, 102);
}

TEST(HdrKeys, WhitePercentile) {
  const std::vector<Exposure> three{{grey({60, 120, 240}), 1.0}};
  EXPECT_NEAR(merged(three, {}), 64, 1);
  EXPECT_NEAR(merged(three, {{"merge/white_percentile", 50.0}}), 128, 1);  // 120 becomes white
}

TEST(HdrKeys, Compression) {
  // 255 * log(1 + 10 * 0.502) / log(11)
  EXPECT_NEAR(merged(kOne, {{"merge/compression", 10.0}}), 191, 1);
}

TEST(HdrKeys, ThreadsChangeNothingButTime) {
  EXPECT_EQ(with({{"threads", 3}}).threads, 3);
  EXPECT_EQ(merged(kTwo, {{"threads", 3}}), merged(kTwo, {{"threads", 1}}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
