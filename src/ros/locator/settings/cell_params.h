// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the integrator of a cell sets, below `~cell`; see config/cell.yaml. The defaults stand here
/// and nowhere else. The parameters of the localization itself are the core's (params.h).

#include "shared/transforms.h"

#include <string>
#include <vector>

namespace planar_bin_picking_ros {

struct CellParams {
  std::string cell_file;     ///< which these came from, for ~save_parameters; "" = there is none
  std::string parts_folder;  ///< *.yaml and *.dxf in it are the parts
  double parts_poll = 1.0;   ///< s between two looks at the folder; 0 = only on ~reload_parts
  std::string target_frame;  ///< frame of the answers; "" = the camera's
  /// In front of the parts' tf frames; "" = defaultFramePrefix, what tells two locators apart.
  std::string frame_prefix;
  /// The calibrator's camera_info.yaml, in place of what comes with the images; "" = the latter.
  std::string camera_info_file;
  /// Where parts may lie, along the optical axis, metres: from the top of a full bin to its floor.
  double distance_min = 0.0, distance_max = 0.0;
  /// Or, in place of these, the bin's inner space as a box: its frame and two opposite corners in
  /// it, metres. The distances then follow the camera.
  std::string bin_frame;
  std::vector<double> bin_min, bin_max;
  /// m; what is longer and lies on the bin's floor is something, shorter edges are its own marks.
  double empty_mark = 0.02;
  /// The bin may stand otherwise: ~locate_bin finds it by its rim. m, its walls on top; 0 = not
  /// known, and it is not looked for. What is farther off than these is not believed.
  double bin_wall = 0.0;
  double bin_moved_max = 0.06, bin_turned_max_deg = 10.0, bin_tilted_max_deg = 5.0;
  /// Where ~locate_bin has found it, as seen from bin_frame: x, y, z, m, and a quaternion x, y, z,
  /// w. Empty = where bin_frame is.
  std::vector<double> bin_found;
  /// Where in it, or in the picture, parts may lie: x, y, x, y, ... of two corners of a box or of a
  /// polygon, metres in region_frame or pixels. "" = the bin's frame, or else the answers'. What is
  /// taught stands in region_file and takes the place of `region`.
  std::vector<double> region, region_px;
  std::string region_frame, region_file;
  /// Parts lie in a single layer on the plane z = 0 of this frame, such as a conveyor's; "" = no
  /// such plane is known, but for ~locator/plane.
  std::string plane_frame;
  /// std_srvs/Trigger, called before each wait for an image: a camera's software trigger, or
  /// the HDR node's `take`. "" = images come of themselves.
  std::string trigger_service;
  double trigger_timeout = 30.0;  ///< s, wall time, for trigger_service: a bracket takes its time
  double image_timeout = 5.0;     ///< s, wall time, for calls that name none
  double tf_timeout = 0.5;  ///< s, wall time: how much later than the image its tf may come in
  double tf_gap_max = kTfGapMax;  ///< s, between the two samples of tf around the image
  /// The calibrator's hand_eye.yaml: what it expects its error to be goes into poses that rest on
  /// several views; "" = ~locator/views says it.
  std::string hand_eye_file;
  /// Where next_view may send the camera: opposite corners of a box in the target frame, metres;
  /// how far its optical axis may turn; between which distances the picture is sharp.
  std::vector<double> next_view_min, next_view_max;
  double next_view_cone_deg = 35.0;
  double focus_min = 0.0, focus_max = 0.0;
  /// A second camera that stands still as the first one does: its images, and its frame where the
  /// images do not say it. "" = there is none.
  std::string second_camera_topic, second_camera_frame;

  std::string snapshot_folder;  ///< where calls that went wrong are saved; "" = nowhere
  int snapshots_max = 20;       ///< kept there; the oldest go
  double snapshots_mb = 500.0;  ///< of all together
  int snapshot_failures = 3;    ///< failed picks in a row after which one is saved; 0 = never
  std::string archive_folder;   ///< where every call is saved; "" = nowhere
  double archive_mb = 20000.0;  ///< of all together; the oldest go
  double archive_hours = 24.0;  ///< that a call is kept; 0 = until there is no room

  bool hasBin() const { return !bin_frame.empty(); }
  const std::string& regionFrame() const {
    if (!region_frame.empty()) return region_frame;
    return hasBin() ? bin_frame : target_frame;
  }

  /// Calls visit(key, member, min, max) for numbers and visit(key, member) for all else.
  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("cell_file", self.cell_file);
    visit("parts_folder", self.parts_folder);
    visit("parts_poll", self.parts_poll, 0.0, 3600.0);
    visit("target_frame", self.target_frame);
    visit("frame_prefix", self.frame_prefix);
    visit("camera_info_file", self.camera_info_file);
    visit("distance_min", self.distance_min, 0.0, 100.0);
    visit("distance_max", self.distance_max, 0.0, 100.0);
    visit("bin_frame", self.bin_frame);
    visit("bin_min", self.bin_min);
    visit("bin_max", self.bin_max);
    visit("empty_mark", self.empty_mark, 0.0, 1.0);
    visit("bin_wall", self.bin_wall, 0.0, 0.5);
    visit("bin_moved_max", self.bin_moved_max, 0.0, 1.0);
    visit("bin_turned_max_deg", self.bin_turned_max_deg, 0.0, 45.0);
    visit("bin_tilted_max_deg", self.bin_tilted_max_deg, 0.0, 30.0);
    visit("bin_found", self.bin_found);
    visit("region", self.region);
    visit("region_px", self.region_px);
    visit("region_frame", self.region_frame);
    visit("region_file", self.region_file);
    visit("plane_frame", self.plane_frame);
    visit("trigger_service", self.trigger_service);
    visit("trigger_timeout", self.trigger_timeout, 0.01, 3600.0);
    visit("image_timeout", self.image_timeout, 0.0, 3600.0);
    visit("tf_timeout", self.tf_timeout, 0.0, 60.0);
    visit("tf_gap_max", self.tf_gap_max, 0.001, 60.0);
    visit("snapshot_folder", self.snapshot_folder);
    visit("snapshots_max", self.snapshots_max, 1, 100000);
    visit("snapshots_mb", self.snapshots_mb, 1.0, 1e7);
    visit("snapshot_failures", self.snapshot_failures, 0, 1000);
    visit("archive_folder", self.archive_folder);
    visit("archive_mb", self.archive_mb, 1.0, 1e8);
    visit("archive_hours", self.archive_hours, 0.0, 1e5);
    visit("hand_eye_file", self.hand_eye_file);
    visit("next_view_min", self.next_view_min);
    visit("next_view_max", self.next_view_max);
    visit("next_view_cone_deg", self.next_view_cone_deg, 1.0, 80.0);
    visit("focus_min", self.focus_min, 0.0, 100.0);
    visit("focus_max", self.focus_max, 0.0, 100.0);
    visit("second_camera_topic", self.second_camera_topic);
    visit("second_camera_frame", self.second_camera_frame);
  }
};

/// @throws std::invalid_argument  naming the keys: no folder, neither distances nor a bin or both
///         of them, an empty box, distances that the core's checkDistances refuses; limits of
///         the next view that are not all set, or empty; a region that is no outline or has no
///         frame
void validate(const CellParams& params);

}  // namespace planar_bin_picking_ros
