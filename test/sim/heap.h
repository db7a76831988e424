// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The parts in the bin as rigid bodies (Bullet): poured, settled, taken out, pushed. The same seed
/// and the same calls give the same poses to the last bit.
///
/// Frame `base`: z up, origin in the middle of the bin's floor. Metres, seconds, kilograms.

#include "sim/solid.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace planar_bin_picking::cell {

/// An open box; its walls are this thick, outside.
struct Bin {
  double length = 0.40, width = 0.30, height = 0.12;  ///< inside, along x, y, z
  double wall = 0.01;
};

struct Body {
  int id = 0;    ///< never used again
  int kind = 0;  ///< index of its shape
  Eigen::Isometry3d T_base_part = Eigen::Isometry3d::Identity();
};

class Heap {
 public:
  /// @param shapes   finely or coarsely drawn: chords count as they are
  /// @param density  kg / m^3
  Heap(const Bin& bin, const std::vector<Shape>& shapes, std::uint64_t seed,
       double density = 7800.0);
  ~Heap();
  Heap(const Heap&) = delete;
  Heap& operator=(const Heap&) = delete;

  /// Pours that many parts of a kind, one after the other, from random poses, and lets them settle.
  void pour(int kind, int count);
  /// Puts one part there, at rest, without letting anything move.
  /// @return  its id
  int put(int kind, const Eigen::Isometry3d& T_base_part);
  /// Lets all move until it rests, at most that many seconds of its time.
  /// @return  whether it came to rest
  bool settle(double seconds_max);
  /// Takes a part out and lets the heap settle. @throws std::out_of_range  no such id
  void remove(int id);
  /// Pushes a part at a point and lets the heap settle.
  /// @param speed_base  that the part gets there, m/s
  void push(int id, const Eigen::Vector3d& point_base, const Eigen::Vector3d& speed_base);

  std::vector<Body> bodies() const;  ///< by id
  /// Weight of what lies on a part, in units of its own weight: forces at its contacts from above.
  /// What leans with its own rim on the rim of the part is left out (it slides off), and so is what
  /// rests where only the collision shapes have material.
  double load(int id) const;
  /// How deep the deepest contact reaches into another body, metres.
  double deepestPenetration() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace planar_bin_picking::cell
