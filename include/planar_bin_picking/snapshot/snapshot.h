// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// One call of the locator as a folder that somebody else can look into and locate again:
///
///     image.pgm         grey as the locator saw it, 8 or 16 bit, lossless; most viewers open it
///     camera_info.yaml  the camera as it was used, in the ROS format
///     locator.yaml      all parameters of the localization
///     request.yaml      parts, face, distances, plane, and the version that wrote it
///     parts/            the files of the parts that were looked for
///     result.yaml       what was found, all digits: a replay has to give the same bytes
///
/// and whatever texts its writer adds. Numbers have all their digits, so that nothing is rounded.

#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/locate/locate_request.h"
#include "planar_bin_picking/locate/params.h"

#include <opencv2/core/mat.hpp>

#include <string>
#include <vector>

namespace planar_bin_picking {

struct Snapshot {
  std::string version;  ///< of the package that wrote it
  cv::Mat grey;         ///< 8 or 16 bit
  Camera camera;
  LocatorParams params;
  LocateRequest request;
  std::string result;  ///< resultText() of what was found
};

/// A file of a snapshot's folder.
struct SnapshotText {
  std::string name, text;  ///< name: within the folder, without `..`
};

/// A file that belongs to a part.
struct SnapshotPartFile {
  std::string path;      ///< where it is
  std::string inside;    ///< where it goes below parts/
  bool is_part = false;  ///< what loadPartFile takes; others are its drawing
};

/// What was found and what was withheld, one a line.
std::string resultText(const LocateResult& result);

/// Writes beside `folder` and renames at the end: a folder of that name is whole.
/// @param snapshot    the parts of its request are taken from `part_files`
/// @throws std::runtime_error  the path and the system's reason
void writeSnapshot(const std::string& folder, const Snapshot& snapshot,
                   const std::vector<SnapshotPartFile>& part_files,
                   const std::vector<SnapshotText>& texts);

/// @throws std::runtime_error  the file and what is wrong with it
Snapshot readSnapshot(const std::string& folder);

}  // namespace planar_bin_picking
