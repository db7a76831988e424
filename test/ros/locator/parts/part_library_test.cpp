// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_library.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

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
  EXPECT_TRUE(refuses([&] { library.select("drawing_7"); }, {"drawing_7", "part 'angle'"}));
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

// A directory cannot be read, and who opens a FIFO waits for ever.
TEST(PartLibrary, OpensRegularFilesAlone) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("good.dxf"));
  fs::create_directory(folder.path("directory.yaml"));
  fs::create_directory(folder.path("folder.dxf"));
  ASSERT_EQ(mkfifo(folder.path("pipe.yaml").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(folder.path("pipe_drawing.dxf").c_str(), 0600), 0);
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("")), std::vector<std::string>{"good"});
  for (const char* name : {"directory", "folder", "pipe", "pipe_drawing"})
    EXPECT_TRUE(refuses([&] { library.select(name); }, {name, "regular file"})) << name;
}

TEST(PartLibrary, StaysInItsFolder) {
  const TempDir outside, folder;
  outside.write("secret.yaml", "password: swordfish\n");
  fs::copy(kBracket, outside.path("far.dxf"));
  fs::create_symlink(outside.path("secret.yaml"), folder.path("secret.yaml"));
  fs::create_symlink(outside.path("far.dxf"), folder.path("far.dxf"));
  folder.write(
      "escaped.yaml",
      "drawing: " + fs::relative(outside.path("far.dxf"), folder.path("")).string() + "\n");
  fs::copy(kBracket, folder.path("good.dxf"));
  fs::create_symlink(folder.path("good.dxf"), folder.path("alias.dxf"));
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("")), (std::vector<std::string>{"alias", "good"}));
  EXPECT_TRUE(refuses([&] { library.select("far"); }, {"link out of the parts folder"}));
  EXPECT_TRUE(refuses([&] { library.select("escaped"); }, {"out of the folder"}));
  EXPECT_TRUE(refuses([&] { library.select("secret"); }, {"secret.yaml"}));
  EXPECT_EQ(library.errors().at("secret").find("swordfish"), std::string::npos);
}

// Results and other files that lie about are no parts, and it is said why.
TEST(PartLibrary, TellsWhatIsNoPartsFile) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("good.dxf"));
  folder.write("result.yaml", "seconds: 0.4\ndetections: []\n");
  folder.write("list.yaml", "- 1\n- 2\n");
  folder.write("empty.yaml", "");
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("")), std::vector<std::string>{"good"});
  for (const char* name : {"result", "list", "empty"})
    EXPECT_TRUE(refuses([&] { library.select(name); }, {std::string(name) + ".yaml"})) << name;
}

TEST(PartLibrary, RefusesFolderWithoutParts) {
  const TempDir folder;
  EXPECT_TRUE(refuses([&] { PartLibrary(folder.path("")); }, {"neither"}));
  EXPECT_TRUE(refuses([&] { PartLibrary(folder.path("none")); }, {"none"}));
}

TEST(PartLibrary, SeveralNamesCountOnceEach) {
  const TempDir folder;
  for (const char* name : {"a.dxf", "b.dxf", "c.dxf"}) fs::copy(kBracket, folder.path(name));
  const PartLibrary library(folder.path(""));
  EXPECT_EQ(names(library.select("", {"c", "a", "c"})), (std::vector<std::string>{"a", "c"}));
  EXPECT_EQ(names(library.select("a", {"a", "b"})), (std::vector<std::string>{"a", "b"}));
  EXPECT_TRUE(refuses([&] { library.select("a", {"d"}); }, {"no part 'd'"}));
}

TEST(PartLibrary, SharesWhatHasNotChanged) {
  const TempDir folder;
  for (const char* name : {"same.dxf", "other.dxf"}) fs::copy(kBracket, folder.path(name));
  folder.write("late.yaml", "drawing: late_drawing.dxf\n");
  const PartLibrary before(folder.path(""));
  EXPECT_TRUE(refuses([&] { before.select("late"); }, {"late_drawing.dxf"}));
  folder.write("other.yaml", "drawing: other.dxf\nthickness_mm: 3\n");
  fs::copy(kBracket, folder.path("late_drawing.dxf"));
  EXPECT_NE(stampsIn(before.folder(), before.paths()), before.stamps());
  constexpr bool kAllAnew = true;
  const PartLibrary after(before, !kAllAnew);
  EXPECT_EQ(after.parts().at("same"), before.parts().at("same"));
  EXPECT_EQ(after.readAt("same"), before.readAt("same"));
  EXPECT_DOUBLE_EQ(after.select("other").front()->thickness(), 0.003);
  EXPECT_EQ(names(after.select("late")), std::vector<std::string>{"late"});
  EXPECT_EQ(stampsIn(after.folder(), after.paths()), after.stamps());
  const PartLibrary anew(after, kAllAnew);
  EXPECT_NE(anew.parts().at("same"), after.parts().at("same"));
}

TEST(PartLibrary, MayBecomeEmptyLater) {
  const TempDir folder;
  fs::copy(kBracket, folder.path("only.dxf"));
  const PartLibrary before(folder.path(""));
  fs::remove(folder.path("only.dxf"));
  const PartLibrary after(before, false);
  EXPECT_TRUE(refuses([&] { after.select(""); }, {"is empty"}));
  EXPECT_EQ(before.select("").size(), 1u) << "a call that began before goes on with what it has";
}

}  // namespace
}  // namespace planar_bin_picking_ros
