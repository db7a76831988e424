// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/hough.h"

#include "parallel.h"
#include "plane_pose.h"
#include "simd.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace planar_bin_picking {
namespace {

constexpr int kMaxVote = 3;       // votes of a raster point that lies right on an edgel
constexpr int kChunk = 64;        // positions of a row that are summed at a time, in registers
constexpr int kYawSectors = 12;   // per tile, the best of each sector and face is kept
constexpr int kFirstPoints = 32;  // after these, a chunk without hope is left

/// Shape of the part in the image up to position: A = s R(azimuth) diag(1, f) R(yaw - azimuth) F.
struct View {
  Face face;
  Eigen::Matrix2d A;  // part x, y (metres) -> ideal image plane
  int sector;
  int row0 = 0, row1 = 0, col0 = 0,
      col1 = 0;  // cells of the centre for which the part lies inside the image
};

/// Votes by direction on a grid of half cells, split by phase so that whole cells are neighbours.
struct VotePlanes {
  double half = 1.0;  // half a cell, field pixels
  int rows = 0, cols = 0, pad = 0, pitch = 0;
  std::size_t plane = 0;
  std::vector<std::uint8_t> votes;  // [direction][phase y][phase x][rows + 2 pad][pitch]

  std::size_t offset(int direction, int hx, int hy) const {
    const int phase = (hy & 1) * 2 + (hx & 1);
    return (static_cast<std::size_t>(direction) * 4 + phase) * plane +
           static_cast<std::size_t>((hy >> 1) + pad) * pitch + (hx >> 1) + pad;
  }
};

VotePlanes makePlanes(const Field& field, double half, double tolerance_px, int pad, int threads) {
  VotePlanes out;
  out.half = half;
  out.cols = static_cast<int>((field.width - 1) / (2 * half)) + 1;
  out.rows = static_cast<int>((field.height - 1) / (2 * half)) + 1;
  out.pad = pad;
  out.pitch = out.cols + 2 * pad + kChunk;
  out.plane = static_cast<std::size_t>(out.rows + 2 * pad) * out.pitch;
  out.votes.assign(out.plane * 4 * kDirections, 0);
  std::array<std::uint8_t, 256> vote{};
  for (int d = 0; d < 256; ++d) {
    const double off = d / (tolerance_px * kUnitsPerFieldPixel);
    vote[d] = off <= 0.4 ? 3 : off <= 0.7 ? 2 : off <= 1.0 ? 1 : 0;
  }
  parallelFor(2 * out.rows, threads, [&](int hy) {
    const int y = static_cast<int>(std::lround(hy * half));
    if (y >= field.height) return;
    for (int hx = 0; hx < 2 * out.cols; ++hx) {
      const int x = static_cast<int>(std::lround(hx * half));
      if (x >= field.width) break;
      const auto* d = field.at(x, y);
      std::uint8_t* to = out.votes.data() + out.offset(0, hx, hy);
      for (int b = 0; b < kDirections; ++b) to[b * 4 * out.plane] = vote[d[b]];
    }
  });
  return out;
}

/// Every k-th sample of the outline, prints left out: those tell the face later (score.h).
std::vector<OutlinePoint> rasterPoints(const PartModel& part, int count) {
  std::vector<OutlinePoint> all, out;
  for (const auto& p : part.outline()) {
    if (p.kind != LoopKind::kPrint) all.push_back(p);
  }
  const int n = static_cast<int>(all.size());
  count = std::min(count, n);
  // Spread so that the first few already stand for the whole outline.
  for (int i = 0; i < count; ++i) {
    const int k = static_cast<int>(static_cast<long long>(i) * 37 % count);
    out.push_back(all[static_cast<std::size_t>(k) * n / count]);
  }
  return out;
}

Eigen::Matrix2d turn(double angle) { return Eigen::Rotation2Dd(angle).toRotationMatrix(); }

/// Foreshortenings f of the image-plane affine map and azimuths of each: their tolerances touch.
struct Shape {
  double f, azimuth;
};

std::vector<Shape> makeShapes(double tilt_max_deg) {
  std::vector<Shape> out = {{1.0, 0.0}};
  const double f_min = std::cos(tilt_max_deg * M_PI / 180.0);
  for (double f = 0.8; f > f_min - 0.1; f *= 0.8) {
    const int azimuths = f > 0.7 ? 6 : 8;
    for (int k = 0; k < azimuths; ++k) out.push_back({f, k * M_PI / azimuths});
  }
  return out;
}

int gcdFreeCount(int count) { return count % 37 == 0 ? count - 1 : count; }

std::vector<View> makeViews(const HoughTask& task, const HoughParams& params) {
  const auto& symmetry = task.part->symmetry();
  // The faces of a mirror symmetric outline look the same; a print tells them apart later
  // (refine.h).
  std::vector<Face> faces = {Face::kFront};
  if (!symmetry.mirror) faces.push_back(Face::kBack);
  const int order = task.part->nearOrder();
  const double yaw_range = order == 0 ? 0.0 : 2.0 * M_PI / order;
  const int yaws =
      std::max(1, static_cast<int>(std::ceil(yaw_range / (params.yaw_step_deg * M_PI / 180.0))));
  const double span = std::log(task.distance_max / task.distance_min);
  const int distances =
      std::max(1, static_cast<int>(std::ceil(span / std::log(1.0 + params.distance_step))));
  std::vector<View> views;
  for (const Face face : faces) {
    const Eigen::Matrix2d flip = face == Face::kFront
                                     ? Eigen::Matrix2d(Eigen::Vector2d(1.0, -1.0).asDiagonal())
                                     : Eigen::Matrix2d(Eigen::Matrix2d::Identity());
    for (int h = 0; h < distances; ++h) {
      const double distance = task.distance_min * std::exp(span * (h + 0.5) / distances);
      for (const auto& shape : makeShapes(params.tilt_max_deg)) {
        for (int k = 0; k < yaws; ++k) {
          const double yaw = yaw_range * k / yaws;
          View view;
          view.face = face;
          view.sector = (face == Face::kBack ? kYawSectors : 0) + k * kYawSectors / yaws;
          view.A = turn(shape.azimuth) * Eigen::Vector2d(1.0, shape.f).asDiagonal() *
                   turn(yaw - shape.azimuth) * flip / distance;
          views.push_back(view);
        }
      }
    }
  }
  return views;
}

struct Best {
  std::uint16_t votes = 0;
  std::int32_t view = -1, row = 0, col = 0;
  bool beatenBy(std::uint16_t v, std::int32_t w, std::int32_t r, std::int32_t c) const {
    if (v != votes) return v > votes;
    if (w != view) return w < view;
    return r != row ? r < row : c < col;
  }
};

/// Offsets of the view's raster points into the planes, and the cells that its centre may take.
void layOut(const std::vector<OutlinePoint>& points, const PartModel& part, const Field& field,
            const VotePlanes& planes, View* view, std::vector<std::int32_t>* offsets) {
  const Eigen::Matrix2d to_half = view->A * (field.focal / planes.half);
  const Eigen::Matrix2d to_normal = view->A.inverse().transpose();
  Eigen::AlignedBox2d box;
  offsets->clear();
  for (const auto& p : points) {
    const Eigen::Vector2d q = to_half * (p.position - part.center());
    const Eigen::Vector2d n = to_normal * p.normal;
    box.extend(q);
    offsets->push_back(static_cast<std::int32_t>(
        planes.offset(directionBin(n.x(), n.y()), static_cast<int>(std::floor(q.x() + 0.5)),
                      static_cast<int>(std::floor(q.y() + 0.5)))));
  }
  // A tenth of the part may stick out of the image, no more.
  const Eigen::Vector2d lo = box.min() * 0.5 * 0.9, hi = box.max() * 0.5 * 0.9;
  view->col0 = std::max(0, static_cast<int>(std::ceil(-lo.x())));
  view->row0 = std::max(0, static_cast<int>(std::ceil(-lo.y())));
  view->col1 = std::min(planes.cols, static_cast<int>(std::floor(planes.cols - hi.x())));
  view->row1 = std::min(planes.rows, static_cast<int>(std::floor(planes.rows - hi.y())));
}

}  // namespace

PBP_SIMD
static void addPoints(const std::uint8_t* base, const std::int32_t* offsets, int count,
                      ByteVector* acc) {
  ByteVector a = acc[0], b = acc[1];
  for (int i = 0; i < count; ++i) {
    ByteVector u, v;
    std::memcpy(&u, base + offsets[i], sizeof u);
    std::memcpy(&v, base + offsets[i] + sizeof u, sizeof v);
    a += u;
    b += v;
  }
  acc[0] = a;
  acc[1] = b;
}

PBP_SIMD
static std::uint8_t highest(const ByteVector* acc) {
  std::uint8_t values[kChunk];
  std::memcpy(values, acc, kChunk);
  std::uint8_t m = 0;
  for (int i = 0; i < kChunk; ++i) m = values[i] > m ? values[i] : m;
  return m;
}

/// Adds to the sums and tells the highest.
PBP_SIMD
static std::uint16_t addUp(const ByteVector* acc, std::uint16_t* sums) {
  std::uint8_t values[kChunk];
  std::memcpy(values, acc, kChunk);
  std::uint16_t m = 0;
  for (int i = 0; i < kChunk; ++i) {
    sums[i] = static_cast<std::uint16_t>(sums[i] + values[i]);
    m = sums[i] > m ? sums[i] : m;
  }
  return m;
}

namespace {

/// The best position of each tile and yaw sector.
class BestTable {
 public:
  BestTable(const VotePlanes& planes, int tile) : tile_(tile) {
    columns_ = planes.cols / tile + 1;
    table_.resize(static_cast<std::size_t>(columns_) * (planes.rows / tile + 1) * 2 * kYawSectors);
  }
  Best& at(int row, int col, int sector) {
    return table_[(static_cast<std::size_t>(row / tile_) * columns_ + col / tile_) * 2 *
                      kYawSectors +
                  sector];
  }
  std::vector<Best>& all() { return table_; }

 private:
  int tile_, columns_;
  std::vector<Best> table_;
};

void vote(const VotePlanes& planes, const View& view, int index,
          const std::vector<std::int32_t>& offsets, double votes_min, BestTable* best) {
  const int count = static_cast<int>(offsets.size());
  const int first = std::min(count, kFirstPoints);
  const int floor_all = static_cast<int>(std::ceil(votes_min * kMaxVote * count));
  // After the first points a chunk goes on where it is not far below the share it needs in the end.
  const int floor_first = static_cast<int>(0.8 * votes_min * kMaxVote * first);
  static_assert(sizeof(ByteVector) * 2 == kChunk, "a chunk is two vectors");
  for (int row = view.row0; row < view.row1; ++row) {
    for (int col = view.col0; col < view.col1; col += kChunk) {
      const std::uint8_t* base =
          planes.votes.data() + static_cast<std::size_t>(row) * planes.pitch + col;
      ByteVector acc[2] = {};
      addPoints(base, offsets.data(), first, acc);
      if (highest(acc) < floor_first) continue;
      std::uint16_t sums[kChunk] = {};
      std::uint16_t most = addUp(acc, sums);
      for (int from = first; from < count; from += 80) {  // 80 * 3 votes fit into a byte
        ByteVector more[2] = {};
        addPoints(base, offsets.data() + from, std::min(80, count - from), more);
        most = addUp(more, sums);
      }
      if (most < floor_all) continue;
      const int end = std::min(kChunk, view.col1 - col);
      for (int i = 0; i < end; ++i) {
        if (sums[i] < floor_all) continue;
        Best& b = best->at(row, col + i, view.sector);
        if (b.beatenBy(sums[i], index, row, col + i)) b = {sums[i], index, row, col + i};
      }
    }
  }
}

void addCandidates(const Best& best, const View& view, const HoughTask& task,
                   const HoughParams& params, const Field& field, const VotePlanes& planes,
                   double most, std::vector<Candidate>* out) {
  const Eigen::Vector2d p((best.col * 2 * planes.half - field.cx) / field.focal,
                          (best.row * 2 * planes.half - field.cy) / field.focal);
  const auto poses = posesFromAffine(view.A, p);
  for (int k = 0; k < 2; ++k) {
    const double tilt = std::acos(std::min(1.0, std::abs(poses[k].linear()(2, 2))));
    if (tilt > (params.tilt_max_deg + 6.0) * M_PI / 180.0) continue;
    if (k == 1 && (poses[0].linear().col(2) - poses[1].linear().col(2)).norm() < 0.1) continue;
    Candidate c;
    c.part = task.part_index;
    c.face = view.face;
    c.votes = best.votes / most;
    const Eigen::Vector2d& centre = task.part->center();
    c.T_camera_part =
        poses[k] * Eigen::Translation3d(-centre.x(), -centre.y(), -task.part->faceZ(view.face));
    out->push_back(c);
  }
}

}  // namespace

std::vector<Candidate> findCandidates(const EdgeMap& edges, const HoughTask& task,
                                      const HoughParams& params, int threads) {
  const Field& field = edges.field;
  const double distance = std::sqrt(task.distance_min * task.distance_max);
  const double radius_px = field.focal * task.part->radius() / distance;
  const double half = std::max(1.0, 0.5 * radius_px / params.radius_cells);
  const int pad = 2 + static_cast<int>(std::ceil(field.focal * task.part->radius() /
                                                 task.distance_min / (2 * half)));
  const VotePlanes planes =
      makePlanes(field, half, params.tolerance_cells * 2 * half, pad, threads);
  const auto points = rasterPoints(*task.part, gcdFreeCount(params.raster_points));
  auto views = makeViews(task, params);

  std::vector<BestTable> tables(threads, BestTable(planes, params.tile_cells));
  parallelFor(threads, threads, [&](int t) {
    std::vector<std::int32_t> offsets;
    for (std::size_t v = t; v < views.size(); v += threads) {
      layOut(points, *task.part, field, planes, &views[v], &offsets);
      vote(planes, views[v], static_cast<int>(v), offsets, params.votes_min, &tables[t]);
    }
  });
  std::vector<Best> best;
  for (std::size_t i = 0; i < tables[0].all().size(); ++i) {
    Best b = tables[0].all()[i];
    for (int t = 1; t < threads; ++t) {
      const Best& o = tables[t].all()[i];
      if (o.view >= 0 && b.beatenBy(o.votes, o.view, o.row, o.col)) b = o;
    }
    if (b.view >= 0) best.push_back(b);
  }
  std::sort(best.begin(), best.end(),
            [](const Best& a, const Best& b) { return b.beatenBy(a.votes, a.view, a.row, a.col); });
  std::vector<Candidate> out;
  for (const auto& b : best) {
    // The weaker half of a pair goes with the limit, too.
    if (out.size() + 2 > static_cast<std::size_t>(params.max_candidates)) break;
    addCandidates(b, views[b.view], task, params, field, planes,
                  kMaxVote * static_cast<double>(points.size()), &out);
  }
  return out;
}

}  // namespace planar_bin_picking
