// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
/// Each key of config/locator.yaml, written into a file and changed, changes what is located in the
/// embedded scene; `threads` alone must not.

#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/part/part_file.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <map>
#include <set>
#include <sstream>
#include <string>

namespace planar_bin_picking {
namespace {

const std::string kPackage = PACKAGE_DIR;

/// Value that differs from the default, and other keys that must be set for it to matter.
struct Change {
  std::string key, value, others;
};

const std::string kPlane = "distance: 0.94";  // some parts of the heap lie on it

const std::vector<Change> kChanges = {
    {"edges/noise_factor", "6", ""},
    {"edges/texture_factor", "3", ""},
    {"edges/texture_cost_px", "2", ""},
    {"edges/megapixels", "0.3", ""},
    {"edges/direction_cost_px", "1.5", ""},
    {"edges/radius_px", "40", ""},
    {"hough/radius_cells", "10", ""},
    {"hough/tolerance_cells", "1.5", ""},
    {"hough/yaw_step_deg", "7.5", ""},
    {"hough/distance_step", "0.09", ""},
    {"hough/tilt_max_deg", "20", ""},
    {"hough/raster_points", "40", ""},
    {"hough/votes_min", "0.75", ""},
    {"hough/tile_cells", "6", ""},
    {"hough/max_candidates", "100", ""},
    {"refine/tilt_limit_deg", "5", ""},
    {"refine/field_points", "96", ""},
    {"refine/field_iterations", "8", ""},
    {"refine/field_reach_radii", "0.2", ""},
    {"refine/field_reach_end_px", "3", ""},
    {"refine/field_inliers_min", "0.9", "min_poses: 0"},
    {"refine/min_poses", "0", "field_inliers_min: 0.9"},
    {"refine/max_poses", "10", ""},
    {"refine/image_inliers_min", "0.95", ""},
    {"refine/search_below", "1", ""},
    {"refine/search_inliers_min", "0.95", ""},
    {"refine/wide_points", "192", ""},
    {"refine/image_points", "480", ""},
    {"plane/distance", "0.94", ""},
    {"plane/normal_x", "0.02", kPlane},
    {"plane/normal_y", "0.02", kPlane},
    {"plane/normal_z", "-0.5", kPlane + ", normal_x: 0.01"},
    {"plane/sigma", "0.002", kPlane},
    {"plane/sigma_tilt_deg", "2", kPlane},
    {"plane/gate", "60", kPlane},
    {"score/threshold", "0.96", ""},
    {"score/reach_px", "2", ""},
    {"score/points", "384", ""},
    {"score/visible_reach_px", "4", ""},
    {"rank/overlap_max", "0", ""},
    {"rank/overlap_max", "1", ""},
};

class LocatorKeys : public testing::Test {
 protected:
  /// Everything that was located, to the last digit.
  std::string locate(const std::string& yaml) {
    dir_.write("params.yaml", yaml);
    const Locator locator(loadLocatorParams(dir_.path("params.yaml")));
    std::ostringstream text;
    text.precision(17);
    for (const Detection& detection : locator.locate(image_, camera_, request_).detections) {
      text << detection.score << " " << detection.visible_fraction << " "
           << detection.T_camera_part.matrix() << "\n";
    }
    return text.str();
  }

  static std::string asYaml(const Change& change, bool with_key) {
    const auto slash = change.key.find('/');
    const std::string own = change.key.substr(slash + 1) + ": " + change.value;
    std::string keys = change.others;
    if (with_key) keys += (keys.empty() ? "" : ", ") + own;
    return keys.empty() ? "{}\n" : change.key.substr(0, slash) + ": {" + keys + "}\n";
  }

  void SetUp() override {
    request_.parts = {
        std::make_shared<const PartModel>(loadPartFile(kPackage + "/config/parts/bracket.yaml"))};
    request_.distance_min = 0.785;
    request_.distance_max = 0.98;
  }

  TempDir dir_;
  const std::string scene_ = kPackage + "/test/data/bin_bracket_00/";
  const cv::Mat image_ = cv::imread(scene_ + "image.png", cv::IMREAD_GRAYSCALE);
  const Camera camera_ = loadCamera(scene_ + "camera_info.yaml");
  LocateRequest request_;
};

TEST_F(LocatorKeys, EachChangesTheResult) {
  std::map<std::string, std::string> unchanged;
  for (const Change& change : kChanges) {
    const std::string before = asYaml(change, false);
    if (unchanged.count(before) == 0) unchanged[before] = locate(before);
    EXPECT_NE(locate(asYaml(change, true)), unchanged[before]) << change.key;
  }
}

TEST_F(LocatorKeys, ThreadsDoNot) {
  const std::string one = locate("threads: 1\n");
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(locate("threads: 3\n"), one);
}

TEST_F(LocatorKeys, AreAllTriedHere) {
  std::set<std::string> tried = {"threads"}, known;
  for (const Change& change : kChanges) tried.insert(change.key);
  const LocatorParams params;
  forEachField(params, [&](const std::string& key, auto&&...) {
    if (key.rfind("views/", 0) != 0) known.insert(key);  // those are tried in view_keys_test
  });
  EXPECT_EQ(tried, known);
}

}  // namespace
}  // namespace planar_bin_picking
