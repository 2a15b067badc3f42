#pragma once
/// A linear system that is solved by MUMPS. For la/ only: sees PETSc.

#include <petscksp.h>

#include <string>

#include "comm/comm.hpp"

namespace berm {

/// Factorises on the first process of the group, to which the others send their rows, or on all of them.
///
/// MUMPS on several processes adds contributions in the order in which they arrive, so that no run is the other's equal; what
/// one process factorises is the same to the bit. Below some ten thousand unknowns that is quicker too (bench/README.md).
class DirectSolver {
public:
  enum class Where { first_process, all_processes };

  /// The matrix must outlive the solver; its values may change, its pattern may not. symmetric: also positive definite.
  /// `prefix` of PETSc's options for it. `space`: work space beyond MUMPS's guess [%], which is raised where it did not do, for
  /// the solvers to come too. Collective, as all of this.
  DirectSolver(Mat matrix, bool symmetric, const std::string& prefix, const Comm& comm, Where where, int& space);
  ~DirectSolver();
  DirectSolver(const DirectSolver&) = delete;
  DirectSolver& operator=(const DirectSolver&) = delete;

  /// True if x solves matrix * x = b with the values that the matrix now has.
  bool solve(Vec b, Vec x);
  /// Iterations of the method that PETSc's options chose instead, if they did; 1 otherwise.
  int iterations() const { return iterations_; }

private:
  bool gathers() const { return comm_.size() > 1 && where_ == Where::first_process; }
  void make_solver();
  void gather_matrix();
  bool solve_gathered(Vec b, Vec x);
  bool solve_here(Mat matrix, Vec b, Vec x);
  bool ran_out_of_space() const;
  void give_space(Mat matrix);

  Mat matrix_;
  bool symmetric_;
  std::string prefix_;
  Comm comm_;
  Where where_;
  int& space_;
  KSP ksp_ = nullptr;
  Mat* gathered_ = nullptr;  ///< list of one matrix of all rows; of none on the other processes
  VecScatter to_first_ = nullptr;
  Vec b_ = nullptr, x_ = nullptr;  ///< of all rows, on the first process
  bool started_ = false;
  int iterations_ = 0;
};

}  // namespace berm
