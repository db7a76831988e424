// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How the locator is, on /diagnostics: its camera, its parts, its calls; and ~parameters, what is
/// in force. Nothing that a robot waits for.

#include "input/image_source.h"
#include "locator/parts/part_store.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_bin_picking/LocatePart.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <map>
#include <mutex>
#include <string>

namespace planar_bin_picking_ros {

class Health {
 public:
  struct Cell {
    bool has_trigger = false;  ///< images come on request only
    std::string settings;      ///< what ~parameters answers
  };

  /// @param nh  its callback queue publishes, once a second
  Health(const ImageSource& source, const PartStore& parts, Cell cell, ros::NodeHandle nh);

  /// A call was answered. Any thread.
  void called(const planar_bin_picking::LocatePart::Response& response);

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  void camera(Status& status);
  void parts(Status& status) const;
  void calls(Status& status);

  const ImageSource& source_;
  const PartStore& parts_;
  const Cell cell_;
  std::size_t images_ = 0;  ///< at the last look
  SteadyTime looked_ = std::chrono::steady_clock::now();

  std::mutex mutex_;  ///< guards these three
  planar_bin_picking::LocatePart::Response latest_;
  SteadyTime called_;
  std::map<std::uint8_t, std::size_t> by_status_;

  diagnostic_updater::Updater updater_;
  ros::WallTimer timer_;
  ros::ServiceServer parameters_;
};

}  // namespace planar_bin_picking_ros
