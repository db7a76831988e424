// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// All parameters of the localization. Each stage's struct holds its defaults, the only place where
/// a default is written, and beside them one list of (key, member, min, max). That list drives
/// loading, validation, printing and the tests.

#include "planar_bin_picking/edges.h"
#include "planar_bin_picking/hough.h"
#include "planar_bin_picking/plane_prior.h"
#include "planar_bin_picking/rank.h"
#include "planar_bin_picking/refine.h"
#include "planar_bin_picking/score.h"

#include <string>
#include <type_traits>

namespace planar_bin_picking {

struct LocatorParams {
  EdgesParams edges;
  HoughParams hough;
  RefineParams refine;
  PlaneParams plane;
  ScoreParams score;
  RankParams rank;
  int threads = 0;  ///< 0 = as many as the machine has cores
};

/// Calls visit(key, member, min, max) for every parameter, keys as in config/locator.yaml with the
/// stage in front ("hough/yaw_step_deg"). `Params` is LocatorParams or const LocatorParams; a
/// member is an int, a double or a bool.
template <class Params, class Visit>
void forEachField(Params& params, Visit&& visit) {
  const auto stage = [&visit](const std::string& name, auto& self) {
    std::decay_t<decltype(self)>::fields(self,
                                         [&](const char* key, auto& member, auto min, auto max) {
                                           visit(name + "/" + key, member, min, max);
                                         });
  };
  stage("edges", params.edges);
  stage("hough", params.hough);
  stage("refine", params.refine);
  stage("plane", params.plane);
  stage("score", params.score);
  stage("rank", params.rank);
  visit(std::string("threads"), params.threads, 0, 64);
}

/// @throws std::invalid_argument  the first field out of its range: key, value, allowed range
void validate(const LocatorParams& params);

/// Reads the YAML file (nested maps, keys as in forEachField) over the defaults.
/// @throws std::runtime_error  file unreadable; unknown key, wrong type or value out of range, by
/// name
LocatorParams loadLocatorParams(const std::string& path);

}  // namespace planar_bin_picking
