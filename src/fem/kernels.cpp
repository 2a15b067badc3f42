/// The sums over the Gauss points.

#include <Eigen/LU>

#include "fem/element.hpp"
#include "fem/fem.hpp"

namespace berm {
namespace {

/// What a kernel knows of an element when it is compiled. hoop: around an axis.
template <int dimension_, bool hoop_, int n_>
struct ElementType {
  static constexpr int dimension = dimension_, n = n_, width = dimension * n;
  static constexpr bool hoop = hoop_;
  static constexpr int components = dimension * dimension + (hoop ? 1 : 0);  ///< of the tangent

  using Square = Eigen::Matrix<double, dimension, dimension>;
  using Nodal = Eigen::Matrix<double, dimension, n>;  ///< a vector a node, or a gradient

  static auto derivatives(const fem::ElementShape& s) {
    return Eigen::Map<const Eigen::Matrix<double, 3, n>>(s.dN[0].data()).template topRows<dimension>();
  }
  static auto values(const fem::ElementShape& s) { return Eigen::Map<const Eigen::Matrix<double, 1, n>>(s.N.data()); }
};

template <int dimension>
auto in_model(const Mat3& m) {
  return m.topLeftCorner<dimension, dimension>();
}

}  // namespace

template <class Work>
void FemDiscretisation::for_elements(Work work) const {
  const auto plane = [&]<int n>(int k) {
    if (space_ == Space::axisymmetric)
      work(ElementType<2, true, n>{}, k);
    else
      work(ElementType<2, false, n>{}, k);
  };
  for (int k = 0; k < static_cast<int>(elements_.size()); ++k) switch (mesh_.kinds[elements_[k]]) {
      case CellKind::tri3:
        plane.template operator()<3>(k);
        break;
      case CellKind::quad4:
        plane.template operator()<4>(k);
        break;
      case CellKind::tri6:
        plane.template operator()<6>(k);
        break;
      case CellKind::quad8:
        plane.template operator()<8>(k);
        break;
      case CellKind::tet4:
        work(ElementType<3, false, 4>{}, k);
        break;
      case CellKind::hex8:
        work(ElementType<3, false, 8>{}, k);
        break;
      case CellKind::tet10:
        work(ElementType<3, false, 10>{}, k);
        break;
      case CellKind::hex20:
        work(ElementType<3, false, 20>{}, k);
        break;
    }
}

/// F = I + sum u_I (x) grad_X N_I; around an axis F_zz = 1 + u_r / R.   [formulation (11), (26)]
Status FemDiscretisation::evaluate(const NodalVector& du, const LawSettings& settings) {
  kinematics_ = settings.kinematics;
  for_elements([&](auto type, int k) {
    using Type = decltype(type);
    constexpr int d = Type::dimension;
    const std::span<const int> list = blocks[k];
    typename Type::Nodal u;
    for (int I = 0; I < Type::n; ++I) u.col(I) = (u_[list[I]] + du[list[I]]).template head<d>();
    int p = first_[k];
    for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[k]])) {
      const typename Type::Square by_xi = u * Type::derivatives(q.shape).transpose();
      Mat3& F = material.trial_F[p];
      F.setIdentity();
      F.template topLeftCorner<d, d>() += by_xi * in_model<d>(inverse_[p]);
      if constexpr (Type::hoop) F(2, 2) += u.row(0).dot(Type::values(q.shape)) / radius_[p];
      ++p;
    }
  });
  return material.respond(settings);
}

/// From derivatives by xi to gradients where the stress acts: F^-T (dxi/dX)^T, in small strain without F.
///   [formulation (11)]
template <int dimension>
Eigen::Matrix<double, dimension, dimension> FemDiscretisation::push(int p) const {
  using Square = Eigen::Matrix<double, dimension, dimension>;
  const Square inverse = in_model<dimension>(inverse_[p]);
  if (kinematics_ == Kinematics::small) return inverse.transpose();
  const Square F = in_model<dimension>(material.trial_F[p]);
  return (inverse * F.inverse()).transpose();
}

/// Hoop strain of a unit radial displacement: this times N_I.
double FemDiscretisation::hoop_push(int p) const {
  const double stretch = kinematics_ == Kinematics::small ? 1.0 : material.trial_F[p](2, 2);
  return 1.0 / (radius_[p] * stretch);
}

/// f_I = sum tau grad_x N_I V0   [formulation (8)]
void FemDiscretisation::add_internal_force(NodalVector& f) const {
  for_elements([&](auto type, int k) {
    using Type = decltype(type);
    constexpr int d = Type::dimension;
    typename Type::Nodal sum = Type::Nodal::Zero();
    int p = first_[k];
    for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[k]])) {
      const Mat3 tau = response_detail::tensor(material.trial[p].stress) * material.volume[p];
      const typename Type::Square by_xi = in_model<d>(tau) * push<d>(p);
      sum.noalias() += by_xi * Type::derivatives(q.shape);
      if constexpr (Type::hoop) sum.row(0) += tau(2, 2) * hoop_push(p) * Type::values(q.shape);
      ++p;
    }
    const std::span<const int> list = blocks[k];
    for (int I = 0; I < Type::n; ++I) f[list[I]].template head<d>() += sum.col(I);
  });
}

/// K_(Ii)(Jk) = sum grad_j N_I a_ijkl grad_l N_J V0   [formulation (10)]
template <class Type>
void FemDiscretisation::element_tangent(int element, const LawSettings& settings, double* out) const {
  constexpr int d = Type::dimension, n = Type::n, components = Type::components;
  using Wide = Eigen::Matrix<double, 1, Type::width>;
  Eigen::Map<Eigen::Matrix<double, Type::width, Type::width, Eigen::RowMajor>> K(out);
  K.setZero();
  Modulus<components> a;
  Eigen::Matrix<double, components, Type::width, Eigen::RowMajor> da;  // increments of stress by those of the nodes
  int p = first_[element];
  for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[element]])) {
    material.modulus<components>(p, settings, a);
    a *= material.volume[p];
    const typename Type::Nodal g = push<d>(p) * Type::derivatives(q.shape);
    const double hoop = Type::hoop ? hoop_push(p) : 0.0;
    for (int J = 0; J < n; ++J) {
      for (int i = 0; i < d; ++i) da.col(d * J + i).noalias() = a.template middleCols<d>(d * i) * g.col(J);
      if constexpr (Type::hoop) da.col(d * J) += hoop * q.shape.N[J] * a.col(components - 1);
    }
    for (int I = 0; I < n; ++I)
      for (int i = 0; i < d; ++i) {
        Wide row = g(0, I) * da.row(d * i);
        for (int j = 1; j < d; ++j) row += g(j, I) * da.row(d * i + j);
        if (Type::hoop && i == 0) row += hoop * q.shape.N[I] * da.row(components - 1);
        K.row(d * I + i) += row;
      }
    ++p;
  }
}

void FemDiscretisation::add_tangent(const LawSettings& settings, BlockAssembler& matrix) const {
  constexpr int most = 3 * fem::most_nodes;
  alignas(64) double K[most * most];
  for_elements([&](auto type, int k) {
    element_tangent<decltype(type)>(k, settings, K);
    matrix.add(k, K);
  });
}

void FemDiscretisation::add_body_force(const std::function<Vec3(int body, const Vec3& X)>& acceleration,
                                       NodalVector& f) const {
  const std::vector<Vec3> X = point_origins();
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::span<const int> list = blocks[static_cast<int>(k)];
    int p = first_[k];
    for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[k]])) {
      const Vec3 weight = density_[k] * material.volume[p] * acceleration(body_of_element_[elements_[k]], X[p]);
      ++p;
      for (std::size_t I = 0; I < list.size(); ++I) f[list[I]] += q.shape.N[I] * weight;
    }
  }
}

void FemDiscretisation::commit(const NodalVector& du, const std::vector<Anchor*>& anchors) {
  material.commit();
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] += du[i];
  const auto carry = [&](Anchor& a) {
    if (kinematics_ == Kinematics::finite) a.F = a.trial_F(du);
    a.u = a.stencil->interpolate(u_);
    if (kinematics_ == Kinematics::finite) a.x = a.X + a.u;
  };
  for (Anchor* a : anchors) carry(*a);
  for (AnchorPair* pair : pairs_) carry(pair->a), carry(pair->b);
}

// ---- output

std::vector<Vec3> FemDiscretisation::interpolate(const std::vector<Vec3>& nodal) const {
  std::vector<Vec3> out;
  out.reserve(id_.size());
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::span<const int> list = blocks[static_cast<int>(k)];
    for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[k]])) {
      Vec3 sum = Vec3::Zero();
      for (std::size_t I = 0; I < list.size(); ++I) sum += q.shape.N[I] * nodal[list[I]];
      out.push_back(sum);
    }
  }
  return out;
}

std::vector<Vec3> FemDiscretisation::point_origins() const { return interpolate(nodes); }

std::vector<Vec3> FemDiscretisation::point_displacements() const {
  NodalVector u = u_;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] -= u_before_[i];
  return interpolate(u);
}

std::vector<Vec3> FemDiscretisation::point_positions() const {
  std::vector<Vec3> x = point_origins();
  const std::vector<Vec3> u = interpolate(u_);
  for (std::size_t p = 0; p < x.size(); ++p) x[p] += u[p];
  return x;
}

}  // namespace berm
