// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/cell_params.h"

#include "planar_bin_picking/bin/region.h"
#include "planar_bin_picking/locate/locator.h"

#include <cmath>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking_ros {

namespace {

void require(const bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

void validateBox(const CellParams& params) {
  require(params.bin_min.size() == 3 && params.bin_max.size() == 3,
          "~cell/bin_frame is set: ~cell/bin_min and ~cell/bin_max must be lists of three numbers");
  for (std::size_t i = 0; i < 3; ++i) {
    require(std::isfinite(params.bin_min[i]) && std::isfinite(params.bin_max[i]) &&
                params.bin_min[i] < params.bin_max[i],
            "each number in ~cell/bin_min must be less than the one in ~cell/bin_max");
  }
}

void validateFoundBin(const CellParams& params) {
  const std::vector<double>& found = params.bin_found;
  if (found.empty()) return;
  double length2 = 0.0;
  bool is_pose = found.size() == 7;
  for (std::size_t i = 0; is_pose && i < found.size(); ++i) {
    is_pose = std::isfinite(found[i]);
    if (i >= 3) length2 += found[i] * found[i];
  }
  constexpr double kOff = 1e-3;  // of a unit quaternion that was rounded to four digits
  require(is_pose && std::abs(length2 - 1.0) <= kOff,
          "~cell/bin_found must be x, y, z and a quaternion x, y, z, w of length 1, as "
          "~save_parameters writes it; delete it, and find the bin anew with ~locate_bin");
}

void validateNextView(const CellParams& params) {
  const auto& min = params.next_view_min;
  const auto& max = params.next_view_max;
  if (min.empty() && max.empty() && params.focus_min == 0.0 && params.focus_max == 0.0) return;
  require(min.size() == 3 && max.size() == 3 && params.focus_max > 0.0,
          "set ~cell/next_view_min and ~cell/next_view_max, lists of three numbers, with "
          "~cell/focus_min and ~cell/focus_max, or none of these");
  for (std::size_t i = 0; i < 3; ++i) {
    require(std::isfinite(min[i]) && std::isfinite(max[i]) && min[i] < max[i],
            "each number in ~cell/next_view_min must be less than the one in ~cell/next_view_max");
  }
  require(0.0 < params.focus_min && params.focus_min < params.focus_max,
          "~cell/focus_min must be greater than 0 and less than ~cell/focus_max");
}

void validateRegion(const CellParams& params) {
  for (const auto& [key, numbers] :
       {std::pair("region", &params.region), std::pair("region_px", &params.region_px)}) {
    try {
      planar_bin_picking::regionOutline(*numbers);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string("~cell/") + key + " " + error.what());
    }
  }
  require((params.region.empty() && params.region_file.empty()) || !params.regionFrame().empty(),
          "~cell/region or region_file is set: ~cell/region_frame must name its frame");
}

}  // namespace

void validate(const CellParams& params) {
  require(!params.parts_folder.empty(),
          "~cell/parts_folder is not set: the folder with the drawings");
  validateNextView(params);
  validateRegion(params);
  require(params.hasBin() || params.bin_found.empty(),
          "~cell/bin_found is set without ~cell/bin_frame");
  const bool has_distances = params.distance_min != 0.0 || params.distance_max != 0.0;
  require(has_distances != params.hasBin(),
          "set either ~cell/distance_min and ~cell/distance_max, or ~cell/bin_frame with "
          "~cell/bin_min and ~cell/bin_max: they say where parts may lie");
  if (params.hasBin()) {
    validateBox(params);
    validateFoundBin(params);
  } else {
    require(params.bin_min.empty() && params.bin_max.empty(),
            "~cell/bin_min or ~cell/bin_max is set without ~cell/bin_frame");
    require(0.0 < params.distance_min && params.distance_min < params.distance_max,
            "~cell/distance_min must be greater than 0 and less than ~cell/distance_max");
    try {
      planar_bin_picking::checkDistances(params.distance_min, params.distance_max);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(std::string("~cell/distance_min and ~cell/distance_max: ") +
                                  error.what());
    }
  }
}

}  // namespace planar_bin_picking_ros
