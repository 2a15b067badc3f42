/// Where the fields of the grid meet (docs/theory/contact.md).

#include <cmath>

#include "transfer/mpm.hpp"

namespace berm {

/// Pairs of nodes of different fields at the same place, and their blocks.
void MpmDiscretisation::pair_nodes() {
  interfaces_.clear();
  const int n = grid_.mesh.n_nodes();
  for (int node = 0; node < halo.n_owned; ++node) {
    const std::int64_t id = halo.ids[node];
    for (int field = static_cast<int>(id / n) + 1; field < n_fields_; ++field) {
      const int other = halo.find(id % n + std::int64_t(field) * n);
      if (other < 0) continue;
      Interface at;
      at.field_a = static_cast<int>(id / n);
      at.field_b = field;
      at.a = node;
      at.b = other;
      at.block = blocks.size();
      interfaces_.push_back(at);
      const std::array<int, 2> pair = {node, other};
      blocks.add(pair);
    }
  }
}

/// Normals and areas from the gradients of the volume of the two fields, gaps from their outermost points.
/// [contact (1) - (3)]
void MpmDiscretisation::look_at_interfaces(const std::vector<char>& held) {
  if (n_fields_ == 1) return;
  const int d = dimension();
  NodalVector outward(n_nodes(), Vec3::Zero());
  const auto swollen = [&](int p) { return total_lagrangian_ ? 1.0 : material.F[p].determinant(); };
  for_points([&](std::span<const int> list, int p, const double* s) {
    const int n = static_cast<int>(list.size());
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < d; ++i) outward[list[k]][i] += material.volume[p] * swollen(p) * s[n + d * k + i];
  });
  halo.add_to_owners(reinterpret_cast<double*>(outward.data()), 3);
  NodalVector normal(n_nodes(), Vec3::Zero());  // at the nodes of both fields, out of the one with the lower number
  for (Interface& at : interfaces_) {
    // On a plane of symmetry, and at every face that is held, bodies end without a surface for the other.
    for (int i = 0; i < d; ++i)
      if (held[d * at.a + i] && held[d * at.b + i]) outward[at.a][i] = outward[at.b][i] = 0.0;
    at.area = std::max(outward[at.a].norm(), outward[at.b].norm());
    // The larger gradient knows better: at the corner of a body on a flat one that of the flat one.
    const Vec3 difference = std::pow(outward[at.a].squaredNorm(), 4) * outward[at.a] -
                            std::pow(outward[at.b].squaredNorm(), 4) * outward[at.b];
    const double size = difference.norm();
    at.normal = size > 0.0 ? Vec3(difference / size) : Vec3::Zero();
    normal[at.a] = at.normal;
    normal[at.b] = -at.normal;
  }
  halo.copy_to_ghosts(reinterpret_cast<double*>(normal.data()), 3);

  // How far each field reaches along its own normal.
  std::vector<double> reach(n_nodes(), -infinity);
  for_points([&](std::span<const int> list, int p, const double*) {
    const double half = 0.5 * std::pow(measure_[p] * swollen(p), 1.0 / d);
    for (const int node : list)
      if (!normal[node].isZero(0.0))
        reach[node] = std::max(reach[node], normal[node].dot(seen(p) - nodes[node]) + half);
  });
  halo.combine_at_owners(reach.data(), 1, [](double& a, double b) { a = std::max(a, b); });
  for (Interface& at : interfaces_) {
    const double spacing = 0.5 * cell_size_;
    at.gap = std::max(0.0, -(reach[at.a] + reach[at.b]) - 0.5 * spacing);
    if (!std::isfinite(at.gap)) at.normal.setZero();  // a node without material: only surface points are near
  }
}

}  // namespace berm
