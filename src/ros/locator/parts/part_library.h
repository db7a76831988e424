// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// All parts of one folder as they were at one moment; immutable. A part that cannot be loaded
/// stays in the library with its error: the others work, and a call for it is told why it does not.

#include "locator/parts/file_stamps.h"
#include "planar_bin_picking/part/part_model.h"

#include <chrono>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

using planar_bin_picking::PartPtr;

class PartLibrary {
 public:
  /// A part is a *.yaml or a *.dxf that no yaml of the folder names as its drawing. What is no
  /// regular file, or lies outside of the folder by way of a link or of the drawing that a yaml
  /// names, is not read: that part is not available.
  /// @throws std::runtime_error  the folder cannot be read or has no part in it
  explicit PartLibrary(const std::string& folder);
  /// The same folder later; it may be empty. Parts none of whose files has changed are shared with
  /// the former library, unless all are read anew.
  PartLibrary(const PartLibrary& former, bool all_anew);

  /// @param part   "" and no `parts` = all parts that could be loaded, by name
  /// @param parts  more of them; each counts once
  /// @throws Refusal  UNKNOWN_PART, with the names there are or with the part's error
  std::vector<PartPtr> select(const std::string& part,
                              const std::vector<std::string>& parts = {}) const;

  const std::string& folder() const { return folder_; }
  const std::map<std::string, PartPtr>& parts() const { return parts_; }
  const std::map<std::string, std::string>& errors() const { return errors_; }  ///< part -> error
  /// When a part's files were read, wall time; of those that could not be, too.
  std::chrono::system_clock::time_point readAt(const std::string& part) const;
  /// The files that a part was read from, as they were just before; empty for an unknown part.
  FileStamps filesOf(const std::string& part) const;
  /// All files that were looked at: when these stamps differ, the library is out of date.
  const FileStamps& stamps() const { return stamps_; }
  std::set<std::string> paths() const;  ///< of stamps()

 private:
  struct Source {
    FileStamps files;
    std::chrono::system_clock::time_point read_at;
  };

  void load(const PartLibrary* former);
  PartPtr selectOne(const std::string& name) const;

  std::string folder_;
  FileStamps stamps_;
  std::map<std::string, Source> sources_;
  std::map<std::string, PartPtr> parts_;
  std::map<std::string, std::string> errors_;
  std::map<std::string, std::string> owners_;  ///< drawing that is no part itself -> its part
};

}  // namespace planar_bin_picking_ros
