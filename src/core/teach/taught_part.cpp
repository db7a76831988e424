// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/teach/taught_part.h"

#include "base/atomic_file.h"
#include "base/regular_file.h"
#include "base/yaml_text.h"
#include "part/pick_check.h"
#include "planar_bin_picking/teach/snap.h"
#include "teach/pick_text.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBytesMost = 2u << 20;  // as the reader of YAML files has it

PartPtr load(const std::string& path) {
  return std::make_shared<const PartModel>(loadPartFile(path, WrongPicks::kWarned));
}

bool has(const std::vector<PickPose>& poses, const std::string& name) {
  return std::any_of(poses.begin(), poses.end(),
                     [&](const PickPose& pose) { return pose.name == name; });
}

bool isSame(const std::vector<PickPose>& a, const std::vector<PickPose>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), isSamePick);
}

/// Replaces the file that a link leads to, not the link, and leaves its permissions.
void replaceContent(const fs::path& path, const std::string& content) {
  const fs::path target = fs::canonical(path);
  const fs::perms permissions = fs::status(target).permissions();
  writeTogether({{target.string(), content}});
  std::error_code ignored;  // it is written; whose it is may matter to nobody
  fs::permissions(target, permissions, ignored);
}

}  // namespace

TaughtPart::TaughtPart(const std::string& path)
    : path_(path), part_(load(path)), poses_(part_->file().pick_poses) {}

std::size_t TaughtPart::indexOf(const std::string& name) const {
  const auto found = std::find_if(poses_.begin(), poses_.end(),
                                  [&](const PickPose& pose) { return pose.name == name; });
  if (found == poses_.end())
    throw std::invalid_argument("part " + part_->name() + " has no pick pose " + name);
  return static_cast<std::size_t>(found - poses_.begin());
}

const PickPose& TaughtPart::pose(const std::string& name) const { return poses_[indexOf(name)]; }

void TaughtPart::change(const PickPose& pose) { poses_[indexOf(pose.name)] = pose; }

std::string TaughtPart::add(Face face, const std::optional<Eigen::Vector2d>& at) {
  const std::string word = face == Face::kFront ? "front" : "back";
  PickPose pose;
  pose.name = word;
  const auto is_taken = [&](const std::string& name) {
    // Names of the file, too: one that is removed and added again is another one.
    return has(poses_, name) || has(part_->file().pick_poses, name);
  };
  for (int i = 2; is_taken(pose.name); ++i) pose.name = word + "_" + std::to_string(i);
  pose.face = FaceFilter::kFront;
  pose.T_part_pick.linear() =
      Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  if (face == Face::kBack) pose = forOtherFace(pose, part_->thickness());
  if (at) {
    pose.T_part_pick.translation().head<2>() = *at;
  } else {
    pose = snappedToCentroid(pose, part_->file().drawing);
  }
  poses_.push_back(pose);
  return pose.name;
}

void TaughtPart::prefer(const std::string& name) {
  const std::size_t index = indexOf(name);
  if (index == 0) throw std::invalid_argument("pick pose " + name + " is the first already");
  std::swap(poses_[index - 1], poses_[index]);
}

std::string TaughtPart::nameInFile(const std::string& name) const {
  const auto former = former_names_.find(name);
  if (former != former_names_.end()) return former->second;
  const bool is_another = std::any_of(former_names_.begin(), former_names_.end(),
                                      [&](const auto& entry) { return entry.second == name; });
  return !is_another && has(part_->file().pick_poses, name) ? name : "";
}

void TaughtPart::rename(const std::string& name, const std::string& new_name) {
  const std::size_t index = indexOf(name);
  if (!isPickName(new_name))
    throw std::invalid_argument("pick pose " + name + " cannot be called \"" + new_name +
                                "\": give " + kPickNameExpected);
  if (has(poses_, new_name))
    throw std::invalid_argument("there is a pick pose " + new_name + " already; rename that first");
  const auto isFromThere = [&](const PickPose& pose) { return nameInFile(pose.name) == new_name; };
  // In the file's text nobody could tell the one that was deleted from this one.
  if (has(part_->file().pick_poses, new_name) &&
      std::none_of(poses_.begin(), poses_.end(), isFromThere))
    throw std::invalid_argument("the file still has the pick pose " + new_name +
                                " that was deleted; save first");
  const std::string in_file = nameInFile(name);
  former_names_.erase(name);
  if (!in_file.empty() && in_file != new_name) former_names_[new_name] = in_file;
  poses_[index].name = new_name;
}

void TaughtPart::remove(const std::string& name) {
  poses_.erase(poses_.begin() + static_cast<std::ptrdiff_t>(indexOf(name)));
  former_names_.erase(name);
}

std::string TaughtPart::faultOf(const PickPose& pose) const {
  const PartFile& file = part_->file();
  std::string text;
  for (std::string fault : pickWarnings({pose}, file.tool, file.drawing, file.thickness)) {
    const std::string begin = "pick pose " + pose.name + ": ";
    if (fault.compare(0, begin.size(), begin) == 0) fault.erase(0, begin.size());
    text += (text.empty() ? "" : "; ") + fault;
  }
  return text;
}

bool TaughtPart::isChanged() const { return !isSame(poses_, part_->file().pick_poses); }

std::string TaughtPart::save() {
  std::string faults;
  for (const PickPose& pose : poses_) {
    const std::string wrong = wrongDirection(pose);
    if (!wrong.empty()) {
      throw std::runtime_error("nothing is saved: pick pose " + pose.name + ": " + wrong +
                               "; or snap it to the normal");
    }
    const std::string fault = faultOf(pose);
    if (!fault.empty()) faults += "; look at " + pose.name + ": " + fault;
  }
  const std::string yaml = part_->file().yaml_path;
  fs::path target = yaml;
  if (yaml.empty()) {
    const fs::path drawing(path_);
    target = fs::path(drawing).replace_extension(".yaml");
    if (fs::exists(target)) {
      throw std::runtime_error(target.string() +
                               ": has come meanwhile, nothing is saved; read the file anew");
    }
    const std::string text = "drawing: " + yamlText(drawing.filename().string()) + "\n";
    writeTogether({{target.string(), withPickPoses(text, poses_)}});
  } else {
    const std::string text = readRegularFile(yaml, kBytesMost);
    if (!isSame(pickPosesIn(text, yaml, WrongPicks::kWarned), part_->file().pick_poses)) {
      throw std::runtime_error(yaml +
                               ": its pick poses have been changed meanwhile by somebody else, "
                               "nothing is saved; read the file anew");
    }
    const std::string changed = withPickPoses(text, poses_, former_names_);
    if (changed == text) return yaml + " has these pick poses already" + faults;
    replaceContent(yaml, changed);
  }
  readAnew();
  return std::to_string(poses_.size()) + (poses_.size() == 1 ? " pick pose" : " pick poses") +
         " written to " + target.string() + faults;
}

void TaughtPart::readAnew() {
  part_ = load(path_);
  poses_ = part_->file().pick_poses;
  former_names_.clear();
}

std::string findPart(const std::string& part, const std::string& folder) {
  const fs::path given(part);
  if (given.has_parent_path()) return part;
  for (const char* extension : {"", ".yaml", ".yml", ".dxf", ".DXF"}) {
    const fs::path path = fs::path(folder) / (part + extension);
    if (!part.empty() && fs::is_regular_file(path)) return path.string();
  }
  throw std::runtime_error("there is no part '" + part + "' in " + folder +
                           "; give its name, or the path of its .yaml or .dxf");
}

}  // namespace planar_bin_picking
