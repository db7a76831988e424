// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace planar_bin_picking::cell {

/// Calls body(row) for all rows, on all cores. A body writes to its own row only.
template <class Body>
void forEachRow(int rows, Body&& body) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int row = next++; row < rows; row = next++) body(row);
  };
  std::vector<std::thread> others;
  for (unsigned i = 1; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
    others.emplace_back(work);
  work();
  for (auto& other : others) other.join();
}

}  // namespace planar_bin_picking::cell
