#include "la/newton.hpp"

#include <dlfcn.h>
#include <petscsnes.h>

#include <algorithm>
#include <cstdlib>
#include <span>

#include "base/error.hpp"
#include "base/stopwatch.hpp"

namespace berm {
namespace {

void check(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw RunError(std::string("PETSc: ") + what + " failed: " + (text ? text : "unknown error"));
}

std::span<const double> view(Vec v) {
  PetscInt n;
  const PetscScalar* data;
  VecGetLocalSize(v, &n);
  VecGetArrayRead(v, &data);
  const std::span<const double> s(data, n);
  VecRestoreArrayRead(v, &data);
  return s;
}

void copy(const std::vector<double>& from, Vec to) {
  PetscScalar* data;
  VecGetArray(to, &data);
  std::copy(from.begin(), from.end(), data);
  VecRestoreArray(to, &data);
}

}  // namespace

void start_petsc(const std::string& options) {
  // Threads inside the small dense blocks of a sparse factorisation cost more than they bring (2D, up to 1e5 unknowns).
  if (!std::getenv("OPENBLAS_NUM_THREADS"))
    if (auto* set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")))
      set_threads(1);
  // A single process needs no mpiexec; Open MPI asks for these two before it runs as root (containers, CI).
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (!running) {
    check(PetscInitializeNoArguments(), "start");
    PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
    // MPI cannot be started twice in a process: it ends with the process, not with the run.
    std::atexit([] { PetscFinalize(); });
  }
  if (!options.empty()) check(PetscOptionsInsertString(nullptr, options.c_str()), "reading its options");
}

struct NewtonSolver::Impl {
  int max_iterations = 25;
  SNES snes = nullptr;
  Mat mat = nullptr;
  Vec x = nullptr, r = nullptr, rhs = nullptr;
  const Residual* residual = nullptr;
  const Jacobian* jacobian = nullptr;
  std::vector<double> x_buffer, r_buffer;
  std::vector<double> residuals;
  std::exception_ptr error;
  double linear_seconds = 0.0, callback_seconds = 0.0;

  void destroy() {
    SNESDestroy(&snes);
    MatDestroy(&mat);
    VecDestroy(&x);
    VecDestroy(&r);
    VecDestroy(&rhs);
  }

  /// Tells PETSc that the values of the shared arrays have changed.
  void touch() {
    PetscScalar* values;
    MatSeqAIJGetArray(mat, &values);
    MatSeqAIJRestoreArray(mat, &values);
  }

  // PETSc is C: exceptions of the callbacks are carried around it.
  static PetscErrorCode evaluate(SNES snes, Vec x, Vec r, void* context) {
    auto& self = *static_cast<Impl*>(context);
    try {
      const Stopwatch watch(self.callback_seconds);
      const auto data = view(x);
      self.x_buffer.assign(data.begin(), data.end());
      if ((*self.residual)(self.x_buffer, self.r_buffer))
        copy(self.r_buffer, r);
      else
        SNESSetFunctionDomainError(snes);
      return 0;
    } catch (...) {
      self.error = std::current_exception();
      return PETSC_ERR_USER;
    }
  }

  static PetscErrorCode differentiate(SNES, Vec x, Mat, Mat, void* context) {
    auto& self = *static_cast<Impl*>(context);
    try {
      const Stopwatch watch(self.callback_seconds);
      const auto data = view(x);
      self.x_buffer.assign(data.begin(), data.end());
      (*self.jacobian)(self.x_buffer);
      self.touch();
      return 0;
    } catch (...) {
      self.error = std::current_exception();
      return PETSC_ERR_USER;
    }
  }

  static PetscErrorCode monitor(SNES, PetscInt, PetscReal norm, void* context) {
    static_cast<Impl*>(context)->residuals.push_back(norm);
    return 0;
  }
};

NewtonSolver::NewtonSolver(int max_iterations) : impl_(std::make_unique<Impl>()) {
  impl_->max_iterations = max_iterations;
}

NewtonSolver::~NewtonSolver() { impl_->destroy(); }

void NewtonSolver::set_matrix(CsrMatrix& matrix, bool symmetric) {
  Impl& m = *impl_;
  m.destroy();
  const PetscInt n = matrix.n;
  check(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, matrix.row_begin.data(), matrix.column.data(),
                                  matrix.value.data(), &m.mat),
        "creating the matrix");
  if (symmetric) check(MatSetOption(m.mat, MAT_SPD, PETSC_TRUE), "marking the matrix as symmetric");
  check(VecCreateSeq(PETSC_COMM_SELF, n, &m.x), "creating a vector");
  check(VecDuplicate(m.x, &m.r), "creating a vector");
  check(VecDuplicate(m.x, &m.rhs), "creating a vector");
  m.r_buffer.assign(n, 0.0);

  check(SNESCreate(PETSC_COMM_SELF, &m.snes), "creating SNES");
  SNESSetFunction(m.snes, m.r, Impl::evaluate, &m);
  SNESSetJacobian(m.snes, m.mat, m.mat, Impl::differentiate, &m);
  SNESMonitorSet(m.snes, Impl::monitor, &m, nullptr);
  SNESSetDivergenceTolerance(m.snes, -1.0);

  KSP ksp;
  PC pc;
  SNESGetKSP(m.snes, &ksp);
  KSPSetType(ksp, KSPPREONLY);
  KSPGetPC(ksp, &pc);
  PCSetType(pc, symmetric ? PCCHOLESKY : PCLU);
  PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
  check(SNESSetFromOptions(m.snes), "reading solver options");
}

bool NewtonSolver::solve_linear(const std::vector<double>& rhs, std::vector<double>& x) {
  x.clear();
  if (rhs.empty()) return true;  // every displacement is prescribed
  Impl& m = *impl_;
  m.touch();
  KSP ksp;
  SNESGetKSP(m.snes, &ksp);
  KSPSetOperators(ksp, m.mat, m.mat);
  copy(rhs, m.rhs);
  const Stopwatch watch(m.linear_seconds);
  if (KSPSolve(ksp, m.rhs, m.x) != 0) return false;
  KSPConvergedReason reason;
  KSPGetConvergedReason(ksp, &reason);
  if (reason < 0) return false;
  const auto data = view(m.x);
  x.assign(data.begin(), data.end());
  return true;
}

NewtonResult NewtonSolver::solve(std::vector<double>& x, double tolerance, bool line_search, const Residual& residual,
                                 const Jacobian& jacobian) {
  Impl& m = *impl_;
  m.residual = &residual;
  m.jacobian = &jacobian;
  m.residuals.clear();
  m.error = nullptr;
  copy(x, m.x);
  SNESSetTolerances(m.snes, tolerance, 0.0, 0.0, m.max_iterations, 100000);
  SNESLineSearch search;
  SNESGetLineSearch(m.snes, &search);
  SNESLineSearchSetType(search, line_search ? SNESLINESEARCHBT : SNESLINESEARCHBASIC);
  m.callback_seconds = 0.0;
  double total = 0.0;
  PetscErrorCode code;
  {
    const Stopwatch watch(total);
    code = SNESSolve(m.snes, nullptr, m.x);
  }
  m.linear_seconds += total - m.callback_seconds;
  if (m.error) std::rethrow_exception(m.error);

  NewtonResult result;
  result.residuals = m.residuals;
  PetscInt iterations = 0;
  SNESGetIterationNumber(m.snes, &iterations);
  result.iterations = static_cast<int>(iterations);
  result.residual = m.residuals.empty() ? 0.0 : m.residuals.back();
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  SNESGetConvergedReason(m.snes, &reason);
  result.converged = code == 0 && reason > 0;
  if (code != 0)
    result.reason = "PETSc error " + std::to_string(code);
  else if (!result.converged)
    result.reason = SNESConvergedReasons[reason];
  const auto data = view(m.x);
  x.assign(data.begin(), data.end());
  return result;
}

double NewtonSolver::linear_seconds() const { return impl_->linear_seconds; }

}  // namespace berm
