// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A service call that ends in time, also when the other node hangs: roscpp's own waits for ever.

#include <ros/node_handle.h>

#include <chrono>
#include <future>
#include <string>

namespace planar_bin_picking_ros {

enum class CallEnd {
  kAnswered,
  kNobody,  ///< no node offers the service
  kFailed,  ///< the other node went away or reported an error
  kLate,    ///< no answer in time; the call was broken off
};

/// @param seconds  wall time
/// @param service  its response is filled in where the call is answered
template <class Service>
CallEnd callWithin(ros::NodeHandle nh, const std::string& name, double seconds, Service* service) {
  constexpr bool kPersistent = true;  // only then does shutdown() end a call that waits
  ros::ServiceClient client = nh.serviceClient<Service>(name, kPersistent);
  if (!client.isValid()) return CallEnd::kNobody;
  auto answered = std::async(std::launch::async, [&] { return client.call(*service); });
  const bool is_late =
      answered.wait_for(std::chrono::duration<double>(seconds)) != std::future_status::ready;
  if (is_late) client.shutdown();
  if (answered.get()) return CallEnd::kAnswered;
  return is_late ? CallEnd::kLate : CallEnd::kFailed;
}

}  // namespace planar_bin_picking_ros
