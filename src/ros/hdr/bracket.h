// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Takes an exposure bracket: commands each exposure and waits for the frame that really has it.
/// That a camera has answered a command says little about the next frame, which may have been under
/// way for long; so each frame is held against one of a known exposure (exposureRatio in hdr.h).

#include "hdr/hdr_node_params.h"
#include "input/image_inbox.h"

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// A frame and the exposure that it was taken with.
struct ExposedFrame {
  Frame frame;
  double seconds = 0.0;
};

/// Why there is no bracket. The single exposure is there all the same.
class BracketFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class BracketTaker {
 public:
  using SetExposure = std::function<void(double seconds)>;
  using Ask = std::function<void()>;

  /// @param set    throws std::runtime_error where the camera does not take the command in
  /// @param ask    called before each wait for a frame; nothing where the camera runs freely
  /// @param inbox  where frames come in; outlives this
  BracketTaker(const HdrNodeParams& params, SetExposure set, Ask ask, ImageInbox* inbox)
      : params_(params), set_(std::move(set)), ask_(std::move(ask)), inbox_(inbox) {}

  /// The next frame, with the exposure that the camera has.
  /// @throws std::runtime_error  none came within frame_timeout
  ExposedFrame takeSingle(double seconds);

  /// All exposures, the single one's first, within bracket_timeout. Sets the single exposure again
  /// afterwards, whatever came before, and waits until a frame has it, so that the next call finds
  /// it. For each exposure it waits for frame_timeout, and asks for triggers_max frames at most.
  /// @throws BracketFailure  a command failed, or no frame with that exposure came in time
  std::vector<ExposedFrame> take(const ExposedFrame& single);

 private:
  /// What became of one exposure so far.
  struct Tally {
    int count = 0;       ///< frames
    double shown = 0.0;  ///< exposure that the newest shows, seconds; 0 = none shows one
  };
  ExposedFrame takeOne(double seconds, const std::vector<ExposedFrame>& known);
  bool mayAsk(const Tally& tally, SteadyTime deadline) const;
  bool hasExposure(const Frame& frame, double seconds, const ExposedFrame& reference,
                   Tally* tally) const;
  std::string failure(double seconds, const Tally& tally) const;

  const HdrNodeParams& params_;
  SetExposure set_;
  Ask ask_;
  ImageInbox* inbox_;
};

}  // namespace planar_bin_picking_ros
