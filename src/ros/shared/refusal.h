// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Why a call got no poses: a status of LocatePart, and what the caller can do about it. Thrown by
/// the steps of a call, turned into the answer at one place (locator_ros.cpp).

#include <cstdint>
#include <stdexcept>
#include <string>

namespace planar_bin_picking_ros {

class Refusal : public std::runtime_error {
 public:
  Refusal(std::uint8_t status, const std::string& message)
      : std::runtime_error(message), status_(status) {}
  std::uint8_t status() const { return status_; }

 private:
  std::uint8_t status_;
};

}  // namespace planar_bin_picking_ros
