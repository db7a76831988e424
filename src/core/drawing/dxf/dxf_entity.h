// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One record of a DXF file -> an entity.

#include "drawing/dxf/dxf_file.h"
#include "drawing/dxf/dxf_names.h"
#include "drawing/dxf/dxf_text.h"

#include <optional>
#include <vector>

namespace planar_bin_picking {

/// The entity of a record; its geometry is read, and what is wrong with it stands in `fault`. A
/// POLYLINE has none yet: its vertices follow in records of their own.
DxfEntity readEntity(const DxfRecord& record, const DxfNames& names);

/// Collects a POLYLINE's vertices.
class PolylineReader {
 public:
  void begin(const DxfRecord& polyline, DxfEntity* entity);
  void add(const DxfRecord& vertex, DxfEntity* entity);
  void finish(DxfEntity* entity);

 private:
  int flags_ = 0;
  Eigen::Affine2d plane_ = Eigen::Affine2d::Identity();
  std::vector<BulgeVertex> vertices_;
};

/// A linear dimension (also of a radius or a diameter); nothing for others.
std::optional<DxfDimension> readDimension(const DxfRecord& record, const DxfNames& names);

}  // namespace planar_bin_picking
