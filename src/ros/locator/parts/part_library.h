// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// All parts of one folder, loaded once. A part that cannot be loaded stays in the library with its
/// error: the others work, and a call for it is told why it does not.

#include "planar_bin_picking/part/part_model.h"

#include <map>
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

  /// @param name  "" = all parts that could be loaded, by name
  /// @throws Refusal  UNKNOWN_PART, with the names there are or with the part's error
  std::vector<PartPtr> select(const std::string& name) const;

  const std::map<std::string, PartPtr>& parts() const { return parts_; }
  const std::map<std::string, std::string>& errors() const { return errors_; }  ///< part -> error

 private:
  std::string folder_;
  std::map<std::string, PartPtr> parts_;
  std::map<std::string, std::string> errors_;
  std::map<std::string, std::string> owners_;  ///< drawing that is no part itself -> its part
};

}  // namespace planar_bin_picking_ros
