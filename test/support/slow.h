// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace planar_bin_picking {

/// By how much sanitizers may slow a program down; limits of time are stretched by it.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr double kSlow = 10.0;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr double kSlow = 10.0;
#else
inline constexpr double kSlow = 1.0;
#endif
#else
inline constexpr double kSlow = 1.0;
#endif

}  // namespace planar_bin_picking
