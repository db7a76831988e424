// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A flat part out of a STEP file, as a drawing. Read with Open CASCADE, where the build has it.

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace planar_bin_picking {

struct StepPart {
  std::string dxf;            ///< its contours: a drawing in millimetres
  double thickness_mm = 0.0;  ///< of the solid, square to them
};

/// "lever.step" and "lever.STP" are.
inline bool isStep(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](const unsigned char c) { return std::tolower(c); });
  return extension == ".step" || extension == ".stp";
}

/// The contours of the solid's largest flat face. The part frame has its z out of that face; x is
/// the file's x axis as far as it lies in the face, and the origin the file's, moved onto it. Of
/// two faces of one size it is the one that looks up in the file.
/// @throws std::runtime_error  no STEP file, damaged, not exactly one solid, not flat; or a build
///         without Open CASCADE
StepPart readStep(const std::string& path);

}  // namespace planar_bin_picking
