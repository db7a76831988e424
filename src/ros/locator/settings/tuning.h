// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What an operator may change while the locator runs, by dynamic_reconfigure (~tuning): the
/// numbers that config/Tuning.cfg names. Their defaults and ranges are those of the one list of
/// parameters. A change is checked as a whole, and refused as a whole; then all stays as it was.

#include "locator/settings/settings.h"

#include <planar_bin_picking/TuningConfig.h>

#include <dynamic_reconfigure/server.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>
#include <boost/thread/recursive_mutex.hpp>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class Tuning {
 public:
  /// @param nh  its callback queue serves changes and ~save_parameters
  /// @throws std::logic_error  config/Tuning.cfg names what is no parameter
  Tuning(Settings start, const ros::NodeHandle& nh);

  /// The bin stands elsewhere than its frame from now on, or there again.
  /// @param bin_found  as CellParams has it
  void useBin(std::vector<double> bin_found);

  /// As they are now. Whoever holds them sees no change. Any thread.
  std::shared_ptr<const Settings> current() const;

 private:
  using Config = planar_bin_picking::TuningConfig;
  void change(Config& config);
  bool save(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// @return  what was written
  std::string saveChanges();

  mutable std::mutex mutex_;  ///< guards the pointer
  std::shared_ptr<const Settings> current_;
  Settings saved_;  ///< as the files have them
  ros::NodeHandle nh_;
  boost::recursive_mutex server_mutex_;
  dynamic_reconfigure::Server<Config> server_;
  ros::ServiceServer save_service_;
};

}  // namespace planar_bin_picking_ros
