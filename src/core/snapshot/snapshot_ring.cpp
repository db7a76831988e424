// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/snapshot/snapshot_ring.h"

#include "base/atomic_file.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <regex>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

bool isSnapshot(const fs::path& path) {
  static const std::regex kName(R"(\d{8}_\d{6}\.\d{3}_\w+(\.\d+)?)");
  return std::regex_match(path.filename().string(), kName) && fs::exists(path / "request.yaml");
}

std::uint64_t sizeOf(const fs::path& folder) {
  std::uint64_t size = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) size += entry.file_size();
  return size;
}

/// How the names of that second begin.
std::string timeText(const std::time_t seconds) {
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char time[40];
  std::strftime(time, sizeof time, "%Y%m%d_%H%M%S", &utc);
  return time;
}

}  // namespace

SnapshotRing::SnapshotRing(std::string folder, std::size_t count, std::uint64_t bytes,
                           const double hours)
    : folder_(std::move(folder)),
      count_(std::max<std::size_t>(1, count)),
      bytes_(bytes),
      hours_(hours) {
  fs::create_directories(folder_);
  checkWritable(folder_);
}

std::string SnapshotRing::nextPath(double seconds, const std::string& reason) const {
  const auto whole = static_cast<std::time_t>(std::floor(seconds));
  const int thousandths = static_cast<int>((seconds - std::floor(seconds)) * 1000.0);
  char name[80];
  std::snprintf(name, sizeof name, "%.30s.%03d_%.30s", timeText(whole).c_str(), thousandths,
                reason.c_str());
  fs::path path = fs::path(folder_) / name;
  for (int i = 2; fs::exists(path); ++i)
    path = fs::path(folder_) / (std::string(name) + "." + std::to_string(i));
  return path.string();
}

std::vector<std::string> SnapshotRing::paths() const {
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(folder_))
    if (entry.is_directory() && isSnapshot(entry.path())) paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

void SnapshotRing::trim(const double now) const {
  const std::vector<std::string> all = paths();
  constexpr double kSecondsOfHour = 3600.0;
  const std::string oldest =
      hours_ > 0.0 ? timeText(static_cast<std::time_t>(now - kSecondsOfHour * hours_)) : "";
  std::uint64_t size = 0;
  std::size_t kept = 0;
  for (auto path = all.rbegin(); path != all.rend(); ++path) {
    size += sizeOf(*path);
    ++kept;
    const bool is_old = fs::path(*path).filename().string() < oldest;
    if (kept > 1 && (kept > count_ || size > bytes_ || is_old)) fs::remove_all(*path);
  }
}

}  // namespace planar_bin_picking
