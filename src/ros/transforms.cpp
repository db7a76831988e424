// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "transforms.h"

#include "convert.h"

#include <tf2/exceptions.h>

#include <thread>

namespace planar_bin_picking_ros {

namespace {

/// tf2 ends its messages with a stop and a space, and ours go on after it.
std::string trimmed(std::string message) {
  message.erase(message.find_last_not_of(". ") + 1);
  return message;
}

}  // namespace

LookupResult lookup(const tf2::BufferCore& buffer, const std::string& target,
                    const std::string& source, const ros::Time& stamp,
                    const std::chrono::duration<double> timeout) {
  // To tf2 a zero stamp means "the latest", which is what must never be answered.
  if (stamp.isZero()) return {std::nullopt, "the image has no stamp"};
  // tf2_ros::Buffer's own time-out counts ROS time and would never end while a bag is paused.
  constexpr std::chrono::milliseconds kPeriod(5);
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (true) {
    try {
      return {fromMsg(buffer.lookupTransform(target, source, stamp).transform), ""};
    } catch (const tf2::TransformException& error) {
      if (std::chrono::steady_clock::now() >= deadline)
        return {std::nullopt, trimmed(error.what())};
    }
    std::this_thread::sleep_for(kPeriod);
  }
}

}  // namespace planar_bin_picking_ros
