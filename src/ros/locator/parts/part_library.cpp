// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_library.h"

#include "planar_bin_picking/part/part_file.h"
#include "planar_bin_picking/part/part_model.h"
#include "shared/refusal.h"

#include <planar_bin_picking/LocatePart.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace planar_bin_picking_ros {

namespace fs = std::filesystem;
using planar_bin_picking::LocatePart;
using planar_bin_picking::PartModel;

namespace {

/// Follows links; false where they lead nowhere or out of the folder.
bool isWithin(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error) return false;
  const fs::path inside = real.lexically_relative(fs::canonical(folder, error));
  return !error && !inside.empty() && *inside.begin() != "..";
}

/// Why a file of the folder is not even opened; "" where it may be.
std::string whyNotOpened(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  // A directory cannot be read, and a FIFO or a device might never end.
  if (!fs::is_regular_file(path, error)) return path.string() + ": is no regular file";
  if (isWithin(folder, path)) return "";
  return path.string() + ": is a link out of the parts folder; copy the file into it";
}

struct Found {
  std::map<std::string, fs::path> files;      ///< part name -> the file to load it from
  std::map<std::string, std::string> errors;  ///< part name -> why it has none
  std::map<std::string, std::string>
      owners;  ///< drawing that is no part itself -> part that has it
};

/// Parts in yaml files, and the drawings that these name. What else is wrong with a file, loading
/// it says.
void findYamlParts(const fs::path& folder, const std::vector<fs::path>& yamls,
                   std::map<fs::path, std::string>* claimed, Found* found) {
  for (const fs::path& yaml : yamls) {
    const std::string name = yaml.stem().string();
    std::string error = whyNotOpened(folder, yaml);
    if (error.empty()) {
      const auto drawing = planar_bin_picking::drawingNamedBy(yaml.string());
      if (drawing) claimed->emplace(*drawing, name);
    }
    if (error.empty()) {
      found->files[name] = yaml;
    } else {
      found->errors[name] = error;
    }
  }
}

Found findParts(const fs::path& folder) {
  std::vector<fs::path> yamls, drawings;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (isPartYaml(entry.path().string())) yamls.push_back(entry.path());
    if (isDrawing(entry.path().string())) drawings.push_back(entry.path());
  }
  std::sort(yamls.begin(), yamls.end());  // whatever order the file system has them in
  Found found;
  std::map<fs::path, std::string> claimed;
  findYamlParts(folder, yamls, &claimed, &found);
  for (const auto& drawing : drawings) {
    const std::string name = drawing.stem().string();
    const auto owner = claimed.find(drawing.lexically_normal());
    if (owner != claimed.end()) found.owners.emplace(name, owner->second);
    if (owner != claimed.end() || found.errors.count(name) > 0) continue;
    const std::string error = whyNotOpened(folder, drawing);
    if (error.empty()) {
      found.files.emplace(name, drawing);
    } else if (found.files.count(name) == 0) {
      found.errors[name] = error;
    }
  }
  return found;
}

/// A part's files: its yaml and the drawing that this names, or its drawing alone.
FileStamps filesNamedBy(const fs::path& file) {
  FileStamps files;
  files[file.lexically_normal().string()] = stampOf(file.string());
  if (!isPartYaml(file.string())) return files;
  const auto drawing = planar_bin_picking::drawingNamedBy(file.string());
  if (drawing) files[*drawing] = stampOf(*drawing);
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
  load(nullptr);
  if (parts_.empty() && errors_.empty()) {
    throw std::runtime_error("parts folder '" + folder + "' has neither *.dxf nor *.yaml in it");
  }
}

PartLibrary::PartLibrary(const PartLibrary& former, const bool all_anew) : folder_(former.folder_) {
  load(all_anew ? nullptr : &former);
}

void PartLibrary::load(const PartLibrary* former) {
  // Stamps first: what changes while it is read is seen to have changed afterwards.
  stamps_ = stampsIn(folder_, {});
  const Found found = findParts(folder_);
  errors_ = found.errors;
  owners_ = found.owners;
  std::vector<std::string> to_read, their_names;
  for (const auto& [name, file] : found.files) {
    Source source{filesNamedBy(file), std::chrono::system_clock::now()};
    stamps_.insert(source.files.begin(), source.files.end());
    if (former != nullptr && former->filesOf(name) == source.files) {
      source.read_at = former->readAt(name);
      const auto part = former->parts_.find(name);
      const auto error = former->errors_.find(name);
      if (part != former->parts_.end()) parts_[name] = part->second;
      if (error != former->errors_.end()) errors_[name] = error->second;
    } else {
      to_read.push_back(file.string());
      their_names.push_back(name);
    }
    sources_[name] = std::move(source);
  }
  const auto loaded = planar_bin_picking::loadParts(to_read);
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    if (loaded[i].part) {
      parts_[their_names[i]] = loaded[i].part;
    } else {
      errors_[their_names[i]] = loaded[i].error;
    }
  }
}

std::chrono::system_clock::time_point PartLibrary::readAt(const std::string& part) const {
  const auto found = sources_.find(part);
  return found == sources_.end() ? std::chrono::system_clock::time_point() : found->second.read_at;
}

FileStamps PartLibrary::filesOf(const std::string& part) const {
  const auto found = sources_.find(part);
  return found == sources_.end() ? FileStamps() : found->second.files;
}

std::set<std::string> PartLibrary::paths() const {
  std::set<std::string> paths;
  for (const auto& entry : stamps_) paths.insert(entry.first);
  return paths;
}

std::vector<PartPtr> PartLibrary::select(const std::string& part,
                                         const std::vector<std::string>& parts) const {
  std::vector<PartPtr> selected;
  if (part.empty() && parts.empty()) {
    for (const auto& entry : parts_) selected.push_back(entry.second);
    if (selected.empty() && errors_.empty())
      refuse("the parts folder " + folder_ + " is empty; put drawings into it");
    if (selected.empty())
      refuse("none of the parts in " + folder_ + " could be loaded: " + names(errors_));
    return selected;
  }
  std::set<std::string> wanted(parts.begin(), parts.end());
  if (!part.empty()) wanted.insert(part);
  for (const std::string& name : wanted) selected.push_back(selectOne(name));
  return selected;
}

PartPtr PartLibrary::selectOne(const std::string& name) const {
  const auto found = parts_.find(name);
  if (found != parts_.end()) return found->second;
  const auto error = errors_.find(name);
  if (error != errors_.end()) {
    refuse("part '" + name + "' could not be loaded: " + error->second +
           "; correct the file, which is then read anew");
  }
  const auto owner = owners_.find(name);
  if (owner != owners_.end()) {
    refuse("there is no part '" + name + "': its drawing is that of part '" + owner->second +
           "', whose file names it; ask for that part, or write the file " + name + ".yaml, too");
  }
  refuse("there is no part '" + name + "' in " + folder_ + " (there is: " + names(parts_) +
         "); put its drawing there, which is then read");
}

}  // namespace planar_bin_picking_ros
