// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// DXF file -> its layers, blocks and curves as they stand in the file: nothing is left out by
/// layer, placed or chained yet. The file itself is parsed by dxflib.

#include "dxf_curves.h"
#include "dxf_text.h"

#include <map>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct DxfLayer {
  bool off = false, frozen = false;
  std::string linetype;  ///< upper case
};

/// A curve, or a reference to a block. DXF names do not tell case apart: all are upper case.
struct DxfEntity {
  std::string type;  ///< LINE, ARC, ...
  std::string layer;
  std::string linetype;  ///< may be BYLAYER or BYBLOCK
  Curve curve;           ///< not of an INSERT
  std::string block;     ///< of an INSERT: what it inserts
  std::vector<Eigen::Affine2d>
      placements;  ///< of an INSERT: one per row and column, parent <- block
};

struct DxfBlock {
  Eigen::Vector2d base_point = Eigen::Vector2d::Zero();
  std::vector<DxfEntity> entities;
};

struct DxfFile {
  double mm_per_unit = 1.0;
  std::map<std::string, DxfLayer> layers;
  std::map<std::string, DxfBlock> blocks;
  std::vector<DxfEntity> entities;
  std::vector<UnreadableEntity> unreadable;
};

std::string upperCase(std::string text);

/// @throws std::runtime_error  as readDxfText; also an unknown unit, an entity that does not lie in
/// the
///         xy plane or whose numbers do not fit together. Names the entity, not the file.
DxfFile readDxf(const std::string& path);

}  // namespace planar_bin_picking
