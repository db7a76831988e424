// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What a calibration leaves on disk. Its files are replaced together or not at all, and those that
/// they replace are kept beside them as `<name>.before`.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <string>

namespace planar_bin_picking {

/// The names that go into the files.
struct CalibrationNames {
  std::string camera_name = "camera";   ///< in camera_info.yaml
  std::string mount_frame = "flange";   ///< tf frame: the flange, or the base for a fixed camera
  std::string camera_frame = "camera";  ///< tf frame of the camera, optical
};

/// What is done with what is there already.
struct SaveOptions {
  bool replace_good = false;  ///< a POOR calibration replaces a GOOD one
  std::string date;           ///< ISO 8601, goes into every file; empty = now
  std::string pictures;       ///< what the report puts in front of the views' names to show them
};

/// Writes into the folder (made if it is not there):
///  - `calibration.yaml`: verdict, reasons and all numbers, whatever the verdict
///  - `report.html`: the same for people
///  - unless REFUSED, `camera_info.yaml` in the ROS format and `hand_eye.yaml`, a static transform;
///    the same transform for others as `hand_eye.xacro`, a joint, and as
///    `static_transform.launch`
/// Each has the date, the verdict and the expected error in it. Beside a REFUSED calibration no
/// older camera and transform stay: they become `<name>.before`. A POOR calibration goes to the
/// folder `poor` below this one where a GOOD one stands, unless options say otherwise. Numbers have
/// points, whatever the process's locale.
/// @return  the folder that was written to
/// @throws std::runtime_error  what cannot be written and why; the former calibration stands whole
std::string saveCalibration(const std::string& folder, const HandEyeProblem& problem,
                            const HandEyeResult& result, const CalibrationNames& names,
                            const SaveOptions& options = {});

/// Makes the folder and tries to write in it, so that a calibration need not fail at its end.
/// @throws std::runtime_error  what cannot be made or written, and why
void checkCalibrationFolder(const std::string& folder);

/// A static transform as `hand_eye.yaml` has it.
struct HandEyeFile {
  std::string parent_frame, child_frame;
  Eigen::Isometry3d T_parent_child = Eigen::Isometry3d::Identity();
  // Of files that say it; those of older versions, or written by hand, leave these as they are
  // here.
  std::string date, verdict, camera_name;
  double expected_error_mm = 0.0, expected_error_deg = 0.0;
};

/// @throws std::runtime_error  naming file, key and value
HandEyeFile loadHandEye(const std::string& path);

}  // namespace planar_bin_picking
