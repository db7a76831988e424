// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/part/part_model.h"

#include "base/parallel.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

namespace planar_bin_picking {
namespace {

PartFile checked(PartFile file) {
  const auto& loops = file.drawing.loops;
  if (loops.empty() || loops.front().kind != LoopKind::kOuter) {
    throw std::invalid_argument("part " + file.name + ": the outline has no outer contour");
  }
  Eigen::AlignedBox2d box;
  for (const auto& p : loops.front().points) box.extend(p);
  if (box.isEmpty() || !(box.sizes().maxCoeff() > 0.0))
    throw std::invalid_argument("part " + file.name + ": the outer contour has no extent");
  if (!(file.thickness >= 0.0)) {
    throw std::invalid_argument("part " + file.name + ": thickness " +
                                std::to_string(file.thickness) + " m; it must be 0 or more");
  }
  return file;
}

}  // namespace

PartModel::PartModel(PartFile file) : file_(checked(std::move(file))), face_grid_(file_.drawing) {
  const auto& loops = file_.drawing.loops;
  symmetry_ = findSymmetry(file_.drawing);
  pick_poses_ = withSymmetricCopies(file_.pick_poses, symmetry_, file_.thickness);
  Eigen::AlignedBox2d box;
  for (const auto& p : loops.front().points) box.extend(p);
  center_ = box.center();
  for (const auto& loop : loops) has_print_ = has_print_ || loop.kind == LoopKind::kPrint;
  for (const auto& p : loops.front().points) radius_ = std::max(radius_, (p - center_).norm());
  outline_ = sampleOutline(file_.drawing);
  const OutlineShape shape{outline_, symmetry_, radius_, file_.thickness, has_print_};
  near_symmetries_ = findNearSymmetries(shape);
  near_order_ = findNearOrder(shape, near_symmetries_);
}

std::vector<LoadedPart> loadParts(const std::vector<std::string>& paths) {
  std::vector<LoadedPart> loaded(paths.size());
  const int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  parallelFor(static_cast<int>(paths.size()), threads, [&](const int i) {
    LoadedPart& one = loaded[static_cast<std::size_t>(i)];
    try {
      one.part =
          std::make_shared<const PartModel>(loadPartFile(paths[static_cast<std::size_t>(i)]));
    } catch (const std::exception& failure) {
      one.error = failure.what();
    }
  });
  return loaded;
}

}  // namespace planar_bin_picking
