/// Mean dilatation over the points of a cell or patch: against volumetric locking of linear cells
/// [formulation, section 14, (40) to (46)].

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "transfer/mpm.hpp"

namespace berm {

/// Points of one body in one patch: without domains those of a quad or hexahedron; boxes whose lowest corners lie in the
/// same cell; parallelograms (parallelepipeds) whose centres do. order_ keeps the bodies apart already.
void MpmDiscretisation::group_points() {
  groups_.clear();
  first_group_.assign(1, 0);
  for (int a = 0; a < n_patches(); ++a) {
    int slice = -1;
    const bool simplex = static_cast<int>(blocks[a].size()) == dimension() + 1;
    const int end = simplex ? first_[a] : first_[a + 1];
    for (int at = first_[a]; at < end; ++at) {
      const int p = order_[at];
      if (slice < 0 || p >= material.slices[slice].end) {
        while (slice < 0 || p >= material.slices[slice].end) ++slice;
        groups_.push_back({a, at, at});
      }
      ++groups_.back().end;
    }
    first_group_.push_back(static_cast<int>(groups_.size()));
  }
  share_.resize(x_.size());
  trial_stretch_.assign(x_.size(), 1.0);
  mean_divergence_.resize(groups_.size() * dimension() * most_nodes_);
}

/// The deformation gradient at t_n that belongs to the displacements (total Lagrangian).   [formulation (43)]
Mat3 MpmDiscretisation::compatible_F(int p) const {
  Mat3 F = material.F[p];
  F.topRows(volumetric_directions()) /= stretch_[p];
  return F;
}

/// Divergence at a point of unit displacements of the n nodes on the trial configuration, c of (44).
void MpmDiscretisation::divergence(int p, int n, double* c) const {
  const int d = dimension();
  const double* s = shape(p);
  const Mat3& push = push_[p];
  const double r = seen(p).x();
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < d; ++i) {
      double sum = 0.0;
      for (int j = 0; j < d; ++j) sum += push(i, j) * s[n + d * k + j];
      if (i == 0 && space_ == Space::axisymmetric) sum += push(2, 2) * hoop_gradient(s, n, r, k);
      c[d * k + i] = sum;
    }
}

/// The trial deformation gradients get the mean dilatation of their group.   [formulation (40) to (43)]
Status MpmDiscretisation::average_dilatation() {
  const int m = volumetric_directions();
  const bool small = kinematics_ == Kinematics::small;
  std::vector<double> own, c(std::size_t(dimension()) * most_nodes_);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const std::span<const int> points = points_in(groups_[g]);
    own.clear();
    double before = 0.0, after = 0.0;
    for (int p : points) {
      double base = material.volume[p];
      if (small) {
        own.push_back((material.trial_F[p] - material.F[p]).trace());
      } else {
        own.push_back(1.0 / push_[p].determinant());
        if (!(own.back() > 0.0)) return Status::not_admissible;
        if (!total_lagrangian_) base *= material.F[p].determinant();
      }
      share_[p] = small ? base : base * own.back();
      before += base;
      after += base * own.back();
    }
    const double mean = after / before, total = small ? before : after;
    const int n = static_cast<int>(blocks[groups_[g].patch].size()), width = dimension() * n;
    double* b = mean_divergence_.data() + g * dimension() * most_nodes_;
    std::fill_n(b, width, 0.0);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const int p = points[k];
      share_[p] /= total;
      divergence(p, n, c.data());
      for (int i = 0; i < width; ++i) b[i] += share_[p] * c[i];
      if (small) {
        material.trial_F[p].diagonal().head(m).array() += (mean - own[k]) / m;
      } else {
        trial_stretch_[p] = std::pow(mean / own[k], 1.0 / m);
        material.trial_F[p].topRows(m) *= trial_stretch_[p];
      }
    }
  }
  return Status::ok;
}

/// Work of the mean stress of a point on a volumetric strain: V0 times the trace over the directions that have one.
double MpmDiscretisation::mean_stress_volume(int p) const {
  const Voigt& tau = material.trial[p].stress;
  const int m = volumetric_directions();
  return material.volume[p] * (tau[XX] + tau[YY] + (m == 3 ? tau[ZZ] : 0.0)) / m;
}

/// The mean stress of a group works on its mean dilatation.   [formulation (45), second part]
void MpmDiscretisation::add_mean_pressure(NodalVector& f) const {
  const int d = dimension();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    double sum = 0.0;
    for (int p : points_in(groups_[g])) sum += mean_stress_volume(p);
    const std::span<const int> list = blocks[groups_[g].patch];
    const double* b = mean_divergence(g);
    for (std::size_t k = 0; k < list.size(); ++k)
      for (int i = 0; i < d; ++i) f[list[k]][i] += sum * b[d * k + i];
  }
}

/// Matrix of a patch.   [formulation (46)]
template <int dimension, bool hoop, int n>
void MpmDiscretisation::f_bar_tangent(int patch, const LawSettings& settings, double* out) const {
  constexpr int components = dimension * dimension + (hoop ? 1 : 0), width = dimension * n;
  constexpr int m = dimension == 2 && !hoop ? 2 : 3;
  using Row = Eigen::Matrix<double, 1, width>;
  using Square = Eigen::Matrix<double, width, width, Eigen::RowMajor>;
  Eigen::Map<Square> K(out);
  K.setZero();
  const bool finite = settings.kinematics == Kinematics::finite;
  Modulus<components> a;
  Eigen::Matrix<double, components, width, Eigen::RowMajor> B;
  for (int g = first_group_[patch]; g < first_group_[patch + 1]; ++g) {
    const Eigen::Map<const Row> b(mean_divergence(g));
    double pressure = 0.0;
    for (int p : points_in(groups_[g])) pressure += mean_stress_volume(p);
    for (int p : points_in(groups_[g])) {
      Row c;
      unit_gradients<dimension, hoop, n>(p, B, c);
      const Row theta = b - c;
      if (finite) {
        const Mat3 tau = material.volume[p] * response_detail::tensor(material.trial[p].stress);
        Row t = Row::Zero();  // tau : gradient
        for (int i = 0; i < dimension; ++i)
          for (int j = 0; j < dimension; ++j) t += tau(i, j) * B.row(dimension * i + j);
        if constexpr (hoop) t += tau(2, 2) * B.row(components - 1);
        const double mean = mean_stress_volume(p), of_mean = pressure * share_[p];
        const Row half = (2.0 * t + mean * theta) / (2.0 * m);  // t theta + theta t + mean theta theta, over m
        K.noalias() += half.transpose() * theta;
        K.noalias() += theta.transpose() * half;
        K.noalias() += of_mean * c.transpose() * c;
        // sum_ij l_ij l_ji: what turns the gradients of the trial configuration.
        for (int i = 0; i < dimension; ++i)
          for (int j = 0; j < dimension; ++j)
            K.noalias() += (mean - of_mean) * B.row(dimension * i + j).transpose() * B.row(dimension * j + i);
        if constexpr (hoop) K.noalias() += (mean - of_mean) * B.row(components - 1).transpose() * B.row(components - 1);
      }
      for (int i = 0; i < dimension; ++i) B.row(dimension * i + i) += theta / m;
      if constexpr (hoop) B.row(components - 1) += theta / m;
      material.modulus<components>(p, settings, a);
      a *= material.volume[p];
      K.noalias() += B.transpose() * (a * B);
    }
    if (finite) K.noalias() -= pressure * b.transpose() * b;
  }
}

template void MpmDiscretisation::f_bar_tangent<2, false, 4>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<2, false, 9>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<2, false, 16>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<2, true, 4>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<2, true, 9>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<2, true, 16>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<3, false, 8>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<3, false, 27>(int, const LawSettings&, double*) const;
template void MpmDiscretisation::f_bar_tangent<3, false, 64>(int, const LawSettings&, double*) const;

}  // namespace berm
