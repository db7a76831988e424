// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What stands in a DXF file: its layers, line types, blocks and entities. Nothing is left out by
/// layer, placed or chained yet. What is wrong with an entity is kept with it, since it matters
/// only if the entity belongs to the part.

#include "drawing/dxf/dxf_curves.h"

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct DxfLayer {
  bool off = false, frozen = false;
  std::string linetype;
};

enum class DxfKind : std::uint8_t {
  kCurve,
  kInsert,
  kUnreadable,  ///< may be part of a contour, but what it looks like is not in the file
  kText,        ///< text and dimensions
  kHatch,
  kOther  ///< nothing that could be an edge: points, images, viewports, ...
};

/// What an INSERT says: the block as often as there are rows and columns.
struct DxfInsert {
  std::string block;
  Eigen::Affine2d placement = Eigen::Affine2d::Identity();  ///< parent <- first row and column
  Eigen::Vector2d column = Eigen::Vector2d::Zero(), row = Eigen::Vector2d::Zero();  ///< in parent
  int columns = 1, rows = 1;
};

/// What a linear DIMENSION says, and what it stands for.
struct DxfDimension {
  std::string style;
  double drawn = 0.0;              ///< drawing units
  std::optional<double> measured;  ///< group 42
  std::optional<double> written;   ///< in place of the measured value
  std::optional<double> factor;    ///< $DIMLFAC of this dimension alone
};

/// Names keep the spelling of the file; compare them by upperCase().
struct DxfEntity {
  DxfKind kind = DxfKind::kOther;
  std::string type;  ///< LINE, ARC, ...
  std::string layer = "0";
  std::string linetype = "BYLAYER";  ///< may be BYBLOCK
  bool invisible = false, on_paper = false;
  std::string fault;  ///< why it cannot be read; empty = nothing is wrong
  Curve curve;
  /// How much shorter it looks for its plane being tilted, as a share of its size.
  double tilt = 0.0;
  std::shared_ptr<const DxfInsert> insert;  ///< of an INSERT that has no fault
};

struct DxfBlock {
  std::string name;
  std::string external;  ///< the file that an external reference names; empty = no reference
  Eigen::Vector2d base_point = Eigen::Vector2d::Zero();
  std::deque<DxfEntity> entities;
};

/// A drawing's header, as far as it matters here.
struct DxfHeader {
  std::optional<int> insunits, measurement;
  double dimension_factor = 1.0;  ///< $DIMLFAC
};

/// Maps go by upperCase() of the name.
struct DxfFile {
  DxfHeader header;
  std::map<std::string, DxfLayer> layers;
  std::map<std::string, bool> dashed_linetypes;     ///< whether the table's pattern has gaps
  std::map<std::string, double> dimension_factors;  ///< by DIMSTYLE
  std::map<std::string, DxfBlock> blocks;
  std::deque<DxfEntity> entities;
  std::vector<DxfDimension> dimensions;  ///< linear ones in model space
};

}  // namespace planar_bin_picking
