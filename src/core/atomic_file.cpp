// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

[[noreturn]] void fail(const std::string& path) {
  throw std::runtime_error(path + ": cannot be written: " + std::strerror(errno));
}

void writeAndFlush(const std::string& path, const std::string& content) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) fail(path);
  std::size_t done = 0;
  while (done < content.size()) {
    const ssize_t written = ::write(file, content.data() + done, content.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int reason = errno;
      ::close(file);
      ::unlink(path.c_str());
      errno = reason;
      fail(path);
    }
    done += static_cast<std::size_t>(written);
  }
  const bool flushed = ::fsync(file) == 0;
  if (::close(file) != 0 || !flushed) fail(path);
}

}  // namespace

void writeAtomically(const std::string& path, const std::string& content) {
  const std::string fresh = path + ".new", before = path + ".before";
  writeAndFlush(fresh, content);
  // A second name for the old file, so that at no moment there is none at `path`.
  if (::access(path.c_str(), F_OK) == 0) {
    ::unlink(before.c_str());
    if (::link(path.c_str(), before.c_str()) != 0) fail(before);
  }
  if (std::rename(fresh.c_str(), path.c_str()) != 0) fail(path);
}

}  // namespace planar_bin_picking
