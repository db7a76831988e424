// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The stages composed: image -> edges -> candidates -> refined -> scored -> ranked; where a plane
/// is known on which the parts lie, refined poses are fused with it (plane_prior.h).

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"
#include "planar_bin_picking/locate/params.h"
#include "planar_bin_picking/locate/part_size.h"
#include "planar_bin_picking/part/part_model.h"

#include <opencv2/core/mat.hpp>

#include <optional>

namespace planar_bin_picking {

/// Immutable and stateless between calls: one instance may serve several threads.
class Locator {
 public:
  /// @throws std::invalid_argument  a parameter out of its range, named by its key
  explicit Locator(const LocatorParams& params = {});

  /// @param image   8- or 16-bit, one channel, of the camera's size to within 2 columns and rows at
  ///                the far edges (some drivers pad or crop there)
  /// @throws PartSizeError          as checkPartSize, for the first such part
  /// @throws std::invalid_argument  image empty, of another type or size; no part; distances as
  ///         checkDistances, or the plane outside of them; a search that would take too much memory
  LocateResult locate(const cv::Mat& image, const Camera& camera,
                      const LocateRequest& request) const;

  const LocatorParams& params() const { return params_; }

 private:
  Distances searched(const Camera& camera, const LocateRequest& request, const PartModel& part,
                     const std::optional<Plane>& plane) const;

  LocatorParams params_;
};

}  // namespace planar_bin_picking
