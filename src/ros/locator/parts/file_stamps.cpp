// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/file_stamps.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

namespace planar_bin_picking_ros {

namespace fs = std::filesystem;

namespace {

std::string extension(const std::string& path) {
  std::string text = fs::path(path).extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](const unsigned char c) { return std::tolower(c); });
  return text;
}

std::int64_t nanoseconds(const timespec& time) {
  constexpr std::int64_t kPerSecond = 1000000000;
  return static_cast<std::int64_t>(time.tv_sec) * kPerSecond + time.tv_nsec;
}

}  // namespace

bool isPartYaml(const std::string& path) {
  return extension(path) == ".yaml" || extension(path) == ".yml";
}

bool isDrawing(const std::string& path) { return extension(path) == ".dxf"; }

FileStamp stampOf(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  return {static_cast<std::uint64_t>(status.st_size), static_cast<std::uint64_t>(status.st_ino),
          nanoseconds(status.st_mtim), nanoseconds(status.st_ctim)};
}

FileStamps stampsIn(const std::string& folder, const std::set<std::string>& also) {
  FileStamps stamps;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string path = entry.path().lexically_normal().string();
    if (isPartYaml(path) || isDrawing(path)) stamps[path] = stampOf(path);
  }
  for (const std::string& path : also) stamps[path] = stampOf(path);
  return stamps;
}

}  // namespace planar_bin_picking_ros
