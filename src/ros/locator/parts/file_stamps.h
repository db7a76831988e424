// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What tells that a file has changed, without reading it.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <tuple>

namespace planar_bin_picking_ros {

/// Size, inode, and when content and attributes were last changed; all zero where there is none.
struct FileStamp {
  std::uint64_t size = 0, inode = 0;
  std::int64_t content_ns = 0, status_ns = 0;

  bool operator==(const FileStamp& other) const {
    return std::tie(size, inode, content_ns, status_ns) ==
           std::tie(other.size, other.inode, other.content_ns, other.status_ns);
  }
  bool operator!=(const FileStamp& other) const { return !(*this == other); }
};

using FileStamps = std::map<std::string, FileStamp>;  ///< path -> stamp

/// Of the file that a link leads to.
FileStamp stampOf(const std::string& path);

/// Of all *.yaml, *.yml and *.dxf of a folder.
/// @param also  further files, such as drawings in folders below it
/// @throws std::filesystem::filesystem_error  the folder cannot be read
FileStamps stampsIn(const std::string& folder, const std::set<std::string>& also);

/// "bracket.yaml" and "bracket.yml" are part files, "bracket.DXF" is a drawing.
bool isPartYaml(const std::string& path);
bool isDrawing(const std::string& path);

}  // namespace planar_bin_picking_ros
