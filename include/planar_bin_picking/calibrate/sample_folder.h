// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The pictures of a calibration on disk, saved one by one as they are taken, so that whatever
/// happens later costs none of them:
///  - `samples/picture_001.png`, ...
///  - `samples.yaml`: pictures and robot poses, as calibrate_samples reads them
///  - `corners.yaml`: the same, and what was seen in them; complete without the pictures
/// A set that a new one replaces is kept in `earlier_samples/`, in the same form.

#include "planar_bin_picking/calibrate/hand_eye/hand_eye.h"

#include <string>

namespace planar_bin_picking {

/// One camera's pictures of one board.
struct SampleSet {
  HandEyeProblem problem;    ///< the observations' names are those of the pictures
  std::string camera_frame;  ///< of the images
};

class SampleFolder {
 public:
  explicit SampleFolder(std::string folder) : folder_(std::move(folder)) {}

  /// Makes room for a new set: the one that is there becomes the earlier one.
  /// @throws std::runtime_error  what cannot be moved, and why
  void begin() const;

  /// A name for one more picture, which none in the set has.
  static std::string nextName(const SampleSet& set);

  /// Writes the set, whose last observation is new, and its picture.
  /// @param png  the picture's file
  /// @throws std::runtime_error  as writeTogether(); what was there still is
  void add(const SampleSet& set, const std::string& png) const;

  /// Writes the set, from which one was removed, and removes its picture.
  void remove(const SampleSet& set, const std::string& name) const;

  /// @throws std::runtime_error  nothing is there, or naming file, key and value
  SampleSet load() const;

 private:
  std::string folder_;
};

}  // namespace planar_bin_picking
