// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part whose pick poses a person is teaching: what stands in its file, what has been changed
/// since, what is wrong with it, and the way back into the file.

#include "planar_bin_picking/part/part_model.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

class TaughtPart {
 public:
  /// A pose that points the wrong way does not refuse the file: here it can be mended.
  /// @param path  as loadPartFile takes it
  /// @throws std::runtime_error  as loadPartFile
  explicit TaughtPart(const std::string& path);

  const PartModel& part() const { return *part_; }
  /// As they are now, in the order in which the robot prefers them.
  const std::vector<PickPose>& poses() const { return poses_; }
  /// @throws std::invalid_argument  there is none of this name
  const PickPose& pose(const std::string& name) const;
  /// Takes the place of the pose of its name. @throws std::invalid_argument  there is none
  void change(const PickPose& pose);
  /// Upright on a face. @param at  its place; nothing: the middle of the material
  /// @return  its name: "front", "front_2", …
  std::string add(Face face, const std::optional<Eigen::Vector2d>& at);
  /// One place earlier in that order. @throws std::invalid_argument  there is none, or it is first
  void prefer(const std::string& name);
  /// @throws std::invalid_argument  there is none, or the new name is not one or is taken; what to
  ///         do instead
  void rename(const std::string& name, const std::string& new_name);
  /// @throws std::invalid_argument  there is none
  void remove(const std::string& name);

  /// What is wrong with a pose, in words; empty where nothing is.
  std::string faultOf(const PickPose& pose) const;
  /// Whether the file has other poses.
  bool isChanged() const;

  /// Writes the poses into the part's file and changes nothing else in it; a drawing that stands
  /// alone gets a part file. The file as it was stays beside it, as FILE.before.
  /// @return  what was written, in one line
  /// @throws std::runtime_error  nothing is written: a pose points the wrong way, somebody else has
  ///         changed the file's poses meanwhile, or the file cannot be changed safely
  std::string save();
  /// Forgets what was changed. @throws std::runtime_error  as the constructor; nothing is forgotten
  void readAnew();

 private:
  std::size_t indexOf(const std::string& name) const;
  /// What the file calls a pose; "" where it has none.
  std::string nameInFile(const std::string& name) const;

  std::string path_;
  PartPtr part_;
  std::vector<PickPose> poses_;
  std::map<std::string, std::string> former_names_;  ///< of renamed poses: now -> in the file
};

/// The path of a part that is given as a path, or by its name in a folder.
/// @throws std::runtime_error  there is no such part
std::string findPart(const std::string& part, const std::string& folder);

}  // namespace planar_bin_picking
