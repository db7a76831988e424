// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace planar_bin_picking {

/// Calls body(i) for 0 <= i < n on `threads` threads. Which thread takes which i is open, so a body
/// writes to its own i only; the first exception is rethrown. Where the system starts no more
/// threads (a container's limit of processes), those that run do all of it.
/// @param start  makes a std::thread that runs a function, as std::thread's constructor does
template <class Body, class Start>
void parallelFor(int n, int threads, Body&& body, Start&& start) {
  threads = std::min(threads, n);
  if (threads <= 1) {
    for (int i = 0; i < n; ++i) body(i);
    return;
  }
  std::atomic<int> next{0};
  std::atomic<bool> failed{false};
  std::exception_ptr error;
  const auto work = [&] {
    try {
      for (int i = next++; i < n && !failed; i = next++) body(i);
    } catch (...) {
      if (!failed.exchange(true)) error = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  others.reserve(static_cast<std::size_t>(threads) - 1);  // nothing may throw once one runs
  try {
    for (int k = 1; k < threads; ++k) others.push_back(start(work));
  } catch (const std::system_error&) {
    // The answer is the same on fewer threads, only later.
  }
  work();
  for (auto& thread : others) thread.join();
  if (error) std::rethrow_exception(error);
}

template <class Body>
void parallelFor(int n, int threads, Body&& body) {
  parallelFor(n, threads, body, [](const auto& work) { return std::thread(work); });
}

}  // namespace planar_bin_picking
