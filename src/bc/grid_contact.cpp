#include "bc/grid_contact.hpp"

#include "bc/coulomb.hpp"

namespace berm {

const FieldContact* GridContact::find(const Interface& at) const {
  for (const FieldContact& c : contacts_)
    if (c.field_a == at.field_a && c.field_b == at.field_b) return &c;
  return nullptr;
}

void GridContact::add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f,
                             BlockAssembler* matrix) const {
  if (contacts_.empty()) return;
  const int dim = d.dimension(), width = 2 * dim;
  std::array<double, 36> K;
  for (const Interface& at : d.interfaces()) {
    const FieldContact* contact = find(at);
    if (!contact || at.normal.isZero(0.0)) continue;
    const CoulombForce c = coulomb(du[at.a] - du[at.b], at.normal, at.gap, contact->stiffness, contact->friction);
    if (!c.touches) continue;
    f[at.a] += c.force;
    f[at.b] -= c.force;
    if (!matrix) continue;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        for (int p = 0; p < dim; ++p)
          for (int q = 0; q < dim; ++q)
            K[(dim * i + p) * width + dim * j + q] = (i == j ? 1.0 : -1.0) * c.stiffness(p, q);
    matrix->add(at.block, K.data());
  }
}

double GridContact::work(const Discretisation& d, const NodalVector& du) const {
  double sum = 0.0;
  if (contacts_.empty()) return sum;
  for (const Interface& at : d.interfaces()) {
    const FieldContact* contact = find(at);
    if (!contact || at.normal.isZero(0.0)) continue;
    const Vec3 relative = du[at.a] - du[at.b];
    sum += coulomb(relative, at.normal, at.gap, contact->stiffness, contact->friction).force.dot(relative);
  }
  return sum;
}

}  // namespace berm
