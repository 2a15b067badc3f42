#include "method/material_state.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace berm {
namespace {

/// Calls work(law, first point, last point + 1, slice) for every slice with the law's own type.
template <class Work>
void for_each_law(const std::vector<Slice>& slices, Work work) {
  for (const Slice& slice : slices) std::visit([&](const auto& law) { work(law, slice); }, slice.law);
}

/// Doubles of a row besides the law's state: volume, length, F, strain zz, stress, strain, damage, plastic strain, two
/// energies.
constexpr int fixed_width = 2 + 9 + 1 + 6 + 6 + 4;

template <int components>
Status respond_slice(const auto& law, const Slice& slice, const LawSettings& settings, MaterialState& m,
                     const double* old_state, double* new_state, const std::vector<double>& old_zz,
                     std::vector<double>& new_zz) {
  LawInput in;
  in.dt = settings.dt;
  in.integration = settings.integration;
  Status worst = Status::ok;
  for (int p = slice.begin; p < slice.end; ++p, old_state += slice.n_state, new_state += slice.n_state) {
    in.length = m.length[p];
    new_zz[p] = old_zz[p];
    const Status status = point_response<components>(law, settings.space, settings.kinematics, m.F[p], m.trial_F[p], in,
                                                     old_state, new_state, new_zz[p], m.trial[p]);
    if (status != Status::ok && worst == Status::ok) worst = status;
  }
  return worst;
}

/// <eps - C^-1 sigma>_1
double largest_inelastic_strain(const IsotropicElastic& law, const Voigt& stress, const Voigt& strain) {
  const double E = law.youngs_modulus, nu = law.poisson_ratio;
  const Mat3 s = response_detail::tensor(stress);
  const Mat3 inelastic =
      response_detail::tensor(tensor_components(strain)) - (1.0 + nu) / E * s + nu / E * s.trace() * Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(inelastic, Eigen::EigenvaluesOnly);
  return std::max(0.0, spectrum.eigenvalues()[2]);
}

}  // namespace

void MaterialState::resize_points(std::size_t n) {
  F.resize(n, Mat3::Identity());
  trial_F.resize(n, Mat3::Identity());
  trial.resize(n);
  strain_zz.resize(n, 0.0);
  trial_strain_zz_.resize(n, 0.0);
  stress.resize(n, Voigt::Zero());
  strain.resize(n, Voigt::Zero());
  damage.resize(n, 0.0);
  plastic_strain.resize(n, 0.0);
  stored.resize(n, 0.0);
  dissipated.resize(n, 0.0);
}

void MaterialState::add(int body, const AnyLaw& law, const std::vector<double>& new_volume,
                        const std::vector<double>& new_length) {
  Slice slice;
  slice.begin = size();
  slice.end = slice.begin + static_cast<int>(new_volume.size());
  slice.body = body;
  slice.law = law;
  slice.n_state = std::visit([](const auto& l) { return l.n_state; }, law);
  slice.state_begin = state_.size();

  volume.insert(volume.end(), new_volume.begin(), new_volume.end());
  length.insert(length.end(), new_length.begin(), new_length.end());
  resize_points(slice.end);
  state_.resize(state_.size() + new_volume.size() * slice.n_state);
  std::visit(
      [&](const auto& l) {
        for (std::size_t p = 0; p < new_volume.size(); ++p)
          l.initial_state(state_.data() + slice.state_begin + p * slice.n_state);
      },
      law);
  trial_state_ = state_;
  slices.push_back(std::move(slice));
}

Status MaterialState::respond(const LawSettings& settings) {
  kinematics_ = settings.kinematics;
  plane_stress_ = settings.space == Space::plane_stress;
  Status worst = Status::ok;
  for_each_law(slices, [&](const auto& law, const Slice& slice) {
    const double* old_state = state_.data() + slice.state_begin;
    double* new_state = trial_state_.data() + slice.state_begin;
    const auto respond_with = [&]<int components>() {
      return respond_slice<components>(law, slice, settings, *this, old_state, new_state, strain_zz, trial_strain_zz_);
    };
    const int components = components_of(settings.space);
    const Status status = components == 9   ? respond_with.template operator()<9>()
                          : components == 5 ? respond_with.template operator()<5>()
                                            : respond_with.template operator()<4>();
    if (worst == Status::ok) worst = status;
  });
  return worst;
}

int MaterialState::slice_of(int p) const {
  int s = 0;
  while (p >= slices[s].end) ++s;
  return s;
}

template <int components>
void MaterialState::modulus(int p, const LawSettings& settings, Modulus<components>& tangent) const {
  const Slice& slice = slices[slice_of(p)];
  LawInput in;
  in.dt = settings.dt;
  in.integration = settings.integration;
  in.length = length[p];
  constexpr int most_state = 32;
  std::array<double, most_state> unused_state;
  PointResponse unused;
  double zz = strain_zz[p];
  std::visit(
      [&](const auto& law) {
        static_assert(std::decay_t<decltype(law)>::n_state <= most_state);
        const double* old_state = state_.data() + slice.state_begin + std::size_t(p - slice.begin) * slice.n_state;
        point_response<components>(law, settings.space, settings.kinematics, F[p], trial_F[p], in, old_state,
                                   unused_state.data(), zz, unused, &tangent);
      },
      slice.law);
}

template void MaterialState::modulus<4>(int, const LawSettings&, Modulus<4>&) const;
template void MaterialState::modulus<5>(int, const LawSettings&, Modulus<5>&) const;
template void MaterialState::modulus<9>(int, const LawSettings&, Modulus<9>&) const;

void MaterialState::commit() {
  for (int p = 0; p < size(); ++p) {
    const PointResponse& r = trial[p];
    F[p] = trial_F[p];
    // Kirchhoff to Cauchy; in small strain they are the same.
    const double J = kinematics_ == Kinematics::finite ? F[p].determinant() * std::exp(trial_strain_zz_[p]) : 1.0;
    stress[p] = r.stress / J;
    strain[p] = r.strain;
    damage[p] = r.damage;
    plastic_strain[p] = r.plastic_strain;
    stored[p] = r.stored_energy;
    dissipated[p] += r.dissipated;
  }
  strain_zz.swap(trial_strain_zz_);
  state_.swap(trial_state_);
  for_each_law(slices, [&](const auto& law, const Slice& slice) {
    if constexpr (keeps_elastic_strain<std::decay_t<decltype(law)>>)
      for (int p = slice.begin; p < slice.end; ++p) strain[p] = total_strain(p);
  });
}

Voigt MaterialState::total_strain(int p) const {
  Voigt total;
  response_detail::strain_of<9>(F[p] - Mat3::Identity(), kinematics_, total, nullptr);
  if (plane_stress_) total[ZZ] = strain_zz[p];
  return total;
}

int MaterialState::row_width(int slice) const { return fixed_width + slices[slice].n_state; }

void MaterialState::write_row(int p, double* row) const {
  const auto put = [&row](const double* values, int n) { row = std::copy_n(values, n, row); };
  put(&volume[p], 1);
  put(&length[p], 1);
  put(F[p].data(), 9);
  put(&strain_zz[p], 1);
  put(stress[p].data(), 6);
  put(strain[p].data(), 6);
  put(&damage[p], 1);
  put(&plastic_strain[p], 1);
  put(&stored[p], 1);
  put(&dissipated[p], 1);
  const Slice& slice = slices[slice_of(p)];
  put(state_.data() + slice.state_begin + std::size_t(p - slice.begin) * slice.n_state, slice.n_state);
}

void MaterialState::replace(const std::vector<std::vector<double>>& rows_of_slice) {
  std::size_t points = 0, states = 0;
  for (std::size_t s = 0; s < slices.size(); ++s) {
    const std::size_t n = rows_of_slice[s].size() / row_width(static_cast<int>(s));
    slices[s].begin = static_cast<int>(points);
    slices[s].end = static_cast<int>(points += n);
    slices[s].state_begin = states;
    states += n * slices[s].n_state;
  }
  volume.resize(points);
  length.resize(points);
  resize_points(points);
  state_.resize(states);
  for (std::size_t s = 0; s < slices.size(); ++s) {
    const double* row = rows_of_slice[s].data();
    const auto get = [&row](double* values, int n) {
      std::copy_n(row, n, values);
      row += n;
    };
    for (int p = slices[s].begin; p < slices[s].end; ++p) {
      get(&volume[p], 1);
      get(&length[p], 1);
      get(F[p].data(), 9);
      get(&strain_zz[p], 1);
      get(stress[p].data(), 6);
      get(strain[p].data(), 6);
      get(&damage[p], 1);
      get(&plastic_strain[p], 1);
      get(&stored[p], 1);
      get(&dissipated[p], 1);
      get(state_.data() + slices[s].state_begin + std::size_t(p - slices[s].begin) * slices[s].n_state,
          slices[s].n_state);
    }
  }
  trial_state_ = state_;
  trial_strain_zz_ = strain_zz;
  trial_F = F;
}

double MaterialState::max_damage() const {
  return damage.empty() ? 0.0 : *std::max_element(damage.begin(), damage.end());
}

double MaterialState::max_plastic_strain() const {
  return plastic_strain.empty() ? 0.0 : *std::max_element(plastic_strain.begin(), plastic_strain.end());
}

bool MaterialState::has_plasticity() const {
  return std::any_of(slices.begin(), slices.end(), [](const Slice& slice) { return is_plastic(slice.law); });
}

double MaterialState::stored_energy() const {
  double sum = 0.0;
  for (int p = 0; p < size(); ++p) sum += stored[p] * volume[p];
  return sum;
}

double MaterialState::dissipated_energy() const {
  double sum = 0.0;
  for (int p = 0; p < size(); ++p) sum += dissipated[p] * volume[p];
  return sum;
}

std::vector<double> MaterialState::crack_opening() const {
  std::vector<double> opening(size(), 0.0);
  for_each_law(slices, [&](const auto& law, const Slice& slice) {
    using L = std::decay_t<decltype(law)>;
    if constexpr (std::is_base_of_v<IsotropicElastic, L> && !keeps_elastic_strain<L>)
      for (int p = slice.begin; p < slice.end; ++p)
        opening[p] = length[p] * largest_inelastic_strain(law, stress[p], strain[p]);
  });
  return opening;
}

std::vector<double> MaterialState::released_energy_fraction() const {
  std::vector<double> fraction(size(), 0.0);
  for_each_law(slices, [&](const auto& law, const Slice& slice) {
    if constexpr (requires { law.fracture_energy; })
      for (int p = slice.begin; p < slice.end; ++p) fraction[p] = dissipated[p] * length[p] / law.fracture_energy;
  });
  return fraction;
}

double MaterialState::max_extrapolation_error() const {
  double worst = 0.0;
  for (const PointResponse& r : trial) worst = std::max(worst, r.extrapolation_error);
  return worst;
}

}  // namespace berm
