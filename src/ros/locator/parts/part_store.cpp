// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/parts/part_store.h"

#include "planar_bin_picking/part/part_summary.h"

#include <ros/console.h>

#include <chrono>
#include <exception>

namespace planar_bin_picking_ros {

namespace {

/// A part or its error, as far as it tells whether anything has changed.
struct State {
  PartPtr part;
  std::string error;
  bool operator==(const State& other) const { return part == other.part && error == other.error; }
};

std::map<std::string, State> statesOf(const PartLibrary& library) {
  std::map<std::string, State> states;
  for (const auto& [name, part] : library.parts()) states[name].part = part;
  for (const auto& [name, error] : library.errors()) states[name].error = error;
  return states;
}

void logState(const std::string& what, const std::string& name, const State& state) {
  if (!state.part) {
    ROS_ERROR_STREAM("part '" << name << "' is not available: " << state.error);
    return;
  }
  const auto summary = planar_bin_picking::describePart(*state.part);
  ROS_INFO_STREAM("part '" << name << "'" << what << ": " << toLine(summary));
  for (const auto& warning : summary.warnings)
    ROS_WARN_STREAM("part '" << name << "': " << warning);
}

}  // namespace

void logChanges(const PartLibrary* before, const PartLibrary& after) {
  const auto old = before == nullptr ? std::map<std::string, State>() : statesOf(*before);
  const auto now = statesOf(after);
  for (const auto& [name, state] : now) {
    const auto was = old.find(name);
    if (was != old.end() && was->second == state) continue;
    logState(before == nullptr ? "" : was == old.end() ? " is new" : " has changed", name, state);
  }
  for (const auto& entry : old)
    if (now.count(entry.first) == 0) ROS_INFO_STREAM("part '" << entry.first << "' is gone");
}

PartStore::PartStore(const std::string& folder, const double poll_seconds)
    : poll_seconds_(poll_seconds), library_(std::make_shared<const PartLibrary>(folder)) {
  logChanges(nullptr, *library_);
  if (poll_seconds_ > 0.0) thread_ = std::thread(&PartStore::watch, this);
}

PartStore::~PartStore() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  end_.notify_all();
  if (thread_.joinable()) thread_.join();
}

std::shared_ptr<const PartLibrary> PartStore::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return library_;
}

std::string PartStore::trouble() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return trouble_;
}

void PartStore::swap(std::shared_ptr<const PartLibrary> next) {
  logChanges(current().get(), *next);
  const std::lock_guard<std::mutex> lock(mutex_);
  library_ = std::move(next);
}

void PartStore::watch() {
  const auto period = std::chrono::duration<double>(poll_seconds_);
  while (true) {
    {
      std::unique_lock<std::mutex> lock(mutex_);
      if (end_.wait_for(lock, period, [this] { return ends_; })) return;
    }
    std::string trouble;
    try {
      look();
    } catch (const std::exception& error) {
      trouble = error.what();
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!trouble.empty() && trouble_.empty())
      ROS_ERROR_STREAM("the parts folder cannot be read, its parts stay as they were: " << trouble);
    trouble_ = trouble;
  }
}

void PartStore::look() {
  const std::lock_guard<std::mutex> lock(reading_);
  const auto library = current();
  FileStamps stamps = stampsIn(library->folder(), library->paths());
  if (stamps == library->stamps()) return;
  // A file that is being written changes from look to look; half of it is no part.
  const bool still_changes = stamps != changing_;
  changing_ = std::move(stamps);
  constexpr bool kAllAnew = false;
  if (!still_changes) swap(std::make_shared<const PartLibrary>(*library, kAllAnew));
}

std::string PartStore::reload() {
  const std::lock_guard<std::mutex> lock(reading_);
  constexpr bool kAllAnew = true;
  auto next = std::make_shared<const PartLibrary>(*current(), kAllAnew);
  std::string text = std::to_string(next->parts().size()) + " parts read";
  for (const auto& [name, error] : next->errors())
    text += "; not available: " + name + ": " + error;
  swap(std::move(next));
  return text;
}

}  // namespace planar_bin_picking_ros
