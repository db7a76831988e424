// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_store.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

namespace planar_bin_picking_ros {
namespace {

namespace fs = std::filesystem;
using planar_bin_picking::refuses;
using planar_bin_picking::TempDir;

const fs::path kBracket = fs::path(PACKAGE_DIR) / "config/parts/bracket.dxf";
constexpr double kPoll = 0.02;  // s

bool comesTrue(const std::function<bool()>& condition) {
  constexpr int kLooks = 1000;
  for (int i = 0; i < kLooks; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

class Store : public testing::Test {
 protected:
  Store() { fs::copy(kBracket, folder_.path("first.dxf")); }
  TempDir folder_;
};

TEST_F(Store, TakesInWhatComesChangesAndGoes) {
  const PartStore store(folder_.path(""), kPoll);
  const auto count = [&] { return store.current()->parts().size(); };
  const auto first = store.current()->select("first").front();
  fs::copy(kBracket, folder_.path("second.dxf"));
  EXPECT_TRUE(comesTrue([&] { return count() == 2; }));
  folder_.write("second.yaml", "drawing: second.dxf\nthickness_mm: 3\n");
  EXPECT_TRUE(comesTrue(
      [&] { return count() == 2 && store.current()->select("second").front()->thickness() > 0; }));
  EXPECT_EQ(store.current()->select("first").front(), first) << "was not touched";
  fs::remove(folder_.path("second.dxf"));
  fs::remove(folder_.path("second.yaml"));
  EXPECT_TRUE(comesTrue([&] { return count() == 1; }));
}

// What the old file said is known to be wrong.
TEST_F(Store, ABrokenFileMakesItsPartUnavailable) {
  const PartStore store(folder_.path(""), kPoll);
  folder_.write("first.dxf", "torn");
  EXPECT_TRUE(comesTrue([&] { return store.current()->errors().count("first") == 1; }));
  EXPECT_TRUE(refuses([&] { store.current()->select("first"); }, {"first.dxf"}));
  fs::copy(kBracket, folder_.path("first.dxf"), fs::copy_options::overwrite_existing);
  EXPECT_TRUE(comesTrue([&] { return store.current()->parts().count("first") == 1; }));
}

TEST_F(Store, KeepsItsPartsWhereTheFolderIsOutOfReach) {
  const fs::path here = folder_.path("parts"), away = folder_.path("away");
  fs::create_directory(here);
  fs::copy(kBracket, here / "first.dxf");
  const PartStore store(here.string(), kPoll);
  fs::rename(here, away);
  EXPECT_TRUE(comesTrue([&] { return !store.trouble().empty(); }));
  EXPECT_EQ(store.current()->parts().size(), 1u);
  fs::rename(away, here);
  EXPECT_TRUE(comesTrue([&] { return store.trouble().empty(); }));
}

TEST_F(Store, LooksOnlyWhenAskedWherePollIsZero) {
  PartStore store(folder_.path(""), 0.0);
  fs::copy(kBracket, folder_.path("second.dxf"));
  folder_.write("bad.dxf", "torn");
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(store.current()->parts().size(), 1u);
  const std::string text = store.reload();
  EXPECT_NE(text.find("2 parts read; not available: bad"), std::string::npos) << text;
  EXPECT_EQ(store.current()->parts().size(), 2u);
}

}  // namespace
}  // namespace planar_bin_picking_ros
