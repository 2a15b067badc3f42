#pragma once
/// Constitutive state at integration points (material points or Gauss points): what was committed at t_n, and the
/// trial state of the step. Nothing is committed before Newton has converged.

#include <cstdint>
#include <span>
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
  Space space = Space::plane_strain;
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
  Status respond(const LawSettings& settings);
  /// Tangent of the trial state of a point, computed anew: a million points of a solid would need 650 MB for theirs.
  template <int components>
  void modulus(int p, const LawSettings& settings, Modulus<components>& tangent) const;
  /// Trial state becomes the state.
  void commit();
  /// Of this process's points: largest, and sums over the volume.
  double max_damage() const;
  double max_plastic_strain() const;
  bool has_plasticity() const;             ///< some body's law keeps its elastic strain; the same on all processes
  double stored_energy() const;            ///< of the committed state [J]
  double dissipated_energy() const;        ///< since the start [J]
  double max_extrapolation_error() const;  ///< of the trial state

  /// Crack-band length times the largest principal inelastic strain, l <eps - C^-1 sigma>_1 [m]; 0 for laws that keep
  /// their elastic strain.
  std::vector<double> crack_opening() const;
  /// Energy dissipated per crack area over the fracture energy of the law; 0 for laws without one. Exceeds 1 where the
  /// law dissipates more than Gf (compression).
  std::vector<double> released_energy_fraction() const;

  /// Everything that a point of a slice keeps from step to step as a row of doubles: how points travel between
  /// processes and into checkpoints.
  int row_width(int slice) const;
  void write_row(int p, double* row) const;
  /// Replaces the points of all slices by the given rows, in their order.
  void replace(const std::vector<std::vector<double>>& rows_of_slice);

  std::vector<Slice> slices;
  // per point, committed
  std::vector<double> volume, length;
  std::vector<Mat3> F;            ///< deformation gradient (small strain: I + grad u); zz: hoop, 1 in the plane
  std::vector<double> strain_zz;  ///< plane stress: out of plane
  std::vector<Voigt> stress;      ///< Cauchy
  std::vector<Voigt> strain;      ///< Hencky or small; engineering shear
  std::vector<double> damage, plastic_strain;  ///< damage; accumulated plastic strain
  std::vector<double> stored, dissipated;      ///< energies per reference volume [J/m3]
  // per point, trial
  std::vector<Mat3> trial_F;
  std::vector<PointResponse> trial;

private:
  int slice_of(int p) const;
  Voigt total_strain(int p) const;
  void resize_points(std::size_t n);

  Kinematics kinematics_ = Kinematics::finite;
  bool plane_stress_ = false;
  std::vector<double> state_, trial_state_, trial_strain_zz_;
};

}  // namespace berm
