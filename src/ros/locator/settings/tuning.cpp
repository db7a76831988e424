// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/settings/tuning.h"

#include "locator/settings/yaml_edit.h"
#include "shared/names.h"

#include <ros/console.h>

#include <sstream>
#include <stdexcept>
#include <utility>

namespace planar_bin_picking_ros {

using planar_bin_picking::TuningConfig;

namespace {

std::map<std::string, double> numbersIn(const TuningConfig& config) {
  dynamic_reconfigure::Config message;
  config.__toMessage__(message);
  std::map<std::string, double> numbers;
  for (const auto& entry : message.ints) numbers[entry.name] = entry.value;
  for (const auto& entry : message.doubles) numbers[entry.name] = entry.value;
  return numbers;
}

/// @param pick  which of a Number's numbers
TuningConfig configOf(const std::map<std::string, Number>& numbers, double Number::*pick) {
  TuningConfig config;
  dynamic_reconfigure::Config message;
  config.__toMessage__(message);
  const auto fill = [&](auto& entries) {
    for (auto& entry : entries) {
      const auto found = numbers.find(entry.name);
      entry.value = 0;
      if (found != numbers.end())
        entry.value = static_cast<decltype(entry.value)>(found->second.*pick);
    }
  };
  fill(message.ints);
  fill(message.doubles);
  config.__fromMessage__(message);
  return config;
}

/// All numbers that a locator may have, also the lists that this one's cell has not.
std::map<std::string, Number> possibleNumbers(Settings settings) {
  if (settings.cell.bin_min.empty())
    settings.cell.bin_min = settings.cell.bin_max = {0.0, 0.0, 0.0};
  return numbersOf(settings);
}

/// "score_min 0 -> 0.7, ..."
std::string differences(const std::map<std::string, Number>& before,
                        const std::map<std::string, Number>& after) {
  std::ostringstream text;
  for (const auto& [name, number] : after) {
    const auto found = before.find(name);
    if (found == before.end() || found->second.value == number.value) continue;
    text << (text.str().empty() ? "" : ", ") << name << " " << found->second.value << " -> "
         << number.value;
  }
  return text.str();
}

XmlRpc::XmlRpcValue asParameter(const std::string& yaml) {
  XmlRpc::XmlRpcValue value;
  if (yaml == "[]") {
    value.setSize(0);
    return value;
  }
  if (yaml.front() != '[') {
    if (yaml.find('.') == std::string::npos) return std::stoi(yaml);
    std::istringstream in(yaml);
    in.imbue(std::locale::classic());
    double number = 0.0;
    in >> number;
    return number;
  }
  std::istringstream in(yaml.substr(1));
  int i = 0;
  for (std::string item; std::getline(in, item, ',');)
    value[i++] = asParameter(item.substr(item.find_first_not_of(' ')));
  return value;
}

}  // namespace

Tuning::Tuning(Settings start, const ros::NodeHandle& nh)
    : current_(std::make_shared<const Settings>(start)),
      saved_(std::move(start)),
      nh_(nh),
      server_(server_mutex_, ros::NodeHandle(nh, kTuningName)) {
  const auto numbers = possibleNumbers(*current_);
  for (const auto& entry : numbersIn(TuningConfig::__getDefault__())) {
    if (numbers.count(entry.first) == 0)
      throw std::logic_error("config/Tuning.cfg: '" + entry.first + "' is no parameter");
  }
  // What the parameter server still has of an earlier process does not count; the files do.
  TuningConfig now = configOf(numbers, &Number::value);
  server_.updateConfig(now);
  server_.setConfigDefault(now);
  server_.setConfigMin(configOf(numbers, &Number::min));
  server_.setConfigMax(configOf(numbers, &Number::max));
  server_.setCallback([this](TuningConfig& config, std::uint32_t) { change(config); });
  save_service_ = nh_.advertiseService(kSaveParametersService, &Tuning::save, this);
}

std::shared_ptr<const Settings> Tuning::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return current_;
}

void Tuning::useBin(std::vector<double> bin_found) {
  const boost::recursive_mutex::scoped_lock no_change(server_mutex_);  // which change() holds, too
  Settings settings = *current();
  settings.cell.bin_found = std::move(bin_found);
  const std::lock_guard<std::mutex> lock(mutex_);
  current_ = std::make_shared<const Settings>(std::move(settings));
}

void Tuning::change(Config& config) {
  const auto before = current();
  try {
    const auto after = std::make_shared<const Settings>(withNumbers(*before, numbersIn(config)));
    const std::string text = differences(numbersOf(*before), numbersOf(*after));
    config.refused = "";
    if (text.empty()) return;
    ROS_INFO_STREAM("tuning: " << text << "; from the next call on");
    const std::lock_guard<std::mutex> lock(mutex_);
    current_ = after;
  } catch (const std::invalid_argument& error) {
    config = configOf(possibleNumbers(*before), &Number::value);
    config.refused = error.what();
    ROS_WARN_STREAM("tuning: nothing is changed: " << error.what());
  }
}

bool Tuning::save(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  try {
    response.message = saveChanges();
    response.success = true;
    ROS_INFO_STREAM(kSaveParametersService << ": " << response.message);
  } catch (const std::exception& error) {
    response.message = error.what();
    ROS_WARN_STREAM(kSaveParametersService << ": " << response.message);
  }
  return true;
}

std::string Tuning::saveChanges() {
  const auto now = current();
  const std::string& file = now->cell.cell_file;
  if (file.empty())
    throw std::runtime_error(
        "there is no file of this cell to save to: start it with cell.launch cell:=FILE, or set "
        "~cell/cell_file");
  std::map<YamlPath, std::string> changed = yamlOf(*now);
  const auto before = yamlOf(saved_);
  for (auto entry = changed.begin(); entry != changed.end();) {
    entry = before.at(entry->first) == entry->second ? changed.erase(entry) : std::next(entry);
  }
  if (changed.empty()) return "nothing has been changed since " + file + " was read or saved";
  saveYamlValues(file, changed);
  std::string keys;
  for (const auto& [path, value] : changed) {
    std::string key = kCellParams;
    for (const std::string& part : path) key += "/" + part;
    nh_.setParam(key, asParameter(value));  // for this node when it is started again
    keys += (keys.empty() ? "" : ", ") + key.substr(key.find('/') + 1) + ": " + value;
  }
  saved_ = *now;
  return "saved to " + file + ": " + keys;
}

}  // namespace planar_bin_picking_ros
