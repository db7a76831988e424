// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_services.h"

#include "planar_bin_picking/part/part_summary.h"
#include "shared/names.h"

#include <chrono>
#include <exception>

namespace planar_bin_picking_ros {

using planar_bin_picking::ListParts;
using planar_bin_picking::PartInfo;

namespace {

ros::Time toTime(const std::chrono::system_clock::time_point& time) {
  ros::Time stamp;
  const auto since = std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch());
  stamp.fromNSec(static_cast<std::uint64_t>(since.count()));
  return stamp;
}

}  // namespace

PartServices::PartServices(PartStore& store, ros::NodeHandle nh, ros::NodeHandle prompt_nh)
    : store_(store),
      list_(prompt_nh.advertiseService(kListPartsService, &PartServices::serveList, this)),
      reload_(nh.advertiseService(kReloadPartsService, &PartServices::serveReload, this)),
      pictures_(store, nh) {}

bool PartServices::serveList(ListParts::Request&, ListParts::Response& response) {
  const auto library = store_.current();
  for (const auto& [name, part] : library->parts()) {
    const auto summary = planar_bin_picking::describePart(*part);
    PartInfo info;
    info.name = name;
    info.available = true;
    info.text = toLine(summary);
    info.pick_poses = summary.pick_poses;
    info.warnings = summary.warnings;
    info.read_at = toTime(library->readAt(name));
    response.parts.push_back(info);
  }
  for (const auto& [name, error] : library->errors()) {
    PartInfo info;
    info.name = name;
    info.available = false;
    info.text = error;
    info.read_at = toTime(library->readAt(name));
    response.parts.push_back(info);
  }
  return true;
}

bool PartServices::serveReload(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  try {
    response.message = store_.reload();
    response.success = store_.current()->errors().empty();
  } catch (const std::exception& error) {
    response.success = false;
    response.message = std::string("the parts stay as they were: ") + error.what();
  }
  return true;
}

}  // namespace planar_bin_picking_ros
