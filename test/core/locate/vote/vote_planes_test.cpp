// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/vote/vote_planes.h"

#include <gtest/gtest.h>

#include <random>

namespace planar_bin_picking {
namespace {

struct Point {
  int direction, hx, hy;
};

/// Points within `reach` half cells.
std::vector<Point> pointsWithin(int reach, int count, std::mt19937* random) {
  std::uniform_int_distribution<int> direction(0, kDirections - 1), half(-reach, reach);
  std::vector<Point> out;
  for (int i = 0; i < count; ++i) out.push_back({direction(*random), half(*random), half(*random)});
  return out;
}

/// Votes that the first points give to a centre, read one by one.
int votesOf(const VotePlanes& planes, const std::vector<Point>& points, std::size_t count, int row,
            int col) {
  int sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto [direction, hx, hy] = points[i];
    sum += planes.votes[planes.byteOf(planes.offset(direction, 2 * col + hx, 2 * row + hy))] & 15;
  }
  return sum;
}

/// A field in which about every fifth place votes.
VotePlanes randomPlanes(std::mt19937* random) {
  Field field;
  field.width = 340;
  field.height = 31;
  std::uniform_int_distribution<int> distance(0, 5 * kUnitsPerFieldPixel);
  for (int i = 0; i < field.width * field.height * kDirections; ++i)
    field.distance.push_back(static_cast<std::uint8_t>(distance(*random)));
  VotePlanes planes = sizePlanes(field, 1.0, 9.0);
  fillPlanes(field, 1.0, 1, &planes);
  return planes;
}

/// Ranges of one chunk, of two and of three, from even columns and odd ones.
TEST(VotePlanes, AScanFindsTheChunksThatPlainSumsFind) {
  std::mt19937 random(7);
  const VotePlanes planes = randomPlanes(&random);
  const auto points = pointsWithin(8, 79, &random);
  const std::size_t third = points.size() / 3;
  for (const Range& range : {Range{2, 9, 5, 60}, {0, 15, 4, 132}, {3, 12, 1, 170}}) {
    std::vector<std::int32_t> offsets;
    for (const auto& [direction, hx, hy] : points) {
      // Centres are cells of the first plane, the first of all at (0, 0).
      const std::size_t cell = planes.offset(direction, hx, hy) + (range.col0 & 1);
      offsets.push_back(static_cast<std::int32_t>(planes.byteOf(cell)));
    }
    PruningThresholds thresholds(planes.cols + kChunk, 44);
    thresholds.set(20, 7, 40);
    thresholds.set(75, 30, 50);
    VoteScan scan(planes, {offsets.data(), static_cast<int>(offsets.size())}, range);
    VoteScan::Chunks found;
    int expected = 0, winners = 0;
    while (scan.next(thresholds, &found)) {
      for (int i = 0; i < 2 * kChunk; ++i) {
        const VoteScan::Chunk& chunk = found.chunks[i / kChunk];
        const int col = found.col + i, at = i % kChunk;
        if (!chunk.is_found || col >= range.col1) continue;
        ASSERT_EQ(chunk.all[at], votesOf(planes, points, points.size(), found.row, col)) << col;
        ASSERT_EQ(chunk.first[at], votesOf(planes, points, third, found.row, col)) << col;
        ASSERT_EQ(chunk.is_enough[at] != 0, chunk.all[at] > thresholds.best(col)) << col;
        winners += chunk.is_enough[at];
      }
    }
    for (int row = range.row0; row < range.row1; ++row) {
      for (int from = range.col0; from < range.col1; from += kChunk) {
        bool goes_on = false;
        int above = 0;
        for (int col = from; col < from + kChunk; ++col) {
          goes_on |= votesOf(planes, points, third, row, col) > *thresholds.firstFrom(col);
          if (col < range.col1)
            above += votesOf(planes, points, points.size(), row, col) > thresholds.best(col);
        }
        if (goes_on) expected += above;
      }
    }
    EXPECT_GT(expected, 0);
    EXPECT_EQ(winners, expected) << range.col0;
  }
}

}  // namespace
}  // namespace planar_bin_picking
