// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The text of a DXF file, checked before the reader library sees it.
///
/// dxflib takes what it gets: it turns bad numbers into 0, stops at the end of a truncated file
/// without a word, trusts the counts that a file states, and hides some flags. So the file is read
/// here first, group by group; what is wrong is refused with its line, and what is no geometry is
/// left out.

#include <string>
#include <vector>

namespace planar_bin_picking {

/// An entity that may be part of a contour but cannot be read.
struct UnreadableEntity {
  std::string type, layer;
};

struct DxfText {
  std::string text;  ///< a smaller DXF file: header, tables, blocks and entities with geometry
  std::vector<UnreadableEntity> unreadable;
};

/// @throws std::runtime_error  naming the line, not the file: unreadable, empty, binary, truncated,
/// no
///         DXF at all, a number that is none, a count that does not hold
DxfText readDxfText(const std::string& path);

}  // namespace planar_bin_picking
