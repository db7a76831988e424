// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A folder in which the latest snapshots are kept, and no more than so many of so much size.

#include <cstdint>
#include <string>
#include <vector>

namespace planar_bin_picking {

class SnapshotRing {
 public:
  /// @param count  snapshots at most; at least 1
  /// @param bytes  of all together; the latest one is kept whatever its size
  /// @param hours  that one is kept; 0 = for ever
  /// @throws std::runtime_error  the folder cannot be made or written to
  SnapshotRing(std::string folder, std::size_t count, std::uint64_t bytes, double hours = 0.0);

  /// A path for the next snapshot, later in order than all there are.
  /// @param seconds  since the epoch
  /// @param reason   a word
  std::string nextPath(double seconds, const std::string& reason) const;

  /// Removes the oldest ones beyond the limits. Whatever else lies in the folder is left alone.
  /// @param now  seconds since the epoch
  void trim(double now) const;

  std::vector<std::string> paths() const;  ///< of the snapshots, the oldest first

 private:
  std::string folder_;
  std::size_t count_;
  std::uint64_t bytes_;
  double hours_;
};

}  // namespace planar_bin_picking
