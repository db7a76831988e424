// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/raycaster.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <stdexcept>

namespace planar_bin_picking::cell {

struct Raycaster::State {
  RTCDevice device = nullptr;
  std::vector<RTCScene> bodies;  ///< one per mesh
  RTCScene scene = nullptr;
  std::vector<Eigen::Matrix3f> R_base_body;
};

namespace {

/// Embree's arrays belong to it; they are filled in place.
RTCScene makeBody(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* points = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                             RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                             mesh.points.size()));
  for (const auto& p : mesh.points) points = std::copy(p.data(), p.data() + 3, points);
  auto* faces = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.faces.size()));
  for (const auto& f : mesh.faces) faces = std::copy(f.begin(), f.end(), faces);
  rtcCommitGeometry(geometry);
  RTCScene scene = rtcNewScene(device);
  // Neighbouring triangles share corners but not vertices: no ray may slip through between them.
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

RTCRay rayFrom(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
               float far) {
  RTCRay ray{};
  ray.org_x = origin.x(), ray.org_y = origin.y(), ray.org_z = origin.z();
  ray.dir_x = direction.x(), ray.dir_y = direction.y(), ray.dir_z = direction.z();
  ray.tnear = near, ray.tfar = far;
  ray.mask = 0xffffffffu;
  return ray;
}

}  // namespace

Raycaster::Raycaster(const std::vector<Mesh>& meshes) : state_(std::make_unique<State>()) {
  state_->device = rtcNewDevice("threads=1");
  if (state_->device == nullptr) throw std::runtime_error("Embree finds no device");
  for (const Mesh& mesh : meshes) state_->bodies.push_back(makeBody(state_->device, mesh));
  place({});
}

Raycaster::~Raycaster() {
  rtcReleaseScene(state_->scene);
  for (RTCScene body : state_->bodies) rtcReleaseScene(body);
  rtcReleaseDevice(state_->device);
}

void Raycaster::place(const std::vector<Instance>& instances) {
  if (state_->scene != nullptr) rtcReleaseScene(state_->scene);
  state_->scene = rtcNewScene(state_->device);
  rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  state_->R_base_body.clear();
  for (std::size_t i = 0; i < instances.size(); ++i) {
    const Eigen::Matrix4f T = instances[i].T_base_body.matrix().cast<float>();
    RTCGeometry geometry = rtcNewGeometry(state_->device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry,
                                 state_->bodies.at(static_cast<std::size_t>(instances[i].mesh)));
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, T.data());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(state_->scene, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
    state_->R_base_body.emplace_back(T.topLeftCorner<3, 3>());
  }
  rtcCommitScene(state_->scene);
}

std::optional<Hit> Raycaster::cast(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                                   float near, float far) const {
  RTCRayHit query{};
  query.ray = rayFrom(origin, direction, near, far);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(state_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  const Eigen::Vector3f n(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z);
  const unsigned body = query.hit.instID[0];
  return Hit{static_cast<int>(body), query.ray.tfar, (state_->R_base_body[body] * n).normalized()};
}

bool Raycaster::blocked(const Eigen::Vector3f& origin, const Eigen::Vector3f& direction, float near,
                        float far) const {
  RTCRay ray = rayFrom(origin, direction, near, far);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(state_->scene, &context, &ray);
  return ray.tfar < 0.0f;
}

}  // namespace planar_bin_picking::cell
