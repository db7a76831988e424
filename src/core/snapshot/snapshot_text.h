// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The YAML texts of a snapshot, both ways.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"
#include "planar_bin_picking/locate/params.h"

#include <string>
#include <vector>

namespace planar_bin_picking {

/// All digits of a number, with a decimal point in every locale.
std::string allDigits(double value);

std::string cameraText(const Camera& camera);
std::string paramsText(const LocatorParams& params);

/// @param parts  the part files below parts/
std::string requestText(const LocateRequest& request, const std::string& version,
                        const std::vector<std::string>& parts);

/// What was found and what was withheld, one a line.
std::string detectionsText(const LocateResult& result);

/// Request without parts, the version, and the part files below parts/.
struct RequestFile {
  LocateRequest request;
  std::string version;
  std::vector<std::string> parts;
};

/// @throws std::runtime_error  file, key and what is expected there
RequestFile readRequestFile(const std::string& path);

}  // namespace planar_bin_picking
