// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// ROS time may be set back: a bag that starts over, a simulator that is reset, a clock that is
/// corrected. What was kept before has stamps from the future then, and would pass for new.

#include <ros/time.h>

#include <mutex>

namespace planar_bin_picking_ros {

/// Any number of threads.
class ClockWatch {
 public:
  /// Whether the clock was set back since the last call.
  bool wentBack() {
    const std::lock_guard<std::mutex> lock(mutex_);
    const ros::Time now = ros::Time::now();  // under the lock, or two threads would seem to go back
    const bool back = now < last_;
    last_ = now;
    return back;
  }

 private:
  std::mutex mutex_;
  ros::Time last_;
};

}  // namespace planar_bin_picking_ros
