// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/regular_file.h"

#include "support/matchers.h"
#include "support/temp_dir.h"

#include <sys/stat.h>

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

TEST(RegularFile, IsReadWhole) {
  const TempDir dir;
  const std::string content("a\r\nb\0c\xff", 7);
  EXPECT_EQ(readRegularFile(dir.write("a.bin", content), 100), content);
  EXPECT_EQ(readRegularFile(dir.write("empty", ""), 100), "");
  EXPECT_EQ(readRegularFile(dir.write("large", std::string(3000000, 'x')), 3000000).size(),
            3000000u);
}

TEST(RegularFile, NothingElseIsOpened) {
  const TempDir dir;
  const auto refused = [](const std::string& path, const std::string& why) {
    return refuses([&] { readRegularFile(path, 100); }, {path, why});
  };
  const std::string pipe = dir.path("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_TRUE(refused(pipe, "no regular file"));  // and does not wait for a writer
  EXPECT_TRUE(refused(dir.path(""), "no regular file"));
  EXPECT_TRUE(refused("/dev/zero", "no regular file"));
  EXPECT_TRUE(refused(dir.path("none"), "No such file"));
}

TEST(RegularFile, HasALimit) {
  const TempDir dir;
  const std::string path = dir.write("a", "12345");
  EXPECT_EQ(readRegularFile(path, 5), "12345");
  EXPECT_TRUE(refuses([&] { readRegularFile(path, 4); }, {path, "5 bytes", "4"}));
}

}  // namespace
}  // namespace planar_bin_picking
