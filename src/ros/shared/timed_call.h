// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A service call that ends in time, also when the other node hangs: roscpp's own waits for ever.

#include "shared/service_call.h"

#include <ros/node_handle.h>

#include <chrono>
#include <string>

namespace planar_bin_picking_ros {

/// @param seconds  wall time
/// @param service  its response is filled in where the call is answered
template <class Service>
CallEnd callWithin(const ros::NodeHandle& nh, const std::string& name, double seconds,
                   Service* service) {
  const auto limit = std::chrono::duration_cast<std::chrono::steady_clock::duration>(
      std::chrono::duration<double>(seconds));
  ServiceCall<Service> call(nh.resolveName(name), service->request);
  if (!call.waitUntil(std::chrono::steady_clock::now() + limit)) return CallEnd::kLate;
  if (call.end() == CallEnd::kAnswered) service->response = call.response();
  return call.end();
}

}  // namespace planar_bin_picking_ros
