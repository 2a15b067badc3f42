#include "method/material_state.hpp"

#include <algorithm>
#include <cmath>

namespace berm {

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
  const std::size_t n = slice.end;
  F.resize(n, Mat2::Identity());
  trial_F.resize(n, Mat2::Identity());
  trial.resize(n);
  strain_zz.resize(n, 0.0);
  trial_strain_zz_.resize(n, 0.0);
  stress.resize(n, Voigt::Zero());
  strain.resize(n, Voigt::Zero());
  damage.resize(n, 0.0);
  stored.resize(n, 0.0);
  dissipated.resize(n, 0.0);
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

Status MaterialState::respond(const LawSettings& settings, bool tangent) {
  kinematics_ = settings.kinematics;
  LawInput in;
  in.dt = settings.dt;
  in.integration = settings.integration;
  in.want_tangent = tangent;
  Status worst = Status::ok;
  for (const Slice& slice : slices)
    std::visit(
        [&](const auto& law) {
          const double* old_state = state_.data() + slice.state_begin;
          double* new_state = trial_state_.data() + slice.state_begin;
          for (int p = slice.begin; p < slice.end; ++p, old_state += slice.n_state, new_state += slice.n_state) {
            in.length = length[p];
            trial_strain_zz_[p] = strain_zz[p];
            const Status status = plane_response(law, settings.plane, settings.kinematics, trial_F[p], in, old_state,
                                                 new_state, trial_strain_zz_[p], trial[p]);
            if (status != Status::ok && worst == Status::ok) worst = status;
          }
        },
        slice.law);
  return worst;
}

void MaterialState::commit() {
  for (int p = 0; p < size(); ++p) {
    const PlaneResponse& r = trial[p];
    F[p] = trial_F[p];
    // Kirchhoff to Cauchy; in small strain they are the same.
    const double J = kinematics_ == Kinematics::finite ? F[p].determinant() * std::exp(trial_strain_zz_[p]) : 1.0;
    stress[p] << r.stress(0, 0) / J, r.stress(1, 1) / J, r.stress_zz / J, r.stress(0, 1) / J, 0.0, 0.0;
    strain[p] = r.strain;
    damage[p] = r.damage;
    stored[p] = r.stored_energy;
    dissipated[p] += r.dissipated;
  }
  strain_zz.swap(trial_strain_zz_);
  state_.swap(trial_state_);
}

double MaterialState::max_damage() const {
  return damage.empty() ? 0.0 : *std::max_element(damage.begin(), damage.end());
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
  for (const Slice& slice : slices)
    std::visit(
        [&](const auto& law) {
          const double E = law.youngs_modulus, nu = law.poisson_ratio;
          for (int p = slice.begin; p < slice.end; ++p) {
            const Voigt& s = stress[p];
            const double mean = nu / E * (s[XX] + s[YY] + s[ZZ]);
            const double xx = strain[p][XX] - (1.0 + nu) / E * s[XX] + mean;
            const double yy = strain[p][YY] - (1.0 + nu) / E * s[YY] + mean;
            const double zz = strain[p][ZZ] - (1.0 + nu) / E * s[ZZ] + mean;
            const double xy = 0.5 * strain[p][XY] - (1.0 + nu) / E * s[XY];
            const double in_plane = 0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), xy);
            opening[p] = length[p] * std::max({0.0, in_plane, zz});
          }
        },
        slice.law);
  return opening;
}

std::vector<double> MaterialState::released_energy_fraction() const {
  std::vector<double> fraction(size(), 0.0);
  for (const Slice& slice : slices)
    std::visit(
        [&](const auto& law) {
          if constexpr (requires { law.fracture_energy; })
            for (int p = slice.begin; p < slice.end; ++p) fraction[p] = dissipated[p] * length[p] / law.fracture_energy;
        },
        slice.law);
  return fraction;
}

double MaterialState::max_extrapolation_error() const {
  double worst = 0.0;
  for (const PlaneResponse& r : trial) worst = std::max(worst, r.extrapolation_error);
  return worst;
}

}  // namespace berm
