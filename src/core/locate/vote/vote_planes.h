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
///
/// Two neighbouring cells share a byte, since the bytes that come from the second cache make the
/// time of a vote: in one copy the right one of them is odd, in the other even.
struct VotePlanes {
  double half = 1.0;  // half a cell, field pixels
  int rows = 0, cols = 0;
  int pad = 0, pitch = 0;  // even, so that a cell is as odd as its column
  std::size_t plane = 0;   // cells
  std::size_t copy = 0;    // bytes
  // [copy][direction][phase y][phase x][pad + rows][pitch / 2], and a pad
  std::vector<std::uint8_t> votes;

  /// Cells from the first of all to this one.
  std::size_t offset(int direction, int hx, int hy) const {
    const int phase = (hy & 1) * 2 + (hx & 1);
    return (static_cast<std::size_t>(direction) * 4 + phase) * plane +
           static_cast<std::size_t>((hy >> 1) + pad) * pitch + (hx >> 1) + pad;
  }
  /// The byte whose lower half is this cell, and the upper one its right neighbour.
  std::size_t byteOf(std::size_t cell) const { return (cell & 1) * copy + (cell >> 1); }
  std::size_t bytes() const { return 2 * copy; }
};

/// Sizes only, no votes yet: these take memory.
/// @param half      half a cell, field pixels
/// @param reach_px  of a raster point from the centre it votes for, at most
VotePlanes sizePlanes(const Field& field, double half, double reach_px);

/// @param tolerance_px  an edgel this far off a raster point still counts a little
void fillPlanes(const Field& field, double tolerance_px, int threads, VotePlanes* planes);

/// Positions of a row that are judged together.
inline constexpr int kChunk = 64;
inline constexpr int kMaxPoints = 85;  // whose votes fit into a byte

/// Of raster points from the centre that they vote for: bytes, for centres in columns that are as
/// odd as those of the view's range.
struct Offsets {
  const std::int32_t* begin;
  int count;
};

/// The cells that a view's centre may take.
struct Range {
  int row0 = 0, row1 = 0, col0 = 0, col1 = 0;
};

/// What the votes of a position must exceed to be the best of its tile, over a row of positions.
class PruningThresholds {
 public:
  PruningThresholds(int columns, int floor) : best_(columns), first_(columns) {
    set(0, columns, std::max(0, floor - 1));
  }
  void set(int column, int count, int votes);
  std::uint8_t best(int column) const { return *bestFrom(column); }
  /// Of every other column from this one on: after all points, and after the first third.
  const std::uint8_t* bestFrom(int column) const { return best_.from(column); }
  const std::uint8_t* firstFrom(int column) const { return first_.from(column); }
  /// Whether any of a chunk's votes after the first third is enough to go on.
  bool anyGoesOn(const std::uint8_t* first, int column) const;

 private:
  /// Even columns, then odd ones, as votes are packed.
  struct Row {
    explicit Row(int columns) : half(columns / 2 + 1), values(2 * half) {}
    void fill(int column, int count, std::uint8_t value);
    const std::uint8_t* from(int column) const {
      return values.data() + (column & 1) * half + (column >> 1);
    }
    int half;
    std::vector<std::uint8_t> values;
  };
  Row best_, first_;
};

/// Votes of one view, chunk after chunk of the centres in its range.
class VoteScan {
 public:
  VoteScan(const VotePlanes& planes, const Offsets& offsets, const Range& range)
      : planes_(planes), offsets_(offsets), range_(range), row_(range.row0), col_(range.col0) {}

  /// By column: votes after the first third and after all, and what of these is enough.
  struct Chunk {
    bool is_found = false;  ///< some come near after the first third, and some are enough; else ...
    std::array<std::uint8_t, kChunk> first, all, is_enough;  ///< ... these are not set
  };
  /// Side by side.
  struct Chunks {
    int row, col;
    std::array<Chunk, 2> chunks;
  };
  /// The next chunks of which one is found.
  /// @return  false where there are no more
  bool next(const PruningThresholds& thresholds, Chunks* out);

 private:
  const VotePlanes& planes_;
  Offsets offsets_;
  Range range_;
  int row_, col_;
};

}  // namespace planar_bin_picking
