// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/atomic_file.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::size_t filesIn(const std::string& folder) {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

std::string failureOf(const std::vector<NamedContent>& files) {
  try {
    writeTogether(files);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// Runs in a process of its own, whose limits and rights it may change. @return  its exit status
int inChild(const std::function<int()>& act) {
  const pid_t child = fork();
  if (child == 0) _exit(act());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

class AtomicFile : public testing::Test {
 protected:
  std::vector<NamedContent> set(const std::string& mark) const {
    return {{dir_.path("a"), mark + std::string(3000, 'a')},
            {dir_.path("b"), mark + "b"},
            {dir_.path("c"), mark + std::string(6000, 'c')}};
  }

  /// The mark of all files; "mixed" where they differ or are not whole.
  std::string mark() const {
    for (const char* mark : {"old", "new", "newest"}) {
      bool all = true;
      for (const NamedContent& file : set(mark)) all = all && read(file.path) == file.content;
      if (all) return mark;
    }
    return "mixed";
  }

  TempDir dir_;
};

TEST_F(AtomicFile, ReplacesAllAndKeepsTheFormer) {
  writeTogether(set("old"));
  EXPECT_EQ(mark(), "old");
  EXPECT_EQ(filesIn(dir_.path("")), 3u);
  writeTogether(set("new"));
  EXPECT_EQ(mark(), "new");
  writeTogether(set("newest"));
  EXPECT_EQ(mark(), "newest");
  for (const NamedContent& file : set("new")) EXPECT_EQ(read(file.path + ".before"), file.content);
  EXPECT_EQ(filesIn(dir_.path("")), 6u);
}

TEST_F(AtomicFile, MakesNoSecondNameOfAFile) {
  writeTogether(set("old"));
  writeTogether(set("new"));
  for (const NamedContent& file : set("")) {
    struct stat status {};
    ASSERT_EQ(stat((file.path + ".before").c_str(), &status), 0);
    EXPECT_EQ(status.st_nlink, 1u);
  }
}

// A file system that is full is one on which files cannot grow beyond a size, whichever it is.
TEST_F(AtomicFile, FullDiskLeavesTheFormerSet) {
  writeTogether(set("old"));
  int failed = 0;
  for (const rlim_t limit : {0, 1, 2, 1000, 3002, 3003, 3004, 5000, 6002}) {
    const int status = inChild([&] {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit size{limit, limit};
      if (setrlimit(RLIMIT_FSIZE, &size) != 0) return 2;
      const std::string said = failureOf(set("new"));
      return said.find("cannot be written: File too large") == std::string::npos ? 1 : 0;
    });
    EXPECT_EQ(status, 0) << limit;
    EXPECT_EQ(mark(), "old") << limit;
    EXPECT_EQ(filesIn(dir_.path("")), 3u) << limit;
    ++failed;
  }
  EXPECT_EQ(failed, 9);
  EXPECT_EQ(failureOf(set("new")), "");
  EXPECT_EQ(mark(), "new");
}

// Wherever the renaming breaks off.
TEST_F(AtomicFile, FailingRenameIsTurnedBack) {
  writeTogether(set("old"));
  for (int good = 0; good < 6; ++good) {
    int calls = 0;
    const auto rename_file = [&](const char* from, const char* to) {
      if (calls++ == good) {
        errno = EROFS;
        return -1;
      }
      return std::rename(from, to);
    };
    EXPECT_THROW(writeTogether(set("new"), rename_file), std::runtime_error);
    EXPECT_EQ(mark(), "old") << good;
    EXPECT_FALSE(std::filesystem::exists(dir_.path("a.new")));
    EXPECT_FALSE(std::filesystem::exists(dir_.path("c.before.new")));
  }
}

TEST_F(AtomicFile, FailingRenameOfTheFirstSetLeavesNothing) {
  int calls = 0;
  const auto rename_file = [&](const char* from, const char* to) {
    return ++calls == 3 ? -1 : std::rename(from, to);
  };
  EXPECT_THROW(writeTogether(set("new"), rename_file), std::runtime_error);
  EXPECT_EQ(filesIn(dir_.path("")), 0u);
}

TEST_F(AtomicFile, PipeWhereItWritesDoesNotHang) {
  ASSERT_EQ(mkfifo(dir_.path("a.new").c_str(), 0600), 0);
  ASSERT_EQ(mkfifo(dir_.path("b.before").c_str(), 0600), 0);
  writeTogether(set("old"));
  writeTogether(set("new"));
  EXPECT_EQ(mark(), "new");
}

TEST_F(AtomicFile, RefusesWhatIsNoFile) {
  ASSERT_EQ(mkfifo(dir_.path("b").c_str(), 0600), 0);
  EXPECT_NE(failureOf(set("new")).find("b: is no regular file"), std::string::npos);
  EXPECT_EQ(filesIn(dir_.path("")), 1u);
  std::filesystem::remove(dir_.path("b"));
  std::filesystem::create_directory(dir_.path("c"));
  EXPECT_NE(failureOf(set("new")).find("c: is no regular file"), std::string::npos);
}

TEST_F(AtomicFile, SaysWhyAFolderCannotBeWritten) {
  std::filesystem::permissions(dir_.path(""), std::filesystem::perms(0555));
  const int status = inChild([&] {
    if (geteuid() == 0 && seteuid(65534) != 0) return 2;  // the superuser may write everywhere
    const bool said = failureOf(set("new")).find("Permission denied") != std::string::npos;
    try {
      checkWritable(dir_.path(""));
    } catch (const std::runtime_error& error) {
      return std::string(error.what()).find("Permission denied") != std::string::npos && said ? 0
                                                                                              : 1;
    }
    return 3;
  });
  std::filesystem::permissions(dir_.path(""), std::filesystem::perms(0755));
  EXPECT_EQ(status, 0);
  EXPECT_NO_THROW(checkWritable(dir_.path("")));
  EXPECT_EQ(filesIn(dir_.path("")), 0u);
}

}  // namespace
}  // namespace planar_bin_picking
