/// Mixed formulation: displacements and pressures at the nodes, both linear [formulation, section 15, (47) to (53)].

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// The unit tensor in the directions that can change a volume, by the components of grad u.
template <int components>
Eigen::Matrix<double, components, 1> dilatation() {
  Eigen::Matrix<double, components, 1> one = Eigen::Matrix<double, components, 1>::Zero();
  constexpr int d = components == 9 ? 3 : 2;
  for (int i = 0; i < d; ++i) one[(d + 1) * i] = 1.0;
  if (components == 5) one[4] = 1.0;
  return one;
}

/// A stress by the components of grad u.
template <int components>
Eigen::Matrix<double, components, 1> by_components(const Voigt& stress) {
  const Mat3 s = response_detail::tensor(stress);
  constexpr int d = components == 9 ? 3 : 2;
  Eigen::Matrix<double, components, 1> out;
  for (int i = 0; i < d; ++i)
    for (int j = 0; j < d; ++j) out[d * i + j] = s(i, j);
  if (components == 5) out[4] = s(2, 2);
  return out;
}

/// Of the principal stresses, 0 where all are compressive.
double largest_tension(const Voigt& stress) {
  const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(response_detail::tensor(stress), Eigen::EigenvaluesOnly);
  return std::max(0.0, spectrum.eigenvalues()[2]);
}

}  // namespace

/// Cells with points have pressures at their nodes. A pressure is a node of its own, a layer above all fields; its first
/// component is the increment of the step over `pressure_unit_`, the others stay zero.
void MpmDiscretisation::add_pressure_blocks() {
  scalar_nodes_.clear();
  pressure_block_.assign(active_cells_.size(), -1);
  if (!mixed_) return;
  const int layers = n_fields_ * basis_.n_nodes();
  for (int node = 0; node < halo.size(); ++node)
    if (halo.ids[node] >= layers) scalar_nodes_.push_back(node);
  std::vector<int> list(2 * std::size_t(basis_.most_nodes()));
  for (const int a : filled_cells()) {
    const std::span<const int> own = blocks[a];
    const std::size_t n = own.size();
    for (std::size_t k = 0; k < n; ++k) {
      list[k] = own[k];
      list[n + k] = local_node_[halo.ids[own[k]] + layers];
    }
    pressure_block_[a] = blocks.size();
    blocks.add({list.data(), 2 * n});
  }
}

/// Active cells with points.
std::vector<int> MpmDiscretisation::filled_cells() const {
  std::vector<int> filled;
  for (std::size_t a = 0; a < active_cells_.size(); ++a)
    if (first_[a + 1] > first_[a]) filled.push_back(static_cast<int>(a));
  return filled;
}

/// Elastic constants of the points' laws, stiffness against volume changes in the model's directions [Pa], and the share of
/// its own volume that a point in tension keeps.   [(48)]
void MpmDiscretisation::look_up_elasticity() {
  trial_stretch_.assign(x_.size(), 1.0);
  excess_.resize(x_.size());
  bulk_.resize(x_.size());
  shear_.resize(x_.size());
  own_share_.resize(x_.size());
  constexpr double most = 0.5;  // with all of it nothing would determine the pressures
  for (const Slice& slice : material.slices) {
    const Lame c = elastic_constants(slice.law).value();
    const double resists = is_plastic(slice.law) ? 0.0 : c.mu;
    for (int p = slice.begin; p < slice.end; ++p) {
      bulk_[p] = c.lambda + 2.0 * c.mu / volumetric_directions();
      shear_[p] = c.mu;
      const double tension = material.F[p].determinant() * largest_tension(material.stress[p]);
      own_share_[p] = std::clamp((tension - resists) / bulk_[p], 0.0, most);
    }
  }
}

/// The trial deformation gradients get the volume that belongs to the pressure; excess_: how much more they had.
/// [formulation (48), (49)]
Status MpmDiscretisation::volumes_of_pressures(const NodalVector& du) {
  const int m = volumetric_directions();
  const bool small = kinematics_ == Kinematics::small;
  nodal_pressure_.resize(n_nodes());
  for (int node : scalar_nodes_) nodal_pressure_[node] = pressure_unit_ * du[node].x();
  for (const int a : filled_cells()) {
    const std::span<const int> list = blocks[pressure_block_[a]];
    const std::size_t n = list.size() / 2;
    for (int p : points_in(a)) {
      double volumetric;
      if (small) {
        volumetric = (material.trial_F[p] - material.F[p]).trace();
      } else {
        double J = 1.0 / push_[p].determinant();
        if (total_lagrangian_) J /= compatible_F(p).determinant();
        if (!(J > 0.0)) return Status::not_admissible;
        volumetric = std::log(J);
      }
      double pressure = 0.0;
      for (std::size_t k = 0; k < n; ++k) pressure += shape(p)[k] * nodal_pressure_[list[n + k]];
      excess_[p] = (1.0 - own_share(p)) * (volumetric - pressure / bulk_[p]);
      if (small) {
        material.trial_F[p].diagonal().head(m).array() -= excess_[p] / m;
      } else {
        const double stretch = std::exp(-excess_[p] / m);
        trial_stretch_[p] = stretch_[p] * stretch;
        material.trial_F[p].topRows(m) *= total_lagrangian_ ? trial_stretch_[p] : stretch;
      }
    }
  }
  return Status::ok;
}

/// What differences of a cell's nodal pressures cost: those that the points see, and a little for those that they do not
/// (a single point sees none).   [(51)]
template <int n>
Eigen::Matrix<double, n, n> MpmDiscretisation::pressure_stabilisation(int a) const {
  constexpr double unseen = 1e-3;
  using Column = Eigen::Matrix<double, n, 1>;
  Column mean = Column::Zero();
  double volume = 0.0, compliance = 0.0;
  for (int p : points_in(a)) {
    mean += material.volume[p] * Eigen::Map<const Column>(shape(p));
    volume += material.volume[p];
    compliance += material.volume[p] / shear_[p];
  }
  mean /= volume;
  const Eigen::Matrix<double, n, n> at_nodes =
      Eigen::Matrix<double, n, n>::Identity() - Column::Ones() * mean.transpose();
  Eigen::Matrix<double, n, n> S = unseen * compliance / n * (at_nodes.transpose() * at_nodes);
  for (int p : points_in(a)) {
    const Column differs = Eigen::Map<const Column>(shape(p)) - mean;
    S.noalias() += material.volume[p] / shear_[p] * differs * differs.transpose();
  }
  return S;
}

/// The volume of the points asks for the pressure, whose differences within a cell cost something.   [(50), (51)]
template <int n>
void MpmDiscretisation::volume_residual(int a, NodalVector& f) const {
  using Column = Eigen::Matrix<double, n, 1>;
  const std::span<const int> list = blocks[pressure_block_[a]];
  Column r, pressure;
  for (int k = 0; k < n; ++k) pressure[k] = nodal_pressure_[list[n + k]];
  r = -pressure_stabilisation<n>(a) * pressure;
  for (int p : points_in(a)) r += material.volume[p] * excess_[p] * Eigen::Map<const Column>(shape(p));
  for (int k = 0; k < n; ++k) f[list[n + k]].x() += pressure_unit_ * r[k];
}

void MpmDiscretisation::add_volume_residuals(NodalVector& f) const {
  for (const int a : filled_cells()) {
    const std::size_t n = blocks[a].size();
    n == 3 ? volume_residual<3>(a, f) : n == 4 ? volume_residual<4>(a, f) : volume_residual<8>(a, f);
  }
}

/// Matrix of the displacements and pressures of a cell.   [formulation (52), (53)]
template <int dimension, bool hoop, int n>
void MpmDiscretisation::mixed_tangent(int a, const LawSettings& settings, BlockAssembler& matrix) const {
  constexpr int components = dimension * dimension + (hoop ? 1 : 0), width = dimension * n;
  constexpr int m = dimension == 2 && !hoop ? 2 : 3;
  using Row = Eigen::Matrix<double, 1, width>;
  using Pressures = Eigen::Matrix<double, 1, n>;
  Eigen::Matrix<double, width, width> uu = Eigen::Matrix<double, width, width>::Zero();
  Eigen::Matrix<double, width, n> up = Eigen::Matrix<double, width, n>::Zero();
  Eigen::Matrix<double, n, width> pu = Eigen::Matrix<double, n, width>::Zero();
  Eigen::Matrix<double, n, n> pp = -pressure_stabilisation<n>(a);
  Modulus<components> modulus;
  Eigen::Matrix<double, components, width, Eigen::RowMajor> B;
  for (int p : points_in(a)) {
    const double V = material.volume[p];
    const Pressures N = Eigen::Map<const Pressures>(shape(p));
    const Pressures theta = (1.0 - own_share(p)) * N / bulk_[p];
    Row c;
    unit_gradients<dimension, hoop, n>(p, B, c);
    c *= 1.0 - own_share(p);
    material.modulus<components>(p, settings, modulus);
    Eigen::Matrix<double, components, 1> spread = modulus * dilatation<components>();
    if (settings.kinematics == Kinematics::finite) spread += by_components<components>(material.trial[p].stress);
    const Eigen::Matrix<double, width, 1> by_dilatation = V / m * (B.transpose() * spread);
    uu.noalias() += B.transpose() * (V * modulus * B);
    uu.noalias() -= by_dilatation * c;
    up.noalias() += by_dilatation * theta;
    pu.noalias() += V * N.transpose() * c;
    pp.noalias() -= V * N.transpose() * theta;
  }
  constexpr int whole = 2 * width;
  Eigen::Matrix<double, whole, whole, Eigen::RowMajor> K = Eigen::Matrix<double, whole, whole, Eigen::RowMajor>::Zero();
  K.template topLeftCorner<width, width>() = uu;
  for (int k = 0; k < n; ++k) {
    const int at = width + dimension * k;
    K.col(at).template head<width>() = pressure_unit_ * up.col(k);
    K.row(at).template head<width>() = pressure_unit_ * pu.row(k);
    for (int l = 0; l < n; ++l) K(at, width + dimension * l) = pressure_unit_ * pressure_unit_ * pp(k, l);
  }
  matrix.add(pressure_block_[a], K.data());
}

template void MpmDiscretisation::mixed_tangent<2, false, 3>(int, const LawSettings&, BlockAssembler&) const;
template void MpmDiscretisation::mixed_tangent<2, false, 4>(int, const LawSettings&, BlockAssembler&) const;
template void MpmDiscretisation::mixed_tangent<2, true, 3>(int, const LawSettings&, BlockAssembler&) const;
template void MpmDiscretisation::mixed_tangent<2, true, 4>(int, const LawSettings&, BlockAssembler&) const;
template void MpmDiscretisation::mixed_tangent<3, false, 4>(int, const LawSettings&, BlockAssembler&) const;
template void MpmDiscretisation::mixed_tangent<3, false, 8>(int, const LawSettings&, BlockAssembler&) const;

}  // namespace berm
