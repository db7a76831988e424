// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "hdr/exposure_control.h"

#include "shared/timed_call.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <planar_bin_picking/SetExposure.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace planar_bin_picking_ros {

using dynamic_reconfigure::Reconfigure;
using planar_bin_picking::SetExposure;

namespace {

constexpr double kRounding = 0.02;  // relative: cameras have their own steps

std::string milliseconds(const double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g ms", 1e3 * seconds);
  return text;
}

/// The one parameter of a driver's configuration, an int or a double.
template <class List>
auto find(List& list, const std::string& name) -> decltype(&list[0]) {
  for (auto& entry : list)
    if (entry.name == name) return &entry;
  return nullptr;
}

std::string numbersIn(const dynamic_reconfigure::Config& config) {
  std::string names;
  for (const auto& entry : config.ints) names += " " + entry.name;
  for (const auto& entry : config.doubles) names += " " + entry.name;
  return names.empty() ? " none" : names;
}

}  // namespace

ExposureControl::ExposureControl(const ros::NodeHandle& nh, const HdrNodeParams& params)
    : params_(params),
      nh_(nh),
      service_(nh.resolveName(params.hasService() ? params.exposure_service
                                                  : params.camera_node + "/set_parameters")) {}

template <class Service>
void ExposureControl::call(Service* service) {
  switch (callWithin(nh_, service_, params_.command_timeout, service)) {
    case CallEnd::kAnswered:
      return;
    case CallEnd::kNobody:
      throw std::runtime_error("nobody offers " + service_ +
                               "; start the camera's driver, or correct ~hdr/camera_node or "
                               "~hdr/exposure_service");
    case CallEnd::kLate:
      throw std::runtime_error(service_ + " did not answer within " +
                               milliseconds(params_.command_timeout) +
                               "; look at the camera's driver, or raise ~hdr/command_timeout");
    case CallEnd::kFailed:
      break;
  }
  throw std::runtime_error(service_ + " failed; see the log of its node");
}

double ExposureControl::single() {
  double now = 0.0;
  if (!params_.hasService()) {
    Reconfigure nothing;  // changes nothing, and is answered with all there is
    call(&nothing);
    now = secondsIn(nothing.response.config);
  }
  if (params_.single_ms > 0.0) return 1e-3 * params_.single_ms;
  if (now > 0.0 && std::isfinite(now)) return now;
  throw std::runtime_error("the camera says that its exposure is " + milliseconds(now) +
                           "; switch its automatic exposure off, or set ~hdr/single_ms");
}

double ExposureControl::secondsIn(const dynamic_reconfigure::Config& config) {
  const auto* real = find(config.doubles, params_.exposure_parameter);
  const auto* whole = find(config.ints, params_.exposure_parameter);
  if (real == nullptr && whole == nullptr) {
    throw std::runtime_error("~hdr/exposure_parameter is '" + params_.exposure_parameter +
                             "', but " + service_ + " has these numbers:" + numbersIn(config));
  }
  is_whole_ = whole != nullptr;
  return (is_whole_ ? whole->value : real->value) * params_.exposure_unit_seconds;
}

double ExposureControl::command(const double seconds) {
  if (params_.hasService()) {
    SetExposure service;
    service.request.seconds = seconds;
    call(&service);
    if (service.response.success) return service.response.seconds;
    throw std::runtime_error(service_ + " refused " + milliseconds(seconds) + ": " +
                             service.response.message);
  }
  Reconfigure service;
  const double value = seconds / params_.exposure_unit_seconds;
  if (is_whole_ && std::abs(value) > std::numeric_limits<std::int32_t>::max()) {
    throw std::runtime_error(milliseconds(seconds) + " is more than " + params_.exposure_parameter +
                             " can hold; correct ~hdr/exposure_unit_seconds");
  }
  if (is_whole_) {
    service.request.config.ints.resize(1);
    service.request.config.ints[0].name = params_.exposure_parameter;
    service.request.config.ints[0].value = static_cast<int>(std::lround(value));
  } else {
    service.request.config.doubles.resize(1);
    service.request.config.doubles[0].name = params_.exposure_parameter;
    service.request.config.doubles[0].value = value;
  }
  call(&service);
  return secondsIn(service.response.config);
}

void ExposureControl::set(const double seconds) {
  const double used = command(seconds);
  if (std::abs(used - seconds) <= kRounding * seconds) return;
  throw std::runtime_error("asked for " + milliseconds(seconds) + ", the camera says " +
                           milliseconds(used) +
                           "; check its limits, its automatic exposure and "
                           "~hdr/exposure_unit_seconds");
}

}  // namespace planar_bin_picking_ros
