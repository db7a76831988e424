// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hand_eye/calibration_age.h"

#include <yaml-cpp/yaml.h>

#include <sys/stat.h>

#include <ctime>
#include <filesystem>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace planar_bin_picking_ros {
namespace {

constexpr double kSecondsOfDay = 86400.0;

/// The first of these files that has the key; "" where none has.
std::string valueOf(const std::vector<std::string>& paths, const std::string& key) {
  for (const std::string& path : paths) {
    if (!std::filesystem::exists(path)) continue;
    try {
      const YAML::Node root = YAML::LoadFile(path);
      if (root.IsMap() && root[key].IsDefined()) return root[key].as<std::string>();
    } catch (const YAML::Exception& error) {
      throw std::runtime_error(path + ": " + key + " cannot be read: " + error.what());
    }
  }
  return "";
}

/// Seconds since 1970 of "2026-11-26T18:00:00Z".
std::time_t secondsOf(const std::string& date, const std::string& path) {
  std::tm utc{};
  if (strptime(date.c_str(), "%Y-%m-%dT%H:%M:%S", &utc) == nullptr) {
    throw std::runtime_error(path + ": date is \"" + date +
                             "\", must be as 2026-11-26T18:00:00Z; calibrate anew");
  }
  return timegm(&utc);
}

std::time_t writtenAt(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) throw std::runtime_error(path + ": is not there");
  return status.st_mtime;
}

/// The file itself, and what the calibrator writes beside it.
std::vector<std::string> filesOf(const std::string& path) {
  return {path, (std::filesystem::path(path).parent_path() / "calibration.yaml").string()};
}

double daysSinceMade(const std::string& path) {
  const std::string date = valueOf(filesOf(path), "date");
  const std::time_t made = date.empty() ? writtenAt(path) : secondsOf(date, path);
  return std::difftime(std::time(nullptr), made) / kSecondsOfDay;
}

}  // namespace

CalibrationAge calibrationAge(const std::string& path) {
  return {valueOf(filesOf(path), "verdict"), daysSinceMade(path)};
}

void checkUsable(const std::string& path, bool accept_poor, double max_age_days) {
  const std::vector<std::string> files = filesOf(path);
  const std::string verdict = valueOf(files, "verdict");
  // Where the machine went down between the two, the file itself may still say GOOD.
  if (verdict == "REFUSED" || valueOf({files.back()}, "verdict") == "REFUSED") {
    throw std::runtime_error(path +
                             ": the calibration was REFUSED (see report.html beside it), and "
                             "this file is older; calibrate anew");
  }
  if (verdict == "POOR" && !accept_poor) {
    throw std::runtime_error(path +
                             ": the calibration is POOR, see report.html beside it; improve "
                             "it, or set accept_poor_calibration (~accept_poor)");
  }
  if (!(max_age_days > 0.0)) return;
  const double days = daysSinceMade(path);
  if (days <= max_age_days) return;
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(3);
  text << path << ": the calibration is " << days << " days old, allowed are " << max_age_days
       << "; hold it against the cell by the calibrator's ~verify, calibrate anew, or raise "
          "calibration_max_age_days (~max_age_days)";
  throw std::runtime_error(text.str());
}

}  // namespace planar_bin_picking_ros
