// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/snapshot/snapshot.h"

#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/snapshot/snapshot_ring.h"
#include "snapshot/grey_file.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <cmath>
#include <filesystem>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

const fs::path kParts = fs::path(PACKAGE_DIR) / "config/parts";

Snapshot example() {
  Camera::Model model;
  model.width = 101, model.height = 67;
  model.fx = 300.0 / 7.0 * 2.0, model.fy = 85.1234567890123, model.cx = 50.1, model.cy = 33.3;
  model.distortion_model = "rational_polynomial";
  model.distortion = {-1e-3 / 3.0, 2e-5, 1e-17, 0.0, 0.0, 0.0, 0.0, 1e-4};
  Snapshot snapshot{"1.2.3", cv::Mat(67, 101, CV_16U), Camera(model), {}, {}, "detections: []\n"};
  cv::RNG(5).fill(snapshot.grey, cv::RNG::UNIFORM, 0, 65536);
  snapshot.params.score.threshold = 2.0 / 3.0;
  snapshot.params.threads = 3;
  snapshot.request.distance_min = 0.1 + 0.2;
  snapshot.request.distance_max = std::sqrt(0.5);
  snapshot.request.face = FaceFilter::kBack;
  snapshot.request.max_parts = 4;
  snapshot.request.window = PixelBox{10, 0, 80, 66};
  snapshot.request.plane = Plane{Eigen::Vector3d(0.1, 0.2, -1.0).normalized(), 1.0 / 3.0};
  snapshot.request.floor_normal = Eigen::Vector3d(-0.1, 0.3, -1.0).normalized();
  return snapshot;
}

TEST(Snapshot, GivesBackEveryBit) {
  const TempDir folder;
  const Snapshot out = example();
  const std::string path = folder.path("one");
  writeSnapshot(path, out,
                {{(kParts / "bracket.yaml").string(), "bracket.yaml", true},
                 {(kParts / "bracket.dxf").string(), "bracket.dxf", false}},
                {{"notes/call.yaml", "status: 1\n"}});
  const Snapshot in = readSnapshot(path);
  EXPECT_EQ(in.version, "1.2.3");
  EXPECT_EQ(cv::norm(in.grey, out.grey, cv::NORM_INF), 0.0);
  EXPECT_EQ(in.grey.type(), out.grey.type());
  EXPECT_EQ(in.camera.model().fx, out.camera.model().fx);
  EXPECT_EQ(in.camera.model().fy, out.camera.model().fy);
  EXPECT_EQ(in.camera.model().cx, out.camera.model().cx);
  EXPECT_EQ(in.camera.model().distortion_model, out.camera.model().distortion_model);
  EXPECT_EQ(in.camera.model().distortion, out.camera.model().distortion);
  EXPECT_EQ(in.params.score.threshold, out.params.score.threshold);
  EXPECT_EQ(in.params.threads, 3);
  EXPECT_EQ(in.request.distance_min, out.request.distance_min);
  EXPECT_EQ(in.request.distance_max, out.request.distance_max);
  EXPECT_EQ(in.request.face, FaceFilter::kBack);
  EXPECT_EQ(in.request.max_parts, 4u);
  ASSERT_TRUE(in.request.window.has_value());
  EXPECT_EQ(in.request.window->left, 10);
  EXPECT_EQ(in.request.window->top, 0);
  EXPECT_EQ(in.request.window->width, 80);
  EXPECT_EQ(in.request.window->height, 66);
  ASSERT_TRUE(in.request.plane.has_value());
  EXPECT_EQ(in.request.plane->normal_camera, out.request.plane->normal_camera);
  EXPECT_EQ(in.request.plane->distance, out.request.plane->distance);
  EXPECT_EQ(in.request.floor_normal, out.request.floor_normal);
  ASSERT_EQ(in.request.parts.size(), 1u);
  EXPECT_EQ(in.request.parts.front()->name(), "bracket");
  EXPECT_EQ(in.result, out.result);
  EXPECT_TRUE(fs::exists(path + "/notes/call.yaml"));
  EXPECT_FALSE(fs::exists(path + ".partial"));
}

TEST(Snapshot, EightBitsStayEight) {
  cv::Mat grey(3, 5, CV_8U);
  cv::RNG(5).fill(grey, cv::RNG::UNIFORM, 0, 256);
  const std::string bytes = toPgm(grey);
  EXPECT_EQ(cv::norm(fromPgm(bytes, "x"), grey, cv::NORM_INF), 0.0);
  EXPECT_EQ(fromPgm(bytes, "x").type(), CV_8U);
  EXPECT_TRUE(refuses([&] { fromPgm(bytes.substr(0, bytes.size() - 1), "x"); }, {"x", "early"}));
  EXPECT_TRUE(refuses([&] { fromPgm("P6\n1 1\n255\n000", "x"); }, {"graymap"}));
  EXPECT_TRUE(refuses([&] { fromPgm("P5\n99999999 1\n255\n0", "x"); }, {"header"}));
}

TEST(Snapshot, RefusesWhatIsNotOne) {
  const TempDir folder;
  EXPECT_TRUE(refuses([&] { readSnapshot(folder.path("none")); }, {"no folder"}));
  EXPECT_TRUE(refuses([&] { readSnapshot(folder.path("")); }, {"request.yaml"}));
  const std::string path = folder.path("one");
  EXPECT_TRUE(refuses([&] { writeSnapshot(path, example(), {}, {{"../out", "x"}}); }, {"../out"}));
  EXPECT_FALSE(fs::exists(path));
  EXPECT_FALSE(fs::exists(path + ".partial"));
  writeSnapshot(path, example(), {}, {});
  folder.write("one/request.yaml",
               "version: x\nparts: [../../secret.yaml]\nface: any\nmax_parts: 0\n"
               "distance_min: 1.0\ndistance_max: 2.0\n");
  EXPECT_TRUE(refuses([&] { readSnapshot(path); }, {"secret.yaml"}));
  folder.write("one/request.yaml",
               "version: x\nparts: []\nface: any\nmax_parts: 0\ndistance_min: 1.0\n"
               "distance_max: 2.0\nwindow: [0, 0, 2147483647, 1]\n");
  EXPECT_TRUE(refuses([&] { readSnapshot(path); }, {"window"}));
  for (const char* normal : {"[0, 0, 0]", "[0, 0, .nan]", "[0, -1]", "[0, 0, -2]", "up"}) {
    folder.write("one/request.yaml",
                 "version: x\nparts: []\nface: any\nmax_parts: 0\ndistance_min: 1.0\n"
                 "distance_max: 2.0\nfloor_normal: " +
                     std::string(normal) + "\n");
    EXPECT_TRUE(refuses([&] { readSnapshot(path); }, {"floor_normal"})) << normal;
  }
}

TEST(SnapshotRing, KeepsTheLatestAndWhatIsNotItsOwn) {
  const TempDir folder;
  folder.write("mine.txt", "mine");
  constexpr std::uint64_t kMuch = 1u << 30;
  const SnapshotRing ring(folder.path(""), 3, kMuch);
  for (int i = 0; i < 5; ++i) {
    const std::string path = ring.nextPath(1.7e9 + 0.25 * (i / 2), "DEADLOCK");
    EXPECT_FALSE(fs::exists(path));
    writeSnapshot(path, example(), {}, {});
    ring.trim(1.7e9);
  }
  const auto paths = ring.paths();
  ASSERT_EQ(paths.size(), 3u);
  EXPECT_EQ(fs::path(paths[0]).filename(), "20231114_221320.250_DEADLOCK");
  EXPECT_EQ(fs::path(paths[2]).filename(), "20231114_221320.500_DEADLOCK");
  EXPECT_TRUE(fs::exists(folder.path("mine.txt")));
  const SnapshotRing narrow(folder.path(""), 3, 1);  // byte
  narrow.trim(1.7e9);
  EXPECT_EQ(narrow.paths(), std::vector<std::string>{paths[2]});
}

TEST(SnapshotRing, KeepsThemForSoManyHours) {
  const TempDir folder;
  constexpr std::uint64_t kMuch = 1u << 30;
  constexpr double kHour = 3600.0, kStart = 1.7e9;
  const SnapshotRing day(folder.path(""), 100, kMuch, 24.0);
  for (int i = 0; i < 4; ++i)
    writeSnapshot(day.nextPath(kStart + 12.0 * kHour * i, "CALL"), example(), {}, {});
  day.trim(kStart + 24.5 * kHour);
  EXPECT_EQ(day.paths().size(), 3u);
  day.trim(kStart + 1000.0 * kHour);  // the latest is kept whatever its age
  EXPECT_EQ(day.paths().size(), 1u);
  EXPECT_EQ(fs::path(day.paths()[0]).filename().string().substr(0, 8), "20231116");
}

}  // namespace
}  // namespace planar_bin_picking
