// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The accumulator's side of voting: what an edgel map gives to a raster point that lies at some
/// cell, and sums of that over many points for many neighbouring positions at once.

#include "image/edge_map.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace planar_bin_picking {

inline constexpr int kMaxVote = 3;  // votes of a raster point that lies right on an edgel

/// Votes by direction on a grid of half cells, split by phase so that whole cells are neighbours.
/// About them lie empty cells, for raster points out of the picture: those before a row are also
/// those behind the row before, and those above a plane also those below the plane before.
struct VotePlanes {
  double half = 1.0;  // half a cell, field pixels
  int rows = 0, cols = 0, pad = 0, pitch = 0;
  std::size_t plane = 0;
  std::vector<std::uint8_t> votes;  // [direction][phase y][phase x][pad + rows][pitch], and a pad

  std::size_t offset(int direction, int hx, int hy) const {
    const int phase = (hy & 1) * 2 + (hx & 1);
    return (static_cast<std::size_t>(direction) * 4 + phase) * plane +
           static_cast<std::size_t>((hy >> 1) + pad) * pitch + (hx >> 1) + pad;
  }
  std::size_t bytes() const {
    return 4 * kDirections * plane + static_cast<std::size_t>(pad + 1) * pitch;
  }
};

/// Sizes only, no votes yet: these take memory.
/// @param half      half a cell, field pixels
/// @param reach_px  of a raster point from the centre it votes for, at most
VotePlanes sizePlanes(const Field& field, double half, double reach_px);

/// @param tolerance_px  an edgel this far off a raster point still counts a little
void fillPlanes(const Field& field, double tolerance_px, int threads, VotePlanes* planes);

/// Positions of a row whose sums are made at a time, in registers.
inline constexpr int kChunk = 64;
inline constexpr int kMaxPoints = 85;  // whose votes fit into a byte

/// Of raster points from the centre that they vote for.
struct Offsets {
  const std::int32_t* begin;
  int count;
};

/// What the votes of a position must exceed to be the best of its tile, over a row of positions.
class PruningThresholds {
 public:
  PruningThresholds(int columns, int floor) : best_(columns), first_(columns) {
    set(0, columns, std::max(0, floor - 1));
  }
  void set(int column, int count, int votes);
  std::uint8_t best(int column) const { return best_[column]; }

 private:
  friend bool sumChunk(const std::uint8_t*, const Offsets&, const PruningThresholds&, int,
                       std::array<std::uint8_t, kChunk>*);
  std::vector<std::uint8_t> best_, first_;  // after all points, after the first ones
};

/// Votes of raster points that lie `offsets` past the centre, for kChunk centres from `base` on,
/// the first of them in `column`.
/// @return  whether any exceeds its threshold; false, too, where none comes near after the first
/// third
bool sumChunk(const std::uint8_t* base, const Offsets& offsets, const PruningThresholds& thresholds,
              int column, std::array<std::uint8_t, kChunk>* sums);

}  // namespace planar_bin_picking
