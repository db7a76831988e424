// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The pictures that a calibration is made of, in memory and in output_folder. A set lasts until a
/// calibration was made of it, or another one begins.

#include "calibrator/board_look.h"
#include "planar_bin_picking/calibrate/sample_folder.h"

#include <optional>
#include <string>

namespace planar_bin_picking_ros {

/// All pictures of a set are of one camera.
/// @throws std::runtime_error  another frame or size
void checkCamera(const planar_bin_picking::SampleSet& set, const Look& look);

class SampleStore {
 public:
  explicit SampleStore(const CalibratorParams& params);

  std::size_t size() const { return set_ ? set_->problem.observations.size() : 0; }
  bool isEmpty() const { return size() == 0; }
  /// @pre not empty, or just begun
  const planar_bin_picking::SampleSet& set() const { return *set_; }

  /// A new set of this camera; what is in the folder is set aside.
  void begin(const planar_bin_picking::HandEyeProblem& empty, const Frame& frame);

  /// Adds the picture, to a new set where there is none.
  /// @return  its name
  /// @throws std::runtime_error  another camera; the disk does not take it: it is kept in memory
  std::string add(const Look& look, const planar_bin_picking::HandEyeProblem& empty);

  /// @param number  from 1; 0 = all
  void remove(std::size_t number);

  /// Goes on with the set in the folder.
  /// @throws std::runtime_error  nothing is there, or it is of another board or mounting
  void load();

  /// What was taken is a calibration now; whatever comes next is a new set.
  void close() { set_.reset(); }

  std::string list() const;      ///< one line each
  std::string keptText() const;  ///< "; 7 samples are kept: ~finish solves them", or ""

 private:
  const CalibratorParams& params_;
  const planar_bin_picking::SampleFolder folder_;
  std::optional<planar_bin_picking::SampleSet> set_;
};

}  // namespace planar_bin_picking_ros
