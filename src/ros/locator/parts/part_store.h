// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The parts folder as it is now. A file that comes, changes or goes is read in a thread beside the
/// calls; then the new library takes the place of the old one at once, and calls that are under way
/// go on with the one that they began with.
///
/// A part whose changed file is broken is no longer available: what the old file said is known to
/// be wrong, and a robot must not go to a pick pose that somebody has just corrected.

#include "locator/parts/part_library.h"

#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace planar_bin_picking_ros {

class PartStore {
 public:
  /// @param poll_seconds  how often the folder is looked at; 0 = never, only on reload()
  /// @throws std::runtime_error  as PartLibrary
  PartStore(const std::string& folder, double poll_seconds);
  ~PartStore();
  PartStore(const PartStore&) = delete;
  PartStore& operator=(const PartStore&) = delete;

  std::shared_ptr<const PartLibrary> current() const;

  /// Reads all files anew and waits for it. @return  what came of it, in one line
  /// @throws std::exception  the folder cannot be read; the parts stay as they are
  std::string reload();

  /// Why the folder cannot be looked at at the moment; "" where it can.
  std::string trouble() const;

 private:
  void watch();
  void look();
  void swap(std::shared_ptr<const PartLibrary> next);

  const double poll_seconds_;
  std::mutex reading_;        ///< one reads at a time; taken before mutex_
  FileStamps changing_;       ///< seen last, where they differ from the library's
  mutable std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<const PartLibrary> library_;
  std::string trouble_;
  bool ends_ = false;
  std::condition_variable end_;
  std::thread thread_;
};

/// Each part that came, changed or went, in one line of the log, and its warnings.
void logChanges(const PartLibrary* before, const PartLibrary& after);

}  // namespace planar_bin_picking_ros
