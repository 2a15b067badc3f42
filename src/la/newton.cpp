#include "la/newton.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <petscsnes.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <sstream>
#include <string_view>

#include "base/error.hpp"
#include "base/system_file.hpp"
#include "comm/mpi.hpp"
#include "la/linear.hpp"
#include "la/petsc.hpp"

namespace berm {
namespace {

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

/// PETSc adds what a coarse matrix of multigrid gets from several others in the order of arrival, but for this way, which takes
/// a quarter longer: the same run twice shall be the same run.
void keep_order_of_sums() {
  int processes = 1;
  MPI_Comm_size(PETSC_COMM_WORLD, &processes);
  PetscBool chosen = PETSC_FALSE;
  PetscOptionsHasName(nullptr, nullptr, "-matptap_via", &chosen);
  if (processes > 2 && !chosen) PetscOptionsSetValue(nullptr, "-matptap_via", "backend");
}

bool no_room = false;

/// OpenBLAS takes memory for itself when it is first called, and asks for ever where it cannot have it.
void check_room() {
  constexpr std::size_t needed = std::size_t(160) << 20;
  static bool had = false;  // it keeps what it has taken
  if (had || !dlsym(RTLD_DEFAULT, "openblas_set_num_threads")) return;
  void* room = mmap(nullptr, needed, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  no_room = room == MAP_FAILED;
  if (no_room)
    throw RunError(fmt::format("the linear algebra needs {} MB of addresses for itself, and this process may not have as many: raise its limit (ulimit -v, ulimit -d)",
                               needed >> 20));
  munmap(room, needed);
  had = true;
}

/// Options of a run are in its case, where they are looked at: neither the environment nor a .petscrc in a folder adds to them.
void ignore_environment() {
  for (const char* name : {"PETSC_OPTIONS", "PETSC_OPTIONS_YAML"}) {
    if (const char* given = std::getenv(name); given && *given && is_first_process())
      std::fputs(fmt::format("warning: {} in the environment is not read: [solver] petsc takes options\n", name).c_str(), stderr);
    unsetenv(name);
  }
}

}  // namespace

void start_petsc(const std::string& options) {
  // Threads inside the small dense blocks of a sparse factorisation cost more than they bring (2D, up to 1e5 unknowns).
  if (!std::getenv("OPENBLAS_NUM_THREADS"))
    if (auto* set_threads = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads")))
      set_threads(1);
  // One process needs no daemon of Open MPI's beside it, nor the PATH which that wants, nor a folder: all such processes would
  // have the same one, and one that ends would remove it while another begins. Nor what is set for several, or for another Open MPI.
  if (!rank_of_launcher()) {
    forget_variables(is_setting_of_mpi);
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  }
  // Open MPI asks for these two before it runs as root (containers, CI).
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (!running) {
    raise_limit_of_open_files(64);  // Open MPI takes some 20 and has no words for too few of them, the files of a run are a dozen
    constexpr std::array kept = {SIGQUIT, SIGHUP, SIGTERM, SIGURG};  // PETSc would make them its own, or what they are by default
    std::array<struct sigaction, kept.size()> as_they_were;
    for (std::size_t k = 0; k < kept.size(); ++k) sigaction(kept[k], nullptr, &as_they_were[k]);
    ignore_environment();
    static char name[] = "berm", no_file[] = "-skip_petscrc";
    static char* words[] = {name, no_file, nullptr};  // PETSc keeps them
    static int n_words = 2;
    static char** argv = words;
    check_petsc(PetscInitialize(&n_words, &argv, nullptr, nullptr), "start");
    PetscPopSignalHandler();  // it has words of its own for faults, and another exit code
    for (std::size_t k = 0; k < kept.size(); ++k) sigaction(kept[k], &as_they_were[k], nullptr);
    say_faults();
    PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
    // Its handler ends the process on these two; whoever writes to a reader that has gone, or beyond the limit of file
    // sizes, gets an error from the system instead.
    for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
    // A thread of OpenBLAS may be asking, and the end of the process would wait for it.
    std::atexit([] {
      if (!no_room) return;
      std::fflush(nullptr);
      std::_Exit(1);
    });
    // MPI cannot be started twice in a process: it ends with the process, not with the run.
    std::atexit([] { PetscFinalize(); });
  }
  keep_order_of_sums();
  if (!options.empty()) check_petsc(PetscOptionsInsertString(nullptr, options.c_str()), "reading its options");
}

std::vector<std::string> take_back_options(const std::string& options) {
  std::vector<std::string> unused, names;
  std::istringstream words(options);
  for (std::string word; words >> word;) {
    PetscBool is_name = PETSC_FALSE, used = PETSC_FALSE;
    PetscOptionsValidKey(word.c_str(), &is_name);
    if (!is_name) continue;
    PetscOptionsUsed(nullptr, word.c_str() + 1, &used);  // it keeps names without their dash
    names.push_back(word);
    if (!used) unused.push_back(word);
  }
  for (const std::string& name : names) PetscOptionsClearValue(nullptr, name.c_str());
  return unused;
}

struct NewtonSolver::Impl {
  Impl(const Solver& options, const Comm& group) : comm(group), linear(options, group) {}

  Comm comm;
  LinearSolver linear;
  SNES snes = nullptr;
  Mat mat = nullptr;
  Vec x = nullptr, r = nullptr, rhs = nullptr;
  CsrMatrix* csr = nullptr;
  const Residual* residual = nullptr;
  const Jacobian* jacobian = nullptr;
  std::vector<double> x_buffer, r_buffer;
  std::vector<double> residuals, best;
  double least = 0.0;
  StepLength length = StepLength::full;
  std::exception_ptr error;

  void destroy() {
    linear.destroy();
    SNESDestroy(&snes);
    MatDestroy(&mat);
    VecDestroy(&x);
    VecDestroy(&r);
    VecDestroy(&rhs);
  }

  void make_matrix(const SystemLayout& layout) {
    if (comm.size() == 1) {
      const PetscInt n = csr->n;
      check_petsc(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, n, n, csr->row_begin.data(), csr->column.data(),
                                            csr->value.data(), &mat),
                  "creating the matrix");
      if (!layout.bordered) MatSetBlockSize(mat, layout.dimension);
    } else {
      if (layout.n_global > 2147483647)
        throw RunError("more than 2^31 unknowns: PETSc's 32-bit numbers do not reach so far");
      check_petsc(MatCreate(mpi_comm(comm), &mat), "creating the matrix");
      MatSetSizes(mat, layout.n_mine, layout.n_mine, PETSC_DETERMINE, PETSC_DETERMINE);
      MatSetType(mat, MATMPIAIJ);
      if (!layout.bordered) MatSetBlockSize(mat, layout.dimension);
      // Every process hands in its rows, ghosts' included: PETSc finds once where they go.
      std::vector<PetscInt> rows(csr->column.size()), columns(csr->column.size());
      for (int i = 0; i < csr->n; ++i)
        for (int k = csr->row_begin[i]; k < csr->row_begin[i + 1]; ++k) {
          rows[k] = static_cast<PetscInt>(layout.global[i]);
          columns[k] = static_cast<PetscInt>(layout.global[csr->column[k]]);
        }
      check_petsc(MatSetPreallocationCOO(mat, static_cast<PetscCount>(rows.size()), rows.data(), columns.data()),
                  "laying out the matrix");
    }
  }

  /// Tells PETSc that the values have changed.
  void touch() {
    if (comm.size() > 1) {
      check_petsc(MatSetValuesCOO(mat, csr->value.data(), INSERT_VALUES), "filling the matrix");
      return;
    }
    PetscScalar* values;
    MatSeqAIJGetArray(mat, &values);
    MatSeqAIJRestoreArray(mat, &values);
  }

  // PETSc is C: exceptions of the callbacks are carried around it. They are the same on all processes (Comm::agree).
  static PetscErrorCode evaluate(SNES snes, Vec x, Vec r, void* context) {
    auto& self = *static_cast<Impl*>(context);
    try {
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

  /// Steps of fixed length whose residuals no longer fall go round in circles.
  bool goes_round() const {
    constexpr std::size_t patience = 8;
    constexpr double progress = 0.3;
    if (length == StepLength::line_search || residuals.size() < 2 * patience) return false;
    const auto split = residuals.end() - patience;
    return *std::min_element(split, residuals.end()) > progress * *std::min_element(residuals.begin(), split);
  }

  static PetscErrorCode converged(SNES snes, PetscInt iteration, PetscReal x, PetscReal step, PetscReal f,
                                  SNESConvergedReason* reason, void* context) {
    const PetscErrorCode code = SNESConvergedDefault(snes, iteration, x, step, f, reason, nullptr);
    if (code == 0 && *reason == SNES_CONVERGED_ITERATING && static_cast<Impl*>(context)->goes_round())
      *reason = SNES_DIVERGED_LOCAL_MIN;
    return code;
  }

  static PetscErrorCode monitor(SNES snes, PetscInt, PetscReal norm, void* context) {
    auto& self = *static_cast<Impl*>(context);
    if (self.residuals.empty() || norm < self.least) {
      Vec x;
      SNESGetSolution(snes, &x);
      const auto data = view(x);
      self.best.assign(data.begin(), data.end());
      self.least = norm;
    }
    self.residuals.push_back(norm);
    return 0;
  }

  /// SNES sees our linear solver as a preconditioner that is exact.
  static PetscErrorCode apply(PC pc, Vec b, Vec x) {
    void* context;
    PCShellGetContext(pc, &context);
    auto& self = *static_cast<Impl*>(context);
    try {
      if (!self.linear.solve(b, x)) {
        VecSet(x, 0.0);
        PCSetFailedReason(pc, PC_SUBPC_ERROR);
      }
      return 0;
    } catch (...) {
      self.error = std::current_exception();
      return PETSC_ERR_USER;
    }
  }
};

NewtonSolver::NewtonSolver(const Solver& options, const Comm& comm) : impl_(std::make_unique<Impl>(options, comm)) {}

NewtonSolver::~NewtonSolver() { impl_->destroy(); }

void NewtonSolver::set_matrix(CsrMatrix& matrix, const SystemLayout& layout, bool symmetric) {
  Impl& m = *impl_;
  m.comm.agree(check_room);
  m.destroy();
  m.csr = &matrix;
  m.make_matrix(layout);
  if (symmetric) check_petsc(MatSetOption(m.mat, MAT_SPD, PETSC_TRUE), "marking the matrix as symmetric");
  const MPI_Comm group = mpi_comm(m.comm);
  check_petsc(MatCreateVecs(m.mat, &m.x, nullptr), "creating a vector");
  check_petsc(VecDuplicate(m.x, &m.r), "creating a vector");
  check_petsc(VecDuplicate(m.x, &m.rhs), "creating a vector");
  m.r_buffer.assign(layout.n_mine, 0.0);
  m.linear.set_matrix(m.mat, layout, symmetric);

  check_petsc(SNESCreate(group, &m.snes), "creating SNES");
  SNESSetFunction(m.snes, m.r, Impl::evaluate, &m);
  SNESSetJacobian(m.snes, m.mat, m.mat, Impl::differentiate, &m);
  SNESMonitorSet(m.snes, Impl::monitor, &m, nullptr);
  SNESSetConvergenceTest(m.snes, Impl::converged, &m, nullptr);
  SNESSetDivergenceTolerance(m.snes, -1.0);
  KSP ksp;
  PC pc;
  SNESGetKSP(m.snes, &ksp);
  KSPSetOptionsPrefix(ksp, "newton_");
  KSPSetType(ksp, KSPPREONLY);
  KSPGetPC(ksp, &pc);
  PCSetType(pc, PCSHELL);
  PCShellSetContext(pc, &m);
  PCShellSetApply(pc, Impl::apply);
  check_petsc(SNESSetFromOptions(m.snes), "reading solver options");
}

const std::string& NewtonSolver::choice() const { return impl_->linear.choice(); }

bool NewtonSolver::solve_linear(const std::vector<double>& rhs, std::vector<double>& x) {
  x.clear();
  Impl& m = *impl_;
  m.touch();
  copy(rhs, m.rhs);
  if (!m.linear.solve(m.rhs, m.x)) return false;
  const auto data = view(m.x);
  x.assign(data.begin(), data.end());
  return true;
}

NewtonResult NewtonSolver::solve(std::vector<double>& x, double tolerance, StepLength length, int most,
                                 const Residual& residual, const Jacobian& jacobian) {
  Impl& m = *impl_;
  m.residual = &residual;
  m.jacobian = &jacobian;
  m.residuals.clear();
  m.best.clear();
  m.least = 0.0;
  m.error = nullptr;
  copy(x, m.x);
  SNESSetTolerances(m.snes, tolerance, 0.0, 0.0, most, 100000);
  SNESLineSearch search;
  SNESGetLineSearch(m.snes, &search);
  m.length = length;
  SNESLineSearchSetType(search, length == StepLength::line_search ? SNESLINESEARCHBT : SNESLINESEARCHBASIC);
  SNESLineSearchSetDamping(search, length == StepLength::half ? 0.5 : 1.0);
  const PetscErrorCode code = SNESSolve(m.snes, nullptr, m.x);
  if (m.error) std::rethrow_exception(m.error);

  NewtonResult result;
  result.residuals = m.residuals;
  result.best = m.best;
  result.least = m.least;
  PetscInt iterations = 0;
  SNESGetIterationNumber(m.snes, &iterations);
  result.iterations = static_cast<int>(iterations);
  result.residual = m.residuals.empty() ? 0.0 : m.residuals.back();
  SNESConvergedReason reason = SNES_CONVERGED_ITERATING;
  SNESGetConvergedReason(m.snes, &reason);
  result.converged = code == 0 && reason > 0;
  if (code != 0)
    result.reason = "PETSc error " + std::to_string(code);
  else if ((result.stood_still = reason == SNES_DIVERGED_LOCAL_MIN && m.goes_round()))
    result.reason = "the residual no longer falls";
  else if (!result.converged)
    result.reason = SNESConvergedReasons[reason];
  const auto data = view(m.x);
  x.assign(data.begin(), data.end());
  return result;
}

double NewtonSolver::linear_seconds() const { return impl_->linear.seconds(); }
LinearCount NewtonSolver::count() const { return impl_->linear.count(); }

}  // namespace berm
