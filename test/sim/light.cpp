// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/light.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>

namespace planar_bin_picking::cell {
namespace {

constexpr float kPi = 3.14159265f;
constexpr float kOff = 2e-5f;       // metres by which rays start above their surface
constexpr float kSkyReach = 0.15f;  // metres within which the sky can be covered
constexpr int kShares = 4, kSky = 8;

/// A panel of 4 x 4 points.
void addPanel(const Eigen::Vector3f& center, const Eigen::Vector3f& u, const Eigen::Vector3f& v,
              float power, Lamps* lamps) {
  const Eigen::Vector3f normal = u.cross(v).normalized();
  // In an order in which each quarter of the list is spread over the panel.
  for (int share = 0; share < kShares; ++share) {
    for (int k = 0; k < 4; ++k) {
      const int i = 2 * (k % 2) + share % 2, j = 2 * (k / 2) + share / 2;
      const float a = (static_cast<float>(i) + 0.5f) / 4.0f - 0.5f;
      const float b = (static_cast<float>(j) + 0.5f) / 4.0f - 0.5f;
      lamps->points.push_back({center + a * u + b * v, normal, power / 16.0f, u / 4.0f, v / 4.0f});
    }
  }
}

void addRing(const Eigen::Isometry3f& T_base_camera, float radius, float power, Lamps* lamps) {
  for (int share = 0; share < kShares; ++share) {
    for (int k = 0; k < 4; ++k) {
      const float a = 2.0f * kPi * static_cast<float>(kShares * k + share) / 16.0f;
      const Eigen::Vector3f at(radius * std::cos(a), radius * std::sin(a), 0.0f);
      lamps->points.push_back({T_base_camera * at,
                               T_base_camera.linear() * Eigen::Vector3f::UnitZ(), power / 16.0f,
                               Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
    }
  }
}

/// Directions about z, denser where the surface sees more: cosine-weighted.
Eigen::Vector3f skyDirection(int i, float turn) {
  const float r = std::sqrt((static_cast<float>(i) + 0.5f) / kSky);
  const float a = 2.399963f * static_cast<float>(i) + turn;  // the golden angle
  return {r * std::cos(a), r * std::sin(a), std::sqrt(1.0f - r * r)};
}

std::uint32_t hash(std::uint32_t a) {
  a = (a ^ 61u) ^ (a >> 16);
  a *= 9u;
  a ^= a >> 4;
  a *= 0x27d4eb2du;
  return a ^ (a >> 15);
}

float latticeValue(int x, int y, std::uint32_t seed) {
  const auto mixed =
      hash(hash(static_cast<std::uint32_t>(x) + seed) + static_cast<std::uint32_t>(y));
  return static_cast<float>(mixed & 0xffffffu) / 8388608.0f - 1.0f;
}

int bits(float value) {
  std::int32_t out;
  std::memcpy(&out, &value, sizeof out);
  return out;
}

/// -1..1, another one at every spot.
float jitter(const Spot& spot, std::uint32_t which) {
  return latticeValue(bits(spot.position.x()), bits(spot.position.y()), which);
}

float noise(float x, float y, std::uint32_t seed) {
  const float fx = std::floor(x), fy = std::floor(y), a = x - fx, b = y - fy;
  const int i = static_cast<int>(fx), j = static_cast<int>(fy);
  const float low = latticeValue(i, j, seed) * (1 - a) + latticeValue(i + 1, j, seed) * a;
  const float high = latticeValue(i, j + 1, seed) * (1 - a) + latticeValue(i + 1, j + 1, seed) * a;
  return low * (1 - b) + high * b;
}

}  // namespace

Material material(const std::string& name) {
  static const std::map<std::string, Material> known = {
      {"rolled", {0.30f, 0.35f, 0.25f, 25.0f, 0.10f, 3.0f}},
      {"brushed", {0.25f, 0.45f, 0.30f, 35.0f, 0.14f, 25.0f}},
      {"painted", {0.35f, 0.08f, 0.03f, 15.0f, 0.03f, 1.0f}},
      {"plastic", {0.13f, 0.05f, 0.02f, 10.0f, 0.10f, 1.0f}}};
  const auto found = known.find(name);
  if (found == known.end())
    throw std::invalid_argument("material is '" + name +
                                "'; there are rolled, brushed, painted, plastic");
  return found->second;
}

Lamps makeLamps(const std::string& name, const Eigen::Isometry3d& T_base_camera) {
  Lamps lamps;
  if (name == "diffuse") {
    lamps.ambient = 0.55f;
    addPanel({0.0f, 0.0f, 1.3f}, {1.0f, 0.0f, 0.0f}, {0.0f, -0.8f, 0.0f}, 1.1f, &lamps);
  } else if (name == "ring") {
    lamps.ambient = 0.15f;
    addRing(T_base_camera.cast<float>(), 0.07f, 0.55f, &lamps);
  } else if (name == "side") {
    lamps.ambient = 0.18f;
    const Eigen::Vector3f at(0.75f, 0.35f, 0.9f), u(0.1f, -0.22f, 0.0f);
    const Eigen::Vector3f toward = (-at).normalized();
    addPanel(at, u, 0.25f * toward.cross(u.normalized()).normalized(), 1.5f, &lamps);
  } else {
    throw std::invalid_argument("light is '" + name + "'; there are diffuse, ring, side");
  }
  return lamps;
}

Arriving gather(const Raycaster& world, const Lamps& lamps, const Spot& spot, float exponent,
                int share) {
  Arriving sum;
  const Eigen::Vector3f start = spot.position + kOff * spot.normal;
  const std::size_t quarter = lamps.points.size() / kShares;
  for (std::size_t i = share * quarter; i < (share + 1) * quarter; ++i) {
    const Lamps::Point& lamp = lamps.points[i];
    const auto k = static_cast<std::uint32_t>(i);
    const Eigen::Vector3f way = lamp.position + 0.5f * jitter(spot, 2u + k) * lamp.u +
                                0.5f * jitter(spot, 40u + k) * lamp.v - start;
    const float distance = way.norm();
    const Eigen::Vector3f toward = way / distance;
    const float cosine = spot.normal.dot(toward), leaving = std::abs(lamp.normal.dot(toward));
    if (cosine <= 0.0f || world.blocked(start, toward, 0.0f, distance - 0.01f)) continue;
    const float arriving = kShares * lamp.power * leaving / (distance * distance);
    sum.diffuse += cosine * arriving;
    const float half = spot.normal.dot((toward + spot.view).normalized());
    sum.gloss +=
        cosine * arriving * std::pow(std::max(0.0f, half), exponent) * (exponent + 2.0f) / 8.0f;
  }
  // Turned at random: a few directions that are the same everywhere would draw borders of their
  // own.
  const float turn = kPi * jitter(spot, 1u);
  const Eigen::Matrix3f frame =
      Eigen::Quaternionf::FromTwoVectors(Eigen::Vector3f::UnitZ(), spot.normal).toRotationMatrix();
  for (int i = share; i < kSky; i += kShares) {
    if (!world.blocked(start, frame * skyDirection(i, turn), 0.0f, kSkyReach))
      sum.diffuse += kShares * lamps.ambient / kSky;
  }
  constexpr float kRough = 0.12f;
  const Eigen::Vector3f off(jitter(spot, 80u), jitter(spot, 81u), jitter(spot, 82u));
  const Eigen::Vector3f mirrored =
      2.0f * spot.normal.dot(spot.view) * spot.normal - spot.view + kRough * off;
  // Things that are mirrored look like their surroundings: darker than the sky.
  const bool covered = world.blocked(start, mirrored, 0.0f, 10.0f);
  sum.mirror = lamps.ambient * (covered ? 0.3f : 0.5f + 0.5f * std::max(0.0f, mirrored.z()));
  return sum;
}

float pattern(const Material& material, const Eigen::Vector3f& x_part, std::uint32_t seed) {
  constexpr float kFine = 0.0009f, kCoarse = 0.012f;  // metres
  const float x = x_part.x(), y = x_part.y();
  const float fine = noise(x / (kFine * material.stretch), y / kFine, seed);
  const float coarse = noise(x / kCoarse, y / kCoarse, seed + 77u);
  const float tone = latticeValue(3, 5, seed) * 1.2f;  // no two parts are equally bright
  return 1.0f + material.grain * (fine + 0.7f * coarse + tone);
}

}  // namespace planar_bin_picking::cell
