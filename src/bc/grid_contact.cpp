#include "bc/grid_contact.hpp"

namespace berm {

const FieldContact* GridContact::find(const Interface& at) const {
  for (const FieldContact& c : contacts_)
    if (c.field_a == at.field_a && c.field_b == at.field_b) return &c;
  return nullptr;
}

Vec3 GridContact::carried(const Discretisation& d, const Interface& at) const {
  const auto found = carried_.find({d.halo.ids[at.a], at.field_b});
  return found == carried_.end() ? Vec3(Vec3::Zero()) : found->second;
}

template <class Work>
void GridContact::for_touching(const Discretisation& d, const NodalVector& du, Work work) const {
  if (contacts_.empty()) return;
  for (const Interface& at : d.interfaces()) {
    const FieldContact* contact = find(at);
    if (!contact || at.normal.isZero(0.0)) continue;
    // What touched at t_n has no gap: the one seen by the points is only an estimate.
    const Vec3 before = carried(d, at);
    const double gap = before.isZero(0.0) ? at.gap : 0.0;
    const CoulombForce c = coulomb(du[at.a] - du[at.b], before, at.normal, gap, contact->stiffness, contact->friction);
    if (c.touches) work(at, c);
  }
}

void GridContact::add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f,
                             BlockAssembler* matrix) const {
  const int dim = d.dimension(), width = 2 * dim;
  std::array<double, 36> K;
  for_touching(d, du, [&](const Interface& at, const CoulombForce& c) {
    f[at.a] += c.force;
    f[at.b] -= c.force;
    if (!matrix) return;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        for (int p = 0; p < dim; ++p)
          for (int q = 0; q < dim; ++q)
            K[(dim * i + p) * width + dim * j + q] = (i == j ? 1.0 : -1.0) * c.stiffness(p, q);
    matrix->add(at.block, K.data());
  });
}

double GridContact::work(const Discretisation& d, const NodalVector& du) const {
  double sum = 0.0;
  for_touching(d, du, [&](const Interface& at, const CoulombForce& c) {
    sum += 0.5 * (carried(d, at) + c.force).dot(du[at.a] - du[at.b]);
  });
  return sum;
}

void GridContact::commit(const Discretisation& d, const NodalVector& du) {
  if (contacts_.empty()) return;
  std::vector<double> mine;
  for_touching(d, du, [&](const Interface& at, const CoulombForce& c) {
    mine.insert(mine.end(), {double(d.halo.ids[at.a]), double(at.field_b), c.force.x(), c.force.y(), c.force.z()});
  });
  restore(d.comm().all_gather(mine));
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
