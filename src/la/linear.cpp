#include "la/linear.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/stopwatch.hpp"
#include "comm/mpi.hpp"
#include "la/petsc.hpp"

namespace berm {
namespace {

constexpr int most_iterations = 500;
/// After so many systems in a row that the iterative method did not solve it is left out until the pattern changes.
constexpr int patience = 3;
/// Multigrid is kept for the next systems until keeping it has cost this many more iterations than the system took for
/// which it was made: making it takes about as long (bench/README.md).
constexpr int worth_of_multigrid = 30;

}  // namespace

void LinearSolver::destroy() {
  KSPDestroy(&ksp_);
  direct_.reset();
  fallback_.reset();
}

/// Direct in the plane (nested dissection keeps factors small), in small systems, in bordered ones and with pressures.
void LinearSolver::choose(const SystemLayout& layout) {
  using Linear = Solver::Linear;
  const std::string size = fmt::format("{} unknowns in {}", layout.n_global, layout.dimension == 3 ? "space" : "the plane");
  iterative_ = options_.linear == Linear::iterative ||
               (options_.linear == Linear::automatic && layout.dimension == 3 && layout.n_global > largest_direct_in_space);
  const char* direct_only = layout.bordered ? ", bordered by the gauge" : layout.indefinite ? ", with pressures" : nullptr;
  if (direct_only) iterative_ = false;
  const char* factors = symmetric_ ? "L D L^T" : "L U";
  const char* krylov = symmetric_ ? "conjugate gradients" : "GMRES";
  const bool as_wished = options_.linear != Linear::automatic && !(direct_only && options_.linear == Linear::iterative);
  const bool nothing_to_say = comm_.size() == 1 || options_.linear == Linear::distributed;
  const char* where = nothing_to_say ? "" : " on the first process";
  const char* why = as_wished ? ", as the case says" : direct_only ? direct_only : "";
  choice_ = iterative_ ? fmt::format("{} with algebraic multigrid ({}{}); MUMPS if it stagnates", krylov, size, why)
                       : fmt::format("MUMPS{}, {} ({}{})", where, factors, size, why);
}

/// A system that is large enough for multigrid is too large for one process.
void LinearSolver::make_direct(std::optional<DirectSolver>& solver, const char* prefix) {
  using Where = DirectSolver::Where;
  const bool spread = options_.linear == Solver::Linear::distributed || iterative_;
  solver.emplace(matrix_, symmetric_, prefix, comm_, spread ? Where::all_processes : Where::first_process, work_space_);
}

void LinearSolver::make_iterative() {
  PC pc;
  KSPDestroy(&ksp_);
  check_petsc(KSPCreate(mpi_comm(comm_), &ksp_), "creating a solver");
  KSPSetType(ksp_, symmetric_ ? KSPCG : KSPGMRES);
  if (!symmetric_) {
    KSPGMRESSetRestart(ksp_, 60);
    KSPSetPCSide(ksp_, PC_RIGHT);
  }
  // The default norm, of the preconditioned residual, stops multigrid at a true residual of 1e-5.
  KSPSetNormType(ksp_, KSP_NORM_UNPRECONDITIONED);
  KSPSetTolerances(ksp_, options_.linear_tolerance, 0.0, 1e8, most_iterations);
  KSPGetPC(ksp_, &pc);
  PCSetType(pc, PCGAMG);
  check_petsc(KSPSetFromOptions(ksp_), "reading solver options");
}

/// Multigrid's coarse levels shall reproduce them.
void LinearSolver::set_rigid_modes(const SystemLayout& layout) {
  Vec coordinates;
  check_petsc(MatCreateVecs(matrix_, &coordinates, nullptr), "creating a vector");
  PetscScalar* x;
  VecGetArray(coordinates, &x);
  for (const Vec3& place : layout.places)
    for (int i = 0; i < layout.dimension; ++i) *x++ = place[i];
  VecRestoreArray(coordinates, &x);
  MatNullSpace rigid_modes;
  check_petsc(MatNullSpaceCreateRigidBody(coordinates, &rigid_modes), "making the rigid modes");
  MatSetNearNullSpace(matrix_, rigid_modes);
  MatNullSpaceDestroy(&rigid_modes);
  VecDestroy(&coordinates);
}

void LinearSolver::set_matrix(Mat matrix, const SystemLayout& layout, bool symmetric) {
  destroy();
  matrix_ = matrix;
  symmetric_ = symmetric;
  stagnated_ = 0;
  excess_ = worth_of_multigrid;
  choose(layout);
  if (iterative_) {
    set_rigid_modes(layout);
    make_iterative();
  } else {
    make_direct(direct_, "");
  }
}

/// With the multigrid of an earlier matrix as long as it serves: what ends the iterations is the true residual, so that only
/// their number depends on it. Then all of it is made anew; the parts that PETSc would keep (which unknowns are strongly
/// coupled, bounds of eigenvalues) mislead where a part of the body has lost most of its stiffness.
bool LinearSolver::iterate(Vec b, Vec x, int* iterations) {
  PC pc;
  PetscBool multigrid = PETSC_FALSE;
  KSPGetPC(ksp_, &pc);
  PetscObjectTypeCompare(reinterpret_cast<PetscObject>(pc), PCGAMG, &multigrid);  // the case's options may say otherwise
  const bool keep = multigrid && excess_ < worth_of_multigrid;
  if (multigrid && !keep) make_iterative();
  KSPSetReusePreconditioner(ksp_, keep ? PETSC_TRUE : PETSC_FALSE);
  int n = 0;
  const bool solved = solve_by(ksp_, matrix_, b, x, &n);
  *iterations += n;
  if (keep && !solved) {
    excess_ = worth_of_multigrid;
    return iterate(b, x, iterations);
  }
  if (!keep) fresh_iterations_ = n;
  excess_ = !solved ? worth_of_multigrid : keep ? excess_ + std::max(0, n - fresh_iterations_) : 0;
  return solved;
}

bool LinearSolver::solve(Vec b, Vec x) {
  const Stopwatch watch(seconds_);
  ++count_.solves;
  if (!iterative_) {
    const bool solved = direct_->solve(b, x);
    count_.iterations += direct_->iterations();
    return solved;
  }
  if (stagnated_ < patience) {
    int iterations = 0;
    const bool solved = iterate(b, x, &iterations);
    count_.iterations += iterations;
    stagnated_ = solved ? 0 : stagnated_ + 1;
    if (solved) return true;
  }
  ++count_.fallbacks;
  if (!fallback_) make_direct(fallback_, "fallback_");
  return fallback_->solve(b, x);
}

}  // namespace berm
