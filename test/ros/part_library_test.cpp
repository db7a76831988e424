// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part_library.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <filesystem>

namespace planar_bin_picking_ros {
namespace {

namespace fs = std::filesystem;
using planar_bin_picking::refuses;
using planar_bin_picking::TempDir;

const fs::path kBracket = fs::path(PACKAGE_DIR) / "config/parts/bracket.dxf";

std::vector<std::string> names(const std::vector<PartPtr>& parts) {
  std::vector<std::string> result;
  for (const auto& part : parts) result.push_back(part->name());
  return result;
}

TEST(PartLibrary, DrawingAloneIsAPart) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("Angle.DXF"));
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("Angle")), std::vector<std::string>{"Angle"});
}

// The drawing that a yaml names is that part, and not one more of the same shape.
TEST(PartLibrary, YamlTakesItsDrawing) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("drawing_7.dxf"));
  folder.write("angle.yaml", "drawing: drawing_7.dxf\nthickness_mm: 3\n");
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("")), std::vector<std::string>{"angle"});
}

TEST(PartLibrary, BadPartDoesNotHinderOthers) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("good.dxf"));
  folder.write("bad.dxf", "this is no drawing");
  folder.write("worse.yaml", "drawing: missing.dxf\n");
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("")), std::vector<std::string>{"good"});
  EXPECT_TRUE(refuses([&] { library.select("bad"); }, {"bad.dxf"}));
  EXPECT_TRUE(refuses([&] { library.select("worse"); }, {"missing.dxf"}));
  EXPECT_TRUE(refuses([&] { library.select("other"); }, {"other", "good"}));
}

TEST(PartLibrary, RefusesFolderWithoutParts) {
  const TempDir folder;
  EXPECT_TRUE(refuses([&] { PartLibrary(folder.path("")); }, {"neither"}));
  EXPECT_TRUE(refuses([&] { PartLibrary(folder.path("none")); }, {"none"}));
}

}  // namespace
}  // namespace planar_bin_picking_ros
