// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What came on one topic, to tell what is missing when images and camera_info do not pair.

#include "input/image_inbox.h"

#include <ros/time.h>

#include <array>
#include <cstddef>

namespace planar_bin_picking_ros {

/// The last messages of one topic; not locked.
class Arrivals {
 public:
  void note(const ros::Time& stamp, SteadyTime received);

  std::size_t count() const { return count_; }                        ///< so far
  const ros::Time& stamp() const { return latest_[0].stamp; }         ///< of the newest
  const SteadyTime& received() const { return latest_[0].received; }  ///< when that came

  /// By how much another topic's stamps are newer than this one's, in s. Of the last two messages
  /// of both that came since a moment, those count that came closest together: a driver sends the
  /// two of one shot at once, but over two connections, and whoever looks between them sees the
  /// shot before on one of them. 0 where one of the topics has had none since.
  double lead(const Arrivals& other, SteadyTime since) const;

 private:
  struct Arrival {
    ros::Time stamp;
    SteadyTime received;
  };
  std::array<Arrival, 2> latest_;  ///< newest first
  std::size_t count_ = 0;
};

/// In s; ros::Duration throws where the two are more than 68 years apart.
double between(const ros::Time& earlier, const ros::Time& later);

}  // namespace planar_bin_picking_ros
