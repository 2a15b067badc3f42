/// Where the fields of the grid meet (docs/theory/contact.md).

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// Sums of a Newton step of (2) at a node: gradient, upper triangle of the matrix, by the coordinates and 1; weights.
constexpr int sums = 4 + 10 + 1;

/// The plane phi . (xi, 1) = 0 between two clouds of points, by one Newton step from phi.
void improve(const double* at, int unknowns, Eigen::Vector4d& phi) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd gradient(unknowns);
  const double* m = at + 4;
  for (int i = 0; i < unknowns; ++i) {
    gradient[i] = at[i];
    for (int j = i; j < unknowns; ++j) matrix(i, j) = matrix(j, i) = *m++;
  }
  const Eigen::VectorXd step = matrix.llt().solve(gradient);
  if (step.allFinite()) phi.head(unknowns) -= step;
}

/// Whether a point counts at a node of its list with this value there. Lists are those of patches: which of their nodes no
/// point of the patch reaches depends on the process that holds it (docs/adr/0014).
bool reaches(double N) { return N > 1e-9; }

/// At the nodes of both fields: a direction of each interface, out of the field.
template <class Direction>
NodalVector out_of_fields(const std::vector<Interface>& interfaces, int n_nodes, Direction direction) {
  NodalVector out(n_nodes, Vec3::Zero());
  for (std::size_t i = 0; i < interfaces.size(); ++i) {
    out[interfaces[i].a] = direction(i);
    out[interfaces[i].b] = -out[interfaces[i].a];
  }
  return out;
}

constexpr double facing_enough = 0.5;  ///< cosine: sides of a corner do not count

}  // namespace

/// Pairs of nodes of different fields at the same place, and their blocks.
void MpmDiscretisation::pair_nodes() {
  interfaces_.clear();
  const int n = basis_.n_nodes();
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

/// Areas and, where there is nothing better, normals from the gradients of the volume of the two fields.   [contact
/// (1)]
void MpmDiscretisation::surfaces_of_interfaces(const std::vector<char>& held) {
  const int d = dimension();
  NodalVector outward(n_nodes(), Vec3::Zero());
  for_points([&](std::span<const int> list, int p, const double* s) {
    const int n = static_cast<int>(list.size());
    const double volume = material.volume[p] * swollen(p);
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < d; ++i) outward[list[k]][i] += volume * s[n + d * k + i];
  });
  halo.add_to_owners(reinterpret_cast<double*>(outward.data()), 3);
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
  }
}

/// Normals of the planes that part the points of the two fields best: logistic regression.   [contact (2)]
void MpmDiscretisation::separate_points(const std::vector<char>& held) {
  constexpr int iterations = 12;
  constexpr double penalty = 1e-4;  // keeps clouds that can be parted from steepening the step for ever
  const int d = dimension();
  std::vector<Eigen::Vector4d> phi(n_nodes(), Eigen::Vector4d::Zero());  // of nodes in contact: field a below, b above
  std::vector<double> label(n_nodes(), 0.0);
  for (const Interface& at : interfaces_) {
    label[at.a] = -1.0;
    label[at.b] = 1.0;
  }
  halo.copy_to_ghosts(label.data(), 1);
  std::vector<double> sum(std::size_t(sums) * n_nodes());
  for (int iteration = 0; iteration < iterations; ++iteration) {
    halo.copy_to_ghosts(reinterpret_cast<double*>(phi.data()), 4);
    std::fill(sum.begin(), sum.end(), 0.0);
    for_points([&](std::span<const int> list, int p, const double* N) {
      const double weight = measure_[p] * swollen(p) / std::pow(cell_size_, d);
      for (std::size_t k = 0; k < list.size(); ++k) {
        const int node = list[k];
        if (label[node] == 0.0 || !reaches(N[k])) continue;
        Eigen::Vector4d xi = Eigen::Vector4d::Zero();
        xi.head(d) = (now(p) - nodes[node]).head(d) / cell_size_;
        xi[d] = 1.0;
        const double wrong = 1.0 / (1.0 + std::exp(label[node] * phi[node].dot(xi)));
        double* at = sum.data() + std::size_t(sums) * node;
        for (int i = 0; i <= d; ++i) at[i] -= weight * label[node] * wrong * xi[i];
        at[sums - 1] += weight;
        double* m = at + 4;
        for (int i = 0; i <= d; ++i)
          for (int j = i; j <= d; ++j) *m++ += weight * wrong * (1.0 - wrong) * xi[i] * xi[j];
      }
    });
    halo.add_to_owners(sum.data(), sums);
    for (const Interface& at : interfaces_) {
      double* a = sum.data() + std::size_t(sums) * at.a;
      const double* b = sum.data() + std::size_t(sums) * at.b;
      for (int k = 0; k < sums; ++k) a[k] += b[k];
      double* m = a + 4;
      for (int i = 0; i <= d; ++i) {
        a[i] += penalty * a[sums - 1] * phi[at.a][i];
        *m += penalty * a[sums - 1];
        m += d + 1 - i;
      }
      improve(a, d + 1, phi[at.a]);
      phi[at.b] = phi[at.a];
    }
  }
  for (Interface& at : interfaces_) {
    Vec3 normal = Vec3::Zero();
    normal.head(d) = phi[at.a].head(d);
    for (int i = 0; i < d; ++i)
      if (held[d * at.a + i] && held[d * at.b + i]) normal[i] = 0.0;
    if (normal.allFinite() && normal.norm() > 1e-3 && !at.normal.isZero(0.0)) at.normal = normal.normalized();
  }
}

/// Normal of the surface that a point is next to, where that is now.   [contact (3)]
Vec3 MpmDiscretisation::outward_at(int p) const {
  return (material.F[p].inverse().transpose() * rim_[p]).normalized();
}

/// Where points know the surface that they are next to, the normal is that of the surfaces that face each other: a plane that
/// parts the points only is tilted at a corner, and a block that slides climbs it. Where the two differ, as at the corner of
/// one body on the side of another, that counts along which they are farther apart.   [contact (2a)]
void MpmDiscretisation::face_surfaces(const std::vector<char>& held) {
  constexpr double alike = 0.95;  // cosine
  constexpr double equal = 0.1;   // of a cell: a difference by half of it decides
  const int d = dimension();
  NodalVector outward = out_of_fields(interfaces_, n_nodes(), [this](std::size_t i) { return interfaces_[i].normal; });
  NodalVector facing(n_nodes(), Vec3::Zero());
  halo.copy_to_ghosts(reinterpret_cast<double*>(outward.data()), 3);
  for_points([&](std::span<const int> list, int p, const double* N) {
    if (rim_[p].isZero(0.0)) return;
    const Vec3 m = outward_at(p);
    for (std::size_t k = 0; k < list.size(); ++k) {
      const double cosine = m.dot(outward[list[k]]);
      if (reaches(N[k]) && cosine >= facing_enough) facing[list[k]] += N[k] * measure_[p] * cosine * cosine * m;
    }
  });
  halo.add_to_owners(reinterpret_cast<double*>(facing.data()), 3);
  std::vector<std::array<Vec3, 2>> choice;  // by interface: what the surface of a, and of b, says
  std::vector<Vec3> mean;                   // of both: the one with more of its material near counts more
  bool differ = false;
  for (const Interface& at : interfaces_) {
    Vec3 of_a = facing[at.a], of_b = -facing[at.b];
    for (int i = 0; i < d; ++i)
      if (held[d * at.a + i] && held[d * at.b + i]) of_a[i] = of_b[i] = 0.0;
    if (of_a.isZero(0.0)) of_a = of_b;
    if (of_b.isZero(0.0)) of_b = of_a;
    mean.push_back((of_a + of_b).normalized());
    choice.push_back({of_a.normalized(), of_b.normalized()});
    differ |= !of_a.isZero(0.0) && choice.back()[0].dot(choice.back()[1]) < alike;
  }
  std::array<std::vector<double>, 2> apart;
  if (comm_.any(differ))
    for (int k = 0; k < 2; ++k) {
      outward = out_of_fields(interfaces_, n_nodes(), [&](std::size_t i) { return choice[i][k]; });
      const std::vector<Extent> extent = extents_along(outward);
      for (const Interface& at : interfaces_) apart[k].push_back(-extent[at.a].place - extent[at.b].place);
    }
  for (std::size_t i = 0; i < interfaces_.size(); ++i) {
    const auto& [of_a, of_b] = choice[i];
    if (interfaces_[i].normal.isZero(0.0) || of_a.isZero(0.0)) continue;
    if (of_a.dot(of_b) >= alike) {
      interfaces_[i].normal = mean[i];
      continue;
    }
    // Equal distances, as between two round bodies, are not for rounding to decide.
    const double difference = apart[0][i] - apart[1][i];
    const double share = std::isfinite(difference) ? std::clamp(0.5 + difference / (equal * cell_size_), 0.0, 1.0) : 0.5;
    const Vec3 normal = share * of_a + (1.0 - share) * of_b;
    interfaces_[i].normal = normal.norm() > 0.1 ? normal.normalized() : of_a;
  }
}

/// How far the fields reach along the given direction at their nodes (zero: not asked for): the mean of what the points next to
/// the surface there say; where none does, how far the domains of the points reach.   [contact (3), (4)]
std::vector<MpmDiscretisation::Extent> MpmDiscretisation::extents_along(NodalVector& normal) const {
  halo.copy_to_ghosts(reinterpret_cast<double*>(normal.data()), 3);
  NodalVector height(n_nodes(), Vec3::Zero());  // sums of weight, weight times height, weight times its square
  std::vector<double> reach(n_nodes(), -infinity);
  for_points([&](std::span<const int> list, int p, const double* N) {
    const Vec3 rim = material.F[p] * rim_[p];
    const Vec3 outward = rim.isZero(0.0) ? rim : outward_at(p);
    const Mat3 E = edges(p);
    for (std::size_t k = 0; k < list.size(); ++k) {
      const int node = list[k];
      const Vec3& n = normal[node];
      if (n.isZero(0.0) || !reaches(N[k])) continue;
      const Vec3 from_node = now(p) - nodes[node];
      reach[node] = std::max(reach[node], n.dot(from_node) + 0.5 * (n.transpose() * E).head(dimension()).cwiseAbs().sum());
      const double facing = outward.dot(n);
      if (facing < facing_enough) continue;
      const double z = outward.dot(from_node + rim) / facing, weight = N[k] * measure_[p] * facing * facing;
      height[node] += weight * Vec3(1.0, z, z * z);
    }
  });
  halo.add_to_owners(reinterpret_cast<double*>(height.data()), 3);
  halo.combine_at_owners(reach.data(), 1, [](double& a, double b) { a = std::max(a, b); });
  std::vector<Extent> extents(n_nodes());
  for (int node = 0; node < n_nodes(); ++node) {
    const Vec3& sum = height[node];
    extents[node] = {reach[node], cell_size_ * cell_size_ / 16.0};
    if (sum[0] > 0.0) extents[node] = {sum[1] / sum[0], std::max(0.0, sum[2] / sum[0] - std::pow(sum[1] / sum[0], 2))};
  }
  return extents;
}

/// How far apart the surfaces of the two fields are along the normal at a node.   [contact (4)]
void MpmDiscretisation::gaps_of_interfaces() {
  NodalVector normal = out_of_fields(interfaces_, n_nodes(), [this](std::size_t i) { return interfaces_[i].normal; });
  const std::vector<Extent> extent = extents_along(normal);
  for (Interface& at : interfaces_) {
    at.gap = std::max(0.0, -extent[at.a].place - extent[at.b].place);
    at.scatter = std::sqrt(extent[at.a].variance + extent[at.b].variance);
    if (!std::isfinite(at.gap)) at.normal.setZero();  // a node without material: only surface points are near
  }
}

void MpmDiscretisation::look_at_interfaces(const std::vector<char>& held) {
  if (n_fields_ == 1) return;
  surfaces_of_interfaces(held);
  separate_points(held);
  face_surfaces(held);
  gaps_of_interfaces();
}

}  // namespace berm
