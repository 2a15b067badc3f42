#pragma once
/// A linear system that is solved iteratively, or directly if that fails. For la/ only: sees PETSc.

#include <petscksp.h>

#include <optional>
#include <string>

#include "la/direct.hpp"
#include "la/newton.hpp"

namespace berm {

class LinearSolver {
public:
  LinearSolver(const Solver& options, const Comm& comm) : options_(options), comm_(comm) {}
  ~LinearSolver() { destroy(); }
  LinearSolver(const LinearSolver&) = delete;
  LinearSolver& operator=(const LinearSolver&) = delete;

  /// Takes the matrix for the coming systems; its values may change, its pattern may not.
  void set_matrix(Mat matrix, const SystemLayout& layout, bool symmetric);
  /// True if x solves matrix * x = b.
  bool solve(Vec b, Vec x);
  void destroy();

  const std::string& choice() const { return choice_; }
  const LinearCount& count() const { return count_; }
  double seconds() const { return seconds_; }

private:
  void choose(const SystemLayout& layout);
  void set_rigid_modes(const SystemLayout& layout);
  void make_iterative();
  void make_direct(std::optional<DirectSolver>& solver, const char* prefix);
  bool iterate(Vec b, Vec x, int* iterations);

  const Solver& options_;
  Comm comm_;
  Mat matrix_ = nullptr;
  KSP ksp_ = nullptr;  ///< iterative
  std::optional<DirectSolver> direct_, fallback_;
  int work_space_ = 0;  ///< of MUMPS, beyond its guess [%]
  bool symmetric_ = false, iterative_ = false;
  int stagnated_ = 0;         ///< in a row
  int fresh_iterations_ = 0;  ///< of the system for which multigrid was made
  int excess_ = 0;            ///< iterations above that number since
  std::string choice_;
  LinearCount count_;
  double seconds_ = 0.0;
};

}  // namespace berm
