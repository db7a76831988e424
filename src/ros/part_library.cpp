// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part_library.h"

#include "planar_bin_picking/part_file.h"
#include "refusal.h"

#include <planar_bin_picking/LocatePart.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>

namespace planar_bin_picking_ros {

namespace fs = std::filesystem;
using planar_bin_picking::LocatePart;
using planar_bin_picking::PartModel;

namespace {

std::string extension(const fs::path& path) {
  std::string text = path.extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](const unsigned char c) { return std::tolower(c); });
  return text;
}

bool isYaml(const fs::path& path) {
  return extension(path) == ".yaml" || extension(path) == ".yml";
}

/// The drawing that a part's yaml names. A yaml that cannot be read claims none: loading the part
/// itself reports what is wrong with it.
fs::path claimedDrawing(const fs::path& yaml) {
  try {
    const YAML::Node drawing = YAML::LoadFile(yaml.string())["drawing"];
    if (drawing) return (yaml.parent_path() / drawing.as<std::string>()).lexically_normal();
  } catch (const YAML::Exception&) {
  }
  return {};
}

/// Part name -> the file to load it from.
std::map<std::string, fs::path> findParts(const fs::path& folder) {
  std::vector<fs::path> yamls, drawings;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (isYaml(entry.path())) yamls.push_back(entry.path());
    if (extension(entry.path()) == ".dxf") drawings.push_back(entry.path());
  }
  std::map<std::string, fs::path> files;
  std::set<fs::path> claimed;
  for (const auto& yaml : yamls) {
    files[yaml.stem().string()] = yaml;
    claimed.insert(claimedDrawing(yaml));
  }
  for (const auto& drawing : drawings) {
    if (claimed.count(drawing.lexically_normal()) == 0)
      files.emplace(drawing.stem().string(), drawing);
  }
  return files;
}

template <class Map>
std::string names(const Map& map) {
  std::string text;
  for (const auto& entry : map) text += (text.empty() ? "" : ", ") + entry.first;
  return text.empty() ? "none" : text;
}

[[noreturn]] void refuse(const std::string& message) {
  throw Refusal(LocatePart::Response::UNKNOWN_PART, message);
}

}  // namespace

PartLibrary::PartLibrary(const std::string& folder) : folder_(folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw std::runtime_error("parts folder '" + folder + "' is not a folder that can be read");
  }
  const auto files = findParts(folder);
  if (files.empty()) {
    throw std::runtime_error("parts folder '" + folder + "' has neither *.dxf nor *.yaml in it");
  }
  for (const auto& [name, file] : files) {
    try {
      parts_[name] =
          std::make_shared<const PartModel>(planar_bin_picking::loadPartFile(file.string()));
    } catch (const std::exception& failure) {
      errors_[name] = failure.what();
    }
  }
}

std::vector<PartPtr> PartLibrary::select(const std::string& name) const {
  std::vector<PartPtr> selected;
  if (name.empty()) {
    for (const auto& entry : parts_) selected.push_back(entry.second);
    if (selected.empty())
      refuse("none of the parts in " + folder_ + " could be loaded: " + names(errors_));
    return selected;
  }
  const auto found = parts_.find(name);
  if (found != parts_.end()) return {found->second};
  const auto error = errors_.find(name);
  if (error != errors_.end()) {
    refuse("part '" + name + "' could not be loaded: " + error->second +
           "; correct the file and restart the node");
  }
  refuse("there is no part '" + name + "' in " + folder_ + " (there is: " + names(parts_) +
         "); add its drawing and restart the node");
}

}  // namespace planar_bin_picking_ros
