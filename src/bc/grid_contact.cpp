#include "bc/grid_contact.hpp"

#include <algorithm>
#include <cmath>

namespace berm {

void GridContact::set(std::vector<FieldContact> contacts) {
  contacts_ = std::move(contacts);
  if (contacts_.empty()) carried_.clear();
}

Vec3 GridContact::carried(const Discretisation& d, const Interface& at) const {
  const auto found = carried_.find({d.halo.ids[at.a], at.field_b});
  return found == carried_.end() ? Vec3(Vec3::Zero()) : found->second;
}

bool GridContact::some_at_once() const {
  return std::any_of(touches_.begin(), touches_.end(), [](const Touch& t) { return t.at_once && t.contact.friction > 0.0; });
}

void GridContact::begin_step(const Discretisation& d) {
  touches_.clear();
  if (contacts_.empty()) return;
  // Forces at t_n by pair of fields, and those that are still at their nodes. Nodes are numbered field by field.
  const auto n_places = static_cast<std::int64_t>(d.node_places().size());
  std::vector<double> forces(contacts_.size(), 0.0), kept(contacts_.size(), 0.0);
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    for (const auto& [at, force] : carried_)
      forces[k] += contacts_[k].field_a == static_cast<int>(at.first / n_places) && contacts_[k].field_b == at.second;
  std::vector<std::size_t> contact_of;
  for (const Interface& at : d.interfaces())
    for (std::size_t k = 0; k < contacts_.size(); ++k) {
      const FieldContact& c = contacts_[k];
      if (c.field_a != at.field_a || c.field_b != at.field_b || at.normal.isZero(0.0)) continue;
      Touch t{&at, c, carried(d, at), at.gap};
      // What touched at t_n has no gap: the one seen by the points is only an estimate.
      if (!t.carried.isZero(0.0)) t.gap = 0.0;
      kept[k] += !t.carried.isZero(0.0);
      touches_.push_back(t);
      contact_of.push_back(k);
    }
  d.comm().sum(std::span<double>(kept));
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    Touch& t = touches_[i];
    t.meets = forces[contact_of[i]] == 0.0;
    t.at_once = at_once_ && (t.meets || (settled_at_once_ && kept[contact_of[i]] == forces[contact_of[i]]));
  }
}

/// [contact (5) - (7)]. Bodies that just touch count as closed, so that one that is laid on another is held from the first
/// guess on. What limits friction is the pressure at t_n, or that of now where bodies come together or stay where they are; where
/// they move on to other nodes it would count twice, there and at those that they leave.
GridContact::Force GridContact::force_at(const Touch& t, const Vec3& relative) const {
  const Vec3& n = t.at->normal;
  const double k = t.contact.stiffness * t.at->area;
  const Vec3 trial = t.carried + k * relative;
  Force f;
  f.pressure = trial.dot(n) - k * t.gap;
  f.shear = trial - n * n.dot(trial);
  const double size = f.shear.norm(), limit = t.contact.friction * std::max(0.0, t.at_once ? f.pressure : t.carried.dot(n));
  f.status = t.status;
  if (t.status == Status::undecided)
    f.status = f.pressure < 0.0 && !(t.meets && t.gap < kept_closed_) ? Status::open : size <= limit && (limit > 0.0 || (t.at_once && t.contact.friction > 0.0)) ? Status::sticks : Status::slides;
  if (f.status == Status::open) return {};
  const Mat3 nn = n * n.transpose();
  if (f.status == Status::sticks) {
    f.stiffness = k * Mat3::Identity();
  } else if (t.status == Status::slides) {
    f.shear = t.shear;
    f.stiffness = k * nn;
  } else {
    const Vec3 direction = size > 0.0 ? Vec3(f.shear / size) : Vec3::Zero();
    f.shear = limit * direction;
    f.stiffness = k * nn;
    if (limit > 0.0) f.stiffness += k * limit / size * (Mat3::Identity() - nn - direction * direction.transpose());
    if (limit > 0.0 && t.at_once && settled_at_once_) f.stiffness += k * t.contact.friction * direction * n.transpose();
  }
  f.force = f.pressure * n + f.shear;
  return f;
}

void GridContact::freeze(const NodalVector& du) {
  for (Touch& t : touches_) {
    const Force f = force_at(t, du[t.at->a] - du[t.at->b]);
    t.status = f.status;
    t.shear = f.shear;
  }
}

double GridContact::violation(const Discretisation& d, const NodalVector& du) const {
  if (contacts_.empty()) return 0.0;
  double off = 0.0, size = 0.0;
  for (Touch t : touches_) {
    const Vec3 relative = du[t.at->a] - du[t.at->b], force = force_at(t, relative).force;
    t.status = Status::undecided;
    const Vec3 law = force_at(t, relative).force;
    off += (force - law).squaredNorm();
    size += law.squaredNorm();
  }
  off = d.comm().sum(off);
  size = d.comm().sum(size);
  return off == 0.0 ? 0.0 : std::sqrt(off / std::max(size, 1e-12 * off));
}

void GridContact::add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f,
                             BlockAssembler* matrix) const {
  const int dim = d.dimension(), width = 2 * dim;
  std::array<double, 36> K;
  for (const Touch& t : touches_) {
    const Force force = force_at(t, du[t.at->a] - du[t.at->b]);
    if (force.status == Status::open) continue;
    f[t.at->a] += force.force;
    f[t.at->b] -= force.force;
    if (!matrix) continue;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        for (int p = 0; p < dim; ++p)
          for (int q = 0; q < dim; ++q)
            K[(dim * i + p) * width + dim * j + q] = (i == j ? 1.0 : -1.0) * force.stiffness(p, q);
    matrix->add(t.at->block, K.data());
  }
}

/// Heat is the work of the shear on the slip, which is the motion along the surface less that of the penalty's spring.
/// [contact (8)]
ContactWork GridContact::work(const NodalVector& du) const {
  ContactWork sum;
  for (const Touch& t : touches_) {
    const Vec3 relative = du[t.at->a] - du[t.at->b], &n = t.at->normal;
    const Force f = force_at(t, relative);
    sum.total += 0.5 * (t.carried + f.force).dot(relative);
    if (f.status == Status::sticks) continue;
    const Vec3 before = t.carried - n * n.dot(t.carried);  // of what opens: works over half of the step, and is let go
    const Vec3 slip = relative - n * n.dot(relative) - (f.shear - before) / (t.contact.stiffness * t.at->area);
    sum.heat += 0.5 * (before + f.shear).dot(slip);
  }
  return sum;
}

/// Tension is dropped, shear beyond the limit is cut, that of one that slides grows with the pressure.   [(6)]
void GridContact::commit(const Discretisation& d, const NodalVector& du) {
  if (contacts_.empty()) return;
  std::vector<double> mine;
  for (const Touch& t : touches_) {
    const Force f = force_at(t, du[t.at->a] - du[t.at->b]);
    if (f.status == Status::open || f.pressure <= 0.0) continue;
    const double limit = t.contact.friction * f.pressure, size = f.shear.norm();
    const bool cut = size > limit || (f.status == Status::slides && size > 0.0);
    const Vec3 force = f.pressure * t.at->normal + (cut ? limit / size : 1.0) * f.shear;
    mine.insert(mine.end(), {double(d.halo.ids[t.at->a]), double(t.at->field_b), force.x(), force.y(), force.z()});
  }
  restore(d.comm().all_gather(mine));
}

double GridContact::scatter(const Discretisation& d) const {
  constexpr double little = 0.1;  // of the mean: a node beside an edge that a body comes to, and that bears next to nothing
  double largest = 0.0, all = 0.0;
  for (const auto& [at, force] : carried_) all += force.norm();
  const double least = little * all / static_cast<double>(std::max<std::size_t>(1, carried_.size()));
  for (const Touch& t : touches_)
    if (t.carried.isZero(0.0) && carried(d, *t.at).norm() > least) largest = std::max(largest, t.at->scatter);
  return largest;
}

std::vector<double> GridContact::rows() const {
  std::vector<double> rows;
  for (const auto& [at, force] : carried_)
    rows.insert(rows.end(), {double(at.first), double(at.second), force.x(), force.y(), force.z()});
  return rows;
}

void GridContact::restore(const std::vector<double>& rows) {
  carried_.clear();
  for (std::size_t k = 0; k + 4 < rows.size(); k += 5)
    carried_[{static_cast<std::int64_t>(rows[k]), static_cast<int>(rows[k + 1])}] =
        Vec3(rows[k + 2], rows[k + 3], rows[k + 4]);
}

}  // namespace berm
