// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/yaml_file.h"

#include "support/comma_locale.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>

namespace planar_bin_picking {
namespace {

class YamlFile : public testing::Test {
 protected:
  testing::AssertionResult refused(const std::string& text, std::vector<std::string> words) {
    words.push_back("file.yaml");
    return refuses([&] { loadYaml(dir_.write("file.yaml", text)); }, words);
  }
  YAML::Node load(const std::string& text) { return loadYaml(dir_.write("file.yaml", text)); }

  TempDir dir_;
};

std::string repeated(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

TEST_F(YamlFile, ReadsMapsAndLists) {
  EXPECT_EQ(valueAs<int>(load("a: {b: [1, 2, 3]}\n")["a"]["b"][2], "", "b", ""), 3);
  EXPECT_TRUE(load("- 1\n- 2\n").IsSequence());
  EXPECT_TRUE(refuses([&] { loadYamlMap(dir_.write("file.yaml", "- 1\n")); }, {"key: value"}));
  EXPECT_TRUE(refuses([&] { loadYamlMap(dir_.write("file.yaml", "a: 1\na: 2\n")); }, {"twice"}));
  EXPECT_TRUE(refused("a: [1\n", {"not valid YAML", "line 2"}));
}

TEST_F(YamlFile, AliasesAreFollowed) {
  const YAML::Node root = load("a: &it {x: 0.5}\nb: *it\nc: [*it, *it]\n");
  EXPECT_EQ(valueAs<double>(root["c"][1]["x"], "", "x", ""), 0.5);
}

TEST_F(YamlFile, RefusesWhatStandsWithinItself) {
  EXPECT_TRUE(refused("a: &it {b: *it}\n", {"alias"}));
  EXPECT_TRUE(refused("&it [1, *it]\n", {"alias"}));
  EXPECT_TRUE(refused("&it {? *it : 1}\n", {"alias"}));
}

TEST_F(YamlFile, RefusesAliasesThatMultiply) {
  std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 20; ++i) {
    const std::string before = "*a" + std::to_string(i - 1), name = "a" + std::to_string(i);
    text += name + ": &" + name + " [" + repeated(before + ", ", 9) + before + "]\n";
  }
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(refused(text, {"more than 200000 values"}));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_LT(took.count(), 5.0);
}

TEST_F(YamlFile, RefusesDepthBeforeItIsRead) {
  for (const int levels : {40, 200000}) {
    EXPECT_TRUE(refused(repeated("[", levels), {"deeper than 32"})) << levels;
    EXPECT_TRUE(refused(repeated("{a: ", levels), {"deeper than 32"})) << levels;
    EXPECT_TRUE(refused(repeated("- ", levels) + "x\n", {"deeper than 32"})) << levels;
    EXPECT_TRUE(refused(repeated("? ", levels) + "x\n", {"deeper than 32"})) << levels;
    // Brackets that only seem to close.
    EXPECT_TRUE(refused(repeated("[']', ", levels), {"deeper than 32"})) << levels;
    EXPECT_TRUE(refused(repeated("[\"\\\"]\", ", levels), {"deeper than 32"})) << levels;
    EXPECT_TRUE(refused(repeated("[ # ]\n", levels), {"deeper than 32"})) << levels;
  }
  std::string map;
  for (int i = 0; i < 300; ++i) map += std::string(i, ' ') + "a:\n";
  EXPECT_TRUE(refused(map, {"deeper than 32"}));
  // A sequence may stand at the column of its key.
  map.clear();
  for (int i = 0; i < 40; ++i) map += std::string(i, ' ') + "a:\n" + std::string(i, ' ') + "-\n";
  EXPECT_TRUE(refused(map, {"file.yaml"}));
}

TEST_F(YamlFile, TakesWhatOnlyLooksDeep) {
  EXPECT_EQ(load("# " + repeated("[", 100) + "\na: '" + repeated("{", 100) + "'\n").size(), 1u);
  EXPECT_EQ(load("a: \"\\\"" + repeated("[", 100) + "\"\n").size(), 1u);
  EXPECT_EQ(load(repeated("- [a, {b: c}]\n", 100)).size(), 100u);
  EXPECT_EQ(load("it's: [1]\n" + repeated("- x\n", 0) + "b: it's\nc: [2]\n").size(), 3u);
  EXPECT_EQ(load("# ------------------------------------------------------------------------------"
                 "-------------------------\na: 1\n")
                .size(),
            1u);
  EXPECT_EQ(load(repeated("[", 30) + repeated("]", 30)).size(), 1u);
}

TEST_F(YamlFile, RefusesWhatIsNoRegularFileOrTooLarge) {
  EXPECT_TRUE(refuses([&] { loadYaml(dir_.path("none.yaml")); }, {"none.yaml", "cannot be read"}));
  EXPECT_TRUE(refuses([&] { loadYaml(dir_.path("")); }, {"no regular file"}));
  ASSERT_EQ(mkfifo(dir_.path("pipe.yaml").c_str(), 0600), 0);
  EXPECT_TRUE(refuses([&] { loadYaml(dir_.path("pipe.yaml")); }, {"pipe.yaml", "no regular file"}));
  EXPECT_TRUE(refused("a: " + std::string(3u << 20, 'x'), {"bytes"}));
}

TEST_F(YamlFile, MessagesStayShort) {
  const std::string key(100000, 'k');
  const auto said = [](const auto& call) {
    try {
      call();
    } catch (const std::runtime_error& e) {
      return std::string(e.what());
    }
    return std::string(1000, 'x');
  };
  EXPECT_LT(said([&] { refuseUnknownKeys(load(key + ": 1\n"), "f", {"a"}); }).size(), 200u);
  EXPECT_LT(said([&] { refuseRepeatedKeys(load(key + ": 1\n" + key + ": 1\n"), "f"); }).size(),
            200u);
  EXPECT_LT(said([&] { valueAs<int>(load("a: " + key)["a"], "f", "a", "b"); }).size(), 200u);
}

TEST_F(YamlFile, ReadsPointsInEveryLocale) {
  const CommaLocale commas;
  const YAML::Node root = load("a: 0.5\nb: 1000\nc: 0,5\nd: 1.000,5\n");
  EXPECT_EQ(valueAs<double>(root["a"], "", "a", ""), 0.5);
  EXPECT_EQ(valueAs<int>(root["b"], "", "b", ""), 1000);
  EXPECT_TRUE(refuses([&] { valueAs<double>(root["c"], "f", "c", "a number"); }, {"0,5"}));
  EXPECT_TRUE(refuses([&] { valueAs<double>(root["d"], "f", "d", "a number"); }, {"1.000,5"}));
}

TEST_F(YamlFile, ReadsPoses) {
  const double h = std::sqrt(0.5);
  const Eigen::Isometry3d T = poseIn(
      load("position: [0.1, -0.2, 0.3]\norientation: [0, 0, 0.70710678, 0.70710678]\n"), "f");
  EXPECT_TRUE(T.translation().isApprox(Eigen::Vector3d(0.1, -0.2, 0.3)));
  EXPECT_TRUE(T.linear().isApprox(Eigen::Quaterniond(h, 0.0, 0.0, h).toRotationMatrix(),
                                  1e-7));  // as many digits as written
  const auto refusesPose = [&](const std::string& position, const std::string& orientation) {
    const std::string text = "position: " + position + "\norientation: " + orientation + "\n";
    const std::string wrong = position == "[0, 0, 0]" ? "orientation" : "position";
    return refuses([&] { poseIn(load(text), "f: sample 1"); }, {"f: sample 1", wrong});
  };
  EXPECT_TRUE(refusesPose("[0, 0]", "[0, 0, 0, 1]"));
  EXPECT_TRUE(refusesPose("[0, .nan, 0]", "[0, 0, 0, 1]"));
  EXPECT_TRUE(refusesPose("[0, 0, 0]", "[0, 0, 0]"));
  EXPECT_TRUE(refusesPose("[0, 0, 0]", "[0, 0, 0, 1.01]"));
  EXPECT_TRUE(refusesPose("[0, 0, 0]", "[0, 0, 0, 0]"));
}

}  // namespace
}  // namespace planar_bin_picking
