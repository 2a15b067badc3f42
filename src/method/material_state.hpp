#pragma once
/// Constitutive state at integration points (material points or Gauss points): what was committed at t_n, and the
/// trial state of the step. Nothing is committed before Newton has converged.

#include <vector>

#include "law/all.hpp"
#include "law/point_response.hpp"

namespace berm {

/// Points begin..end-1 obey one law.
struct Slice {
  int begin = 0, end = 0;
  int body = 0;  ///< index into the case's bodies
  AnyLaw law;
  int n_state = 0;
  std::size_t state_begin = 0;  ///< first double of the slice in the state arrays
};

struct LawSettings {
  Plane plane = Plane::strain;
  Kinematics kinematics = Kinematics::finite;
  Integration integration = Integration::implicit;
  double dt = 1.0;
};

class MaterialState {
public:
  /// Appends points of one body. volume: reference volume incl. thickness [m3]; length: crack band [m].
  void add(int body, const AnyLaw& law, const std::vector<double>& volume, const std::vector<double>& length);
  int size() const { return static_cast<int>(volume.size()); }

  /// Trial response to trial_F. Returns the first status that is not ok.
  Status respond(const LawSettings& settings, bool tangent);
  /// Trial state becomes the state.
  void commit();
  /// Largest and volume-weighted sums over the points.
  double max_damage() const;
  double stored_energy() const;            ///< of the committed state [J]
  double dissipated_energy() const;        ///< since the start [J]
  double max_extrapolation_error() const;  ///< of the trial state

  /// Crack-band length times the largest principal inelastic strain, l <eps - C^-1 sigma>_1 [m].
  std::vector<double> crack_opening() const;
  /// Energy dissipated per crack area over the fracture energy of the law; 0 for laws without one. Exceeds 1 where the
  /// law dissipates more than Gf (compression).
  std::vector<double> released_energy_fraction() const;

  std::vector<Slice> slices;
  // per point, committed
  std::vector<double> volume, length;
  std::vector<Mat2> F;                             ///< deformation gradient (small strain: I + grad u)
  std::vector<double> strain_zz;                   ///< out of plane
  std::vector<Voigt> stress;                       ///< Cauchy
  std::vector<Voigt> strain;                       ///< Hencky or small; engineering shear
  std::vector<double> damage, stored, dissipated;  ///< energies per reference volume [J/m3]
  // per point, trial
  std::vector<Mat2> trial_F;
  std::vector<PlaneResponse> trial;

private:
  Kinematics kinematics_ = Kinematics::finite;
  std::vector<double> state_, trial_state_, trial_strain_zz_;
};

}  // namespace berm
