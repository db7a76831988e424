// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The stages composed: image -> edges -> candidates -> refined -> scored -> ranked; where a plane
/// is known on which the parts lie, refined poses are fused with it (plane_prior.h).

#include "planar_bin_picking/camera.h"
#include "planar_bin_picking/params.h"
#include "planar_bin_picking/part_model.h"
#include "planar_bin_picking/types.h"

#include <opencv2/core/mat.hpp>

#include <memory>
#include <optional>
#include <vector>

namespace planar_bin_picking {

/// What is looked for in one image.
struct LocateRequest {
  /// Parts that may lie in the bin; all of them are returned, ranked together.
  std::vector<std::shared_ptr<const PartModel>> parts;
  double distance_min = 0.0, distance_max = 0.0;  ///< metres along the optical axis
  FaceFilter face = FaceFilter::kAny;
  std::size_t max_parts = 0;   ///< 0 = all
  std::optional<Plane> plane;  ///< in place of the one that LocatorParams::plane may say
};

struct LocateResult {
  std::vector<Detection> detections;  ///< best first; may be empty
  Report report;
};

/// Immutable and stateless between calls: one instance may serve several threads.
class Locator {
 public:
  /// @throws std::invalid_argument  a parameter out of its range, named by its key
  explicit Locator(const LocatorParams& params = {});

  /// @param image   8- or 16-bit, one channel, of the camera's size to within 2 columns and rows at
  ///                the far edges (some drivers pad or crop there)
  /// @throws std::invalid_argument  image empty, of another type or size; no part; distances not
  ///         0 < min <= max, or the plane outside of them
  LocateResult locate(const cv::Mat& image, const Camera& camera,
                      const LocateRequest& request) const;

  const LocatorParams& params() const { return params_; }

 private:
  Distances searched(const Camera& camera, const LocateRequest& request, const PartModel& part,
                     const std::optional<Plane>& plane) const;

  LocatorParams params_;
};

}  // namespace planar_bin_picking
