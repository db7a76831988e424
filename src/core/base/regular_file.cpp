// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/regular_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

namespace planar_bin_picking {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

std::string reasonOf(int error) { return std::generic_category().message(error); }

/// A file that is open for reading, closed at the end.
class OpenFile {
 public:
  explicit OpenFile(const std::string& path) : path_(path) {
    // Opening a device may already do something to it, so look before; the look after is the one
    // that counts, since the name may have been given to something else in between. O_NONBLOCK: a
    // pipe without a writer would block here.
    struct stat before;
    if (stat(path.c_str(), &before) == 0 && !S_ISREG(before.st_mode)) refuseKind();
    descriptor_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) {
      refuse(path, "cannot be read (" + reasonOf(errno) + "); check the path and its permissions");
    }
    if (fstat(descriptor_, &status_) == 0 && S_ISREG(status_.st_mode)) return;
    close(descriptor_);
    refuseKind();
  }
  ~OpenFile() { close(descriptor_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  std::size_t size() const { return static_cast<std::size_t>(status_.st_size); }

  /// Up to the given number of bytes; fewer only at the file's end.
  std::string read(std::size_t bytes) const {
    std::string content(bytes, '\0');
    std::size_t filled = 0;
    while (filled < bytes) {
      const ssize_t got = ::read(descriptor_, &content[filled], bytes - filled);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) refuse(path_, "cannot be read (" + reasonOf(errno) + ")");
      if (got == 0) break;
      filled += static_cast<std::size_t>(got);
    }
    content.resize(filled);
    return content;
  }

 private:
  [[noreturn]] void refuseKind() const {
    refuse(path_, "is no regular file but a folder, a pipe or a device; give the path of a file");
  }

  std::string path_;
  int descriptor_ = -1;
  struct stat status_ = {};
};

}  // namespace

std::string readRegularFile(const std::string& path, std::size_t bytes_max) {
  const OpenFile file(path);
  const auto refuseSize = [&](std::size_t size) {
    refuse(path, "has " + std::to_string(size) + " bytes or more, allowed are " +
                     std::to_string(bytes_max) + "; is it the right file?");
  };
  if (file.size() > bytes_max) refuseSize(file.size());
  // One byte more than there was: a file that grows meanwhile must not pass for a whole one.
  std::string content = file.read(file.size() + 1);
  if (content.size() > bytes_max) refuseSize(content.size());
  return content;
}

}  // namespace planar_bin_picking
