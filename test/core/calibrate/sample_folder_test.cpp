// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/sample_folder.h"
#include "support/board_problem.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

SampleSet setOf(std::size_t count) {
  std::mt19937 random(3);
  const sim::BoardCell cell = sim::makeCell(true, &random);
  SampleSet set{randomProblem(cell, 3, &random), "camera: \"left\""};
  set.problem.observations.resize(count);
  return set;
}

/// Adds them one by one, as a run does.
SampleSet fill(const SampleFolder& folder, std::size_t count) {
  const SampleSet all = setOf(count);
  SampleSet set = all;
  set.problem.observations.clear();
  folder.begin();
  for (const Observation& observation : all.problem.observations) {
    const std::string name = SampleFolder::nextName(set);
    set.problem.observations.push_back(observation);
    set.problem.observations.back().name = name;
    folder.add(set, "png " + name);
  }
  return set;
}

TEST(SampleFolder, LoadsWhatWasSaved) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  const SampleSet set = fill(folder, 3);
  const SampleSet loaded = folder.load();
  EXPECT_EQ(loaded.camera_frame, set.camera_frame);
  EXPECT_EQ(loaded.problem.mounting, set.problem.mounting);
  EXPECT_EQ(loaded.problem.board.cols, 9);
  EXPECT_EQ(loaded.problem.board.rows, 6);
  EXPECT_DOUBLE_EQ(loaded.problem.board.square, 0.02);
  EXPECT_EQ(loaded.problem.width, set.problem.width);
  EXPECT_EQ(loaded.problem.height, set.problem.height);
  ASSERT_EQ(loaded.problem.observations.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Observation &a = loaded.problem.observations[i], &b = set.problem.observations[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(isometryNear(a.T_base_flange, b.T_base_flange, 1e-9, 1e-8));
    ASSERT_EQ(a.corners.size(), b.corners.size());
    for (std::size_t k = 0; k < a.corners.size(); ++k) {
      EXPECT_LT((a.corners[k] - b.corners[k]).norm(), 1e-5);
    }
    EXPECT_TRUE(fs::exists(dir.path("out/" + b.name)));
  }
}

TEST(SampleFolder, KeepsPartsOfABoardWithMarkers) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  SampleSet set = fill(folder, 3);
  set.problem.board.kind = Board::Kind::kCharuco;
  set.problem.board.marker = 0.015;
  set.problem.board.dictionary = "DICT_4X4_50";
  Observation& part = set.problem.observations.back();
  part.corners.resize(12);
  part.ids = {0, 1, 2, 3, 9, 10, 11, 12, 18, 19, 20, 21};
  folder.add(set, "png");
  const SampleSet loaded = folder.load();
  EXPECT_EQ(loaded.problem.board, set.problem.board);
  EXPECT_EQ(loaded.problem.observations.back().ids, part.ids);
  EXPECT_EQ(loaded.problem.observations.back().corners.size(), 12u);
  EXPECT_TRUE(loaded.problem.observations.front().ids.empty());
}

TEST(SampleFolder, HasWhatTheToolReads) {
  const TempDir dir;
  const SampleSet set = fill(SampleFolder(dir.path("out")), 2);
  const YAML::Node samples = YAML::LoadFile(dir.path("out/samples.yaml"));
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].size(), 3u);
  EXPECT_EQ(samples[1]["image"].as<std::string>(), "samples/picture_002.png");
  EXPECT_NEAR(samples[1]["position"][2].as<double>(),
              set.problem.observations[1].T_base_flange.translation().z(), 1e-9);
  EXPECT_EQ(samples[1]["orientation"].size(), 4u);
}

TEST(SampleFolder, RemovesOneAndNeverReusesAName) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  SampleSet set = fill(folder, 3);
  set.problem.observations.erase(set.problem.observations.begin() + 1);
  folder.remove(set, "samples/picture_002.png");
  EXPECT_FALSE(fs::exists(dir.path("out/samples/picture_002.png")));
  EXPECT_EQ(folder.load().problem.observations.size(), 2u);
  EXPECT_EQ(YAML::LoadFile(dir.path("out/samples.yaml")).size(), 2u);
  EXPECT_EQ(SampleFolder::nextName(set), "samples/picture_004.png");
  set.problem.observations.clear();
  folder.remove(set, "samples/picture_001.png");
  EXPECT_TRUE(folder.load().problem.observations.empty());
}

TEST(SampleFolder, SetsTheEarlierSetAside) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  fill(folder, 3);
  fill(folder, 1);
  EXPECT_EQ(folder.load().problem.observations.size(), 1u);
  EXPECT_EQ(SampleFolder(dir.path("out/earlier_samples")).load().problem.observations.size(), 3u);
  EXPECT_TRUE(fs::exists(dir.path("out/earlier_samples/samples/picture_003.png")));
  EXPECT_FALSE(fs::exists(dir.path("out/samples/picture_002.png")));
  folder.begin();  // and nothing stale stays
  EXPECT_TRUE(refuses([&] { folder.load(); }, {"corners.yaml"}));
  EXPECT_FALSE(fs::exists(dir.path("out/samples.yaml")));
  EXPECT_EQ(SampleFolder(dir.path("out/earlier_samples")).load().problem.observations.size(), 1u);
}

TEST(SampleFolder, SaysWhatIsWrong) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  fill(folder, 1);
  const std::string path = dir.path("out/corners.yaml");
  std::ifstream in(path);
  const std::string good{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  const auto refused = [&](const std::string& from, const std::string& to,
                           const std::vector<std::string>& words) {
    std::string text = good;
    const auto at = text.find(from);
    if (at == std::string::npos) return testing::AssertionFailure() << "no " << from;
    dir.write("out/corners.yaml", text.replace(at, from.size(), to));
    return refuses([&] { folder.load(); }, words);
  };
  EXPECT_TRUE(refused("eye_in_hand", "in_the_eye", {"corners.yaml", "mounting", "eye_to_hand"}));
  EXPECT_TRUE(refused("board: 9x6", "board: 9x7", {"sample 1", "corners", "126 numbers"}));
  EXPECT_TRUE(refused("image_size", "image_sise", {"image_sise"}));
  const std::string size = "image_size: [" + std::to_string(setOf(0).problem.width);
  for (const char* const width : {"1e12", "0", "-5", "640.5"}) {
    EXPECT_TRUE(refused(size, std::string("image_size: [") + width,
                        {"corners.yaml", "image_size", "width and height in pixels"}));
  }
  EXPECT_TRUE(refused("orientation: [", "orientation: [5, ", {"sample 1", "orientation"}));
  EXPECT_TRUE(refused("position: [", "position: [.nan, ", {"sample 1", "position"}));
}

TEST(SampleFolder, KeepsWhatIsThereWhereTheDiskRefuses) {
  const TempDir dir;
  const SampleFolder folder(dir.path("out"));
  SampleSet set = fill(folder, 2);
  fs::create_directories(dir.path("out/samples/picture_003.png"));  // in the way
  set.problem.observations.push_back(set.problem.observations.back());
  set.problem.observations.back().name = SampleFolder::nextName(setOf(0));
  set.problem.observations.back().name = "samples/picture_003.png";
  EXPECT_TRUE(refuses([&] { folder.add(set, "png"); }, {"picture_003.png"}));
  EXPECT_EQ(folder.load().problem.observations.size(), 2u);
}

}  // namespace
}  // namespace planar_bin_picking
