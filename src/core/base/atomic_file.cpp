// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

/// Each step leaves whole files, so that a process that dies, or a computer that loses its power,
/// finds at `path` what was there or what was to come, never a piece of it and never nothing:
///  1. the new content is written to `<path>.new` and flushed to the disk;
///  2. what is at `path` is copied to `<path>.before.new` and flushed. It is a copy and no second
///     name of the same file, since FAT and exFAT have no hard links;
///  3. only when all that is done for all files, names change: `.before.new` to `.before`, then
///     `.new` to `path`, which replaces the old file in one step.
/// A full disk is noticed in 1 and 2, where `path` has not been touched. What fails in 3 is turned
/// back. A power cut within 3, which is a few system calls long, can leave some files new and some
/// old; each of them is whole, and its other version is beside it.
std::string freshOf(const std::string& path) { return path + ".new"; }
std::string beforeOf(const std::string& path) { return path + ".before"; }

[[noreturn]] void fail(const std::string& path, const int reason) {
  throw std::runtime_error(path + ": cannot be written: " + std::strerror(reason) +
                           "; make room on the disk, or choose another folder");
}

/// Where the disk is full, close() may be the one that says it.
int writeAll(const int file, const std::string& content) {
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(file, content.data() + done, content.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    if (written == 0) return EIO;
    done += static_cast<std::size_t>(written);
  }
  return ::fsync(file) == 0 ? 0 : errno;
}

void writeAndFlush(const std::string& path, const std::string& content) {
  // Whatever is there, such as a pipe, which would block: this is always a file of our own.
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) fail(path, errno);
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (file < 0) fail(path, errno);
  int reason = writeAll(file, content);
  if (::close(file) != 0 && reason == 0) reason = errno;
  if (reason != 0) fail(path, reason);
}

/// @throws std::runtime_error  something else than a file is in the way
bool isThere(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    if (errno == ENOENT) return false;
    fail(path, errno);
  }
  if (S_ISREG(status.st_mode)) return true;
  throw std::runtime_error(path + ": is no regular file, and is not replaced; move it away");
}

std::string contentOf(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) throw std::runtime_error(path + ": cannot be read, and is not replaced");
  return content;
}

/// The names in a folder are data of their own. Some file systems cannot flush them, and do it by
/// themselves soon.
void flushFolderOf(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int file = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

/// One file on its way to its name.
struct Step {
  std::string path;
  bool had_old = false, is_renamed = false;
};

void turnBack(const std::vector<Step>& steps, const RenameFile& rename_file) {
  for (const Step& step : steps) {
    if (step.is_renamed && step.had_old) {
      rename_file(beforeOf(step.path).c_str(), step.path.c_str());
    } else if (step.is_renamed) {
      ::unlink(step.path.c_str());
    }
    ::unlink(freshOf(step.path).c_str());
    ::unlink(freshOf(beforeOf(step.path)).c_str());
  }
}

}  // namespace

void writeTogether(const std::vector<NamedContent>& files, const RenameFile& rename_file) {
  const auto rename = [&rename_file](const std::string& from, const std::string& to) {
    if (rename_file(from.c_str(), to.c_str()) != 0) fail(to, errno);
  };
  std::vector<Step> steps;
  try {
    for (const NamedContent& file : files) {
      steps.push_back({file.path, isThere(file.path), false});
      writeAndFlush(freshOf(file.path), file.content);
      if (steps.back().had_old) {
        writeAndFlush(freshOf(beforeOf(file.path)), contentOf(file.path));
      }
    }
    for (const Step& step : steps) {
      if (step.had_old) rename(freshOf(beforeOf(step.path)), beforeOf(step.path));
    }
    for (Step& step : steps) {
      rename(freshOf(step.path), step.path);
      step.is_renamed = true;
    }
  } catch (const std::exception&) {
    turnBack(steps, rename_file);
    throw;
  }
  for (const Step& step : steps) flushFolderOf(step.path);
}

void checkWritable(const std::string& folder) {
  const std::string path = folder + "/.writable";
  writeAndFlush(path, "x");
  ::unlink(path.c_str());
}

}  // namespace planar_bin_picking
