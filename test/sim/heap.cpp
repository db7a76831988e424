// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/heap.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <stdexcept>
#include <string>

namespace planar_bin_picking::cell {
namespace {

// Bullet likes bodies of about one unit: it works in centimetres.
constexpr double kUnits = 100.0;       // per metre
constexpr double kGravity = 9.81;      // m/s^2
constexpr double kStep = 1.0 / 240.0;  // s
constexpr double kMargin = 0.0002;     // metres, of a shape: contacts are made this far outside
constexpr double kFastest = 0.45;      // m/s: in a step less than the thinnest part
constexpr double kFriction = 0.45;
constexpr double kSlack = 0.01;  // of its area, by which a shape's convex pieces may each be off
// Metres from a shape's edge: chords, pieces and the missing bevel leave contacts there in doubt.
constexpr double kRim = 5e-4;
constexpr double kSmallHole = 5e-4;  // m^2: nothing gets through

btVector3 toBullet(const Eigen::Vector3d& p) {
  return {static_cast<btScalar>(kUnits * p.x()), static_cast<btScalar>(kUnits * p.y()),
          static_cast<btScalar>(kUnits * p.z())};
}

/// A kind of part: its collision shape about its centre of mass.
struct Kind {
  Shape drawn;
  std::unique_ptr<btCompoundShape> shape;
  std::vector<std::unique_ptr<btConvexHullShape>> hulls;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  ///< of mass, part frame
  double mass = 0.0, radius = 0.0;
  btVector3 inertia;
};

/// Area and first and second moments of convex pieces.
struct Moments {
  double area = 0.0;
  Eigen::Vector2d first = Eigen::Vector2d::Zero();
  double xx = 0.0, yy = 0.0;
};

Moments momentsOf(const Shape& shape) {
  Moments m;
  const auto add = [&](const Polygon& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector2d a = ring[i], b = ring[(i + 1) % ring.size()];
      const double c = a.x() * b.y() - b.x() * a.y();
      m.area += c / 2.0;
      m.first += c * (a + b) / 6.0;
      m.xx += c * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x()) / 12.0;
      m.yy += c * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y()) / 12.0;
    }
  };
  add(shape.outer);
  for (const Polygon& hole : shape.holes) add(hole);  // clockwise: taken away
  return m;
}

Kind makeKind(const Shape& shape, double density) {
  Kind kind;
  kind.drawn = shape;
  const Moments m = momentsOf(shape);
  const Eigen::Vector2d c = m.first / m.area;
  kind.center = {c.x(), c.y(), -0.5 * shape.thickness};
  kind.mass = density * m.area * shape.thickness;
  for (const auto& p : shape.outer) kind.radius = std::max(kind.radius, (p - c).norm());
  const double t2 = shape.thickness * shape.thickness / 12.0;
  const double ix = m.yy / m.area - c.y() * c.y() + t2, iy = m.xx / m.area - c.x() * c.x() + t2;
  const double unit = kind.mass * kUnits * kUnits;
  kind.inertia = btVector3(unit * ix, unit * iy, unit * (ix + iy - 2.0 * t2));
  kind.shape = std::make_unique<btCompoundShape>();
  const double half = 0.5 * shape.thickness - kMargin;
  Shape solid = shape;
  solid.holes.erase(std::remove_if(solid.holes.begin(), solid.holes.end(),
                                   [](const Polygon& hole) { return -area(hole) < kSmallHole; }),
                    solid.holes.end());
  for (const Polygon& piece : convexPieces(solid, kSlack * area(solid))) {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const auto& p : piece)
      for (const double z : {-half, half})
        hull->addPoint(toBullet({p.x() - c.x(), p.y() - c.y(), z}), false);
    hull->recalcLocalAabb();
    hull->setMargin(kUnits * kMargin);
    kind.shape->addChildShape(btTransform::getIdentity(), hull.get());
    kind.hulls.push_back(std::move(hull));
  }
  return kind;
}

bool isNear(const Polygon& ring, const Eigen::Vector2d& p, double distance) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Eigen::Vector2d a = ring[i], d = ring[(i + 1) % ring.size()] - a;
    const double s = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-18), 0.0, 1.0);
    if ((a + s * d - p).norm() < distance) return true;
  }
  return false;
}

enum class Contact { kOnFace, kAtRim, kBesidePart };

/// Where a point of the body, about its centre of mass, lies on the part as it is drawn.
Contact contactOf(const Kind& kind, const btVector3& local) {
  const Eigen::Vector2d p = Eigen::Vector2d(local.x(), local.y()) / kUnits + kind.center.head<2>();
  const auto& holes = kind.drawn.holes;
  if (isNear(kind.drawn.outer, p, kRim) ||
      std::any_of(holes.begin(), holes.end(),
                  [&](const Polygon& hole) { return isNear(hole, p, kRim); }))
    return Contact::kAtRim;
  return contains(kind.drawn, p) ? Contact::kOnFace : Contact::kBesidePart;
}

btTransform toBullet(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  return btTransform(btQuaternion(q.x(), q.y(), q.z(), q.w()), toBullet(T.translation()));
}

Eigen::Isometry3d fromBullet(const btTransform& T) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  const btQuaternion q = T.getRotation();
  out.linear() = Eigen::Quaterniond(q.w(), q.x(), q.y(), q.z()).normalized().toRotationMatrix();
  const btVector3& p = T.getOrigin();
  out.translation() = Eigen::Vector3d(p.x(), p.y(), p.z()) / kUnits;
  return out;
}

}  // namespace

struct Heap::State {
  Bin bin;
  std::vector<Kind> kinds;
  std::mt19937_64 random;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<btBoxShape>> boxes;
  std::vector<std::unique_ptr<btRigidBody>> walls;
  std::map<int, std::unique_ptr<btRigidBody>> parts;  ///< by id
  std::map<int, int> kind_of;
  int next_id = 1;

  double uniform(double from, double to) {
    // Not std::uniform_real_distribution, whose numbers differ between libraries.
    return from + (to - from) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  }
  void addBox(const Eigen::Vector3d& half, const Eigen::Vector3d& center) {
    boxes.push_back(std::make_unique<btBoxShape>(toBullet(half)));
    boxes.back()->setMargin(kUnits * kMargin);
    walls.push_back(std::make_unique<btRigidBody>(
        btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, boxes.back().get())));
    walls.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), toBullet(center)));
    walls.back()->setFriction(kFriction);
    walls.back()->setUserIndex(0);
    world.addRigidBody(walls.back().get());
  }
  int add(int kind, const Eigen::Isometry3d& T_base_part);
  void damp(double share);
  void step();
  bool rests() const;
  void wake() {
    for (auto& part : parts) part.second->activate(true);
  }
  double top() const;
};

int Heap::State::add(int kind, const Eigen::Isometry3d& T_base_part) {
  Kind& k = kinds.at(static_cast<std::size_t>(kind));
  auto body = std::make_unique<btRigidBody>(
      btRigidBody::btRigidBodyConstructionInfo(k.mass, nullptr, k.shape.get(), k.inertia));
  const btTransform T = toBullet(T_base_part * Eigen::Translation3d(k.center));
  body->setWorldTransform(T);
  body->setInterpolationWorldTransform(T);
  body->setFriction(kFriction);
  body->setRestitution(0.05);
  body->setSleepingThresholds(0.8, 0.2);  // cm/s, rad/s
  body->setUserIndex(next_id);
  body->setDamping(0.05, 0.1);
  world.addRigidBody(body.get());
  parts[next_id] = std::move(body);
  kind_of[next_id] = kind;
  return next_id++;
}

void Heap::State::damp(double share) {
  for (auto& part : parts) part.second->setDamping(share, share);
}

void Heap::State::step() {
  world.stepSimulation(kStep, 0, kStep);
  for (auto& [id, body] : parts) {
    const double fastest = kUnits * kFastest;
    const double turn = fastest / (kUnits * kinds[static_cast<std::size_t>(kind_of[id])].radius);
    const btVector3 v = body->getLinearVelocity(), w = body->getAngularVelocity();
    if (v.length() > fastest) body->setLinearVelocity(v * (fastest / v.length()));
    if (w.length() > turn) body->setAngularVelocity(w * (turn / w.length()));
  }
}

bool Heap::State::rests() const {
  return std::all_of(parts.begin(), parts.end(),
                     [](const auto& part) { return !part.second->isActive(); });
}

double Heap::State::top() const {
  double z = 0.0;
  for (const auto& part : parts) {
    btVector3 low, high;
    part.second->getAabb(low, high);
    z = std::max(z, static_cast<double>(high.z()) / kUnits);
  }
  return z;
}

Heap::Heap(const Bin& bin, const std::vector<Shape>& shapes, std::uint64_t seed, double density)
    : state_(std::make_unique<State>()) {
  state_->bin = bin;
  state_->random.seed(seed);
  for (const Shape& shape : shapes) state_->kinds.push_back(makeKind(shape, density));
  state_->world.setGravity(btVector3(0.0, 0.0, -kUnits * kGravity));
  state_->world.getSolverInfo().m_numIterations = 30;
  state_->world.getSolverInfo().m_splitImpulse = 1;
  // Far higher than the bin: nothing that is poured falls beside it.
  constexpr double kThick = 0.05, kHigh = 1.0;
  const double x = 0.5 * bin.length, y = 0.5 * bin.width;
  state_->addBox({x + 2 * kThick, y + 2 * kThick, kThick}, {0.0, 0.0, -kThick});
  for (const int side : {-1, 1}) {
    state_->addBox({kThick, y + kThick, kHigh}, {side * (x + kThick), 0.0, kHigh});
    state_->addBox({x + kThick, kThick, kHigh}, {0.0, side * (y + kThick), kHigh});
  }
}

Heap::~Heap() {
  for (auto& part : state_->parts) state_->world.removeRigidBody(part.second.get());
  for (auto& wall : state_->walls) state_->world.removeRigidBody(wall.get());
}

void Heap::pour(int kind, int count) {
  constexpr double kPi = 3.14159265358979323846, kSteepest = 0.6, kInterval = 0.12;
  const double radius = state_->kinds.at(static_cast<std::size_t>(kind)).radius;
  state_->damp(0.05);
  for (int i = 0; i < count; ++i) {
    const double x = std::max(0.0, 0.5 * state_->bin.length - 0.8 * radius),
                 y = std::max(0.0, 0.5 * state_->bin.width - 0.8 * radius);
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.linear() =
        (Eigen::AngleAxisd(state_->uniform(-kSteepest, kSteepest), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(state_->uniform(-kSteepest, kSteepest), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(state_->uniform(-kPi, kPi), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(state_->uniform(0.0, 1.0) < 0.5 ? kPi : 0.0, Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    const Eigen::Vector3d center(state_->uniform(-x, x), state_->uniform(-y, y),
                                 state_->top() + 0.7 * radius + 0.01);
    T.translation() = center - T.linear() * state_->kinds[static_cast<std::size_t>(kind)].center;
    state_->add(kind, T);
    state_->parts.rbegin()->second->setLinearVelocity(btVector3(0.0, 0.0, -kUnits * kFastest));
    for (double t = 0.0; t < kInterval; t += kStep) state_->step();
  }
  settle(4.0);
}

int Heap::put(int kind, const Eigen::Isometry3d& T_base_part) {
  return state_->add(kind, T_base_part);
}

bool Heap::settle(double seconds_max) {
  // First as it is; then what the solver still jitters is damped away: where something can rest, it
  // does. Bullet puts bodies to sleep after two calm seconds; a quarter is enough here.
  constexpr double kCalm = 0.25;
  const double calm_before = gDeactivationTime;
  gDeactivationTime = kCalm;
  state_->damp(0.2);
  double t = 0.0;
  for (; t < 0.6 * seconds_max && !state_->rests(); t += kStep) state_->step();
  state_->damp(0.98);
  for (; t < seconds_max && !state_->rests(); t += kStep) state_->step();
  gDeactivationTime = calm_before;
  return state_->rests();
}

void Heap::remove(int id) {
  const auto found = state_->parts.find(id);
  if (found == state_->parts.end())
    throw std::out_of_range("the heap has no part " + std::to_string(id));
  state_->world.removeRigidBody(found->second.get());
  state_->parts.erase(found);
  state_->kind_of.erase(id);
  state_->wake();
  settle(2.0);
}

void Heap::push(int id, const Eigen::Vector3d& point_base, const Eigen::Vector3d& speed_base) {
  btRigidBody& body = *state_->parts.at(id);
  state_->wake();
  const btVector3 arm = toBullet(point_base) - body.getCenterOfMassPosition();
  body.applyImpulse(toBullet(speed_base) / body.getInvMass(), arm);
  settle(2.0);
}

std::vector<Body> Heap::bodies() const {
  std::vector<Body> list;
  for (const auto& [id, body] : state_->parts) {
    const int kind = state_->kind_of.at(id);
    const Kind& k = state_->kinds[static_cast<std::size_t>(kind)];
    list.push_back(
        {id, kind, fromBullet(body->getWorldTransform()) * Eigen::Translation3d(-k.center)});
  }
  return list;
}

double Heap::load(int id) const {
  const btRigidBody& part = *state_->parts.at(id);
  const auto contactWith = [&](const btCollisionObject& body, const btVector3& point_base) {
    const auto kind = state_->kind_of.find(body.getUserIndex());
    if (kind == state_->kind_of.end()) return Contact::kOnFace;  // the bin
    return contactOf(state_->kinds[static_cast<std::size_t>(kind->second)],
                     body.getWorldTransform().inverse() * point_base);
  };
  struct Push {
    double impulse = 0.0;
    btVector3 moment = btVector3(0.0, 0.0, 0.0);
  };
  std::map<const btCollisionObject*, Push> pushes;  // by who pushes
  for (int i = 0; i < state_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& m = *state_->dispatcher.getManifoldByIndexInternal(i);
    const bool is_first = m.getBody0() == &part, is_second = m.getBody1() == &part;
    if (!is_first && !is_second) continue;
    const btCollisionObject& other = *(is_first ? m.getBody1() : m.getBody0());
    Push& push = pushes[&other];
    for (int c = 0; c < m.getNumContacts(); ++c) {
      const btManifoldPoint& point = m.getContactPoint(c);
      // The normal points from the second body to the first: along it the first is pushed.
      const double up = point.m_normalWorldOnB.z() * (is_first ? 1.0 : -1.0);
      if (up >= 0.0) continue;
      const btVector3& at = is_first ? point.getPositionWorldOnA() : point.getPositionWorldOnB();
      // The pieces of a collision shape bridge gaps, such as those between teeth.
      if (contactWith(part, at) == Contact::kBesidePart ||
          contactWith(other, at) == Contact::kBesidePart)
        continue;
      const double impulse = -up * point.getAppliedImpulse();
      push.impulse += impulse;
      push.moment += static_cast<btScalar>(impulse) * at;
    }
  }
  double impulse = 0.0;
  for (const auto& [other, push] : pushes) {
    if (push.impulse <= 0.0) continue;
    const btVector3 middle = push.moment / static_cast<btScalar>(push.impulse);
    const bool rim_on_rim = contactWith(part, middle) == Contact::kAtRim &&
                            contactWith(*other, middle) == Contact::kAtRim;
    if (!rim_on_rim) impulse += push.impulse;
  }
  return impulse / kStep * part.getInvMass() / (kUnits * kGravity);
}

double Heap::deepestPenetration() const {
  double deepest = 0.0;
  for (int i = 0; i < state_->dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& m = *state_->dispatcher.getManifoldByIndexInternal(i);
    for (int c = 0; c < m.getNumContacts(); ++c)
      deepest =
          std::max(deepest, -static_cast<double>(m.getContactPoint(c).getDistance()) / kUnits);
  }
  return deepest;
}

}  // namespace planar_bin_picking::cell
