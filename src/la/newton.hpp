#pragma once
/// Newton's method through PETSc's SNES, and the linear solver inside it. The only header above PETSc.

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "case/case.hpp"
#include "comm/comm.hpp"
#include "method/csr.hpp"

namespace berm {

/// Starts PETSc (and MPI) unless they run already; they end with the process.
/// options: as on a PETSc command line, e.g. "-ksp_view". Throws RunError.
void start_petsc(const std::string& options = "");
/// Takes back the options that start_petsc was given, which PETSc keeps for the whole process. Returns those that nothing has
/// asked for: misspelt, or not for the solvers that were taken.
std::vector<std::string> take_back_options(const std::string& options);

struct NewtonResult {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;          ///< last norm [N]
  std::vector<double> residuals;  ///< norm of every iteration, the first one before any
  std::string reason;             ///< why it did not converge
  bool stood_still = false;       ///< it ended because the residual no longer fell
  std::vector<double> best;       ///< unknowns with the smallest norm on the way
  double least = 0.0;             ///< that norm [N]
};

/// Where the rows of a process's matrix stand in the whole. A process owns its first `n_mine` unknowns, but for the
/// border's one, which comes last in its matrix and is owned by the last process.
struct SystemLayout {
  int dimension = 2;                 ///< unknowns a node
  int n_mine = 0;                    ///< unknowns that this process owns, a border's included
  bool bordered = false;
  bool indefinite = false;           ///< some unknowns are pressures: for the direct method only
  std::vector<std::int64_t> global;  ///< number in the whole of every row of this process's matrix
  std::int64_t n_global = 0;
  std::vector<Vec3> places;          ///< of the owned nodes: rigid modes for multigrid
};

/// In space a factorisation of more unknowns than this costs several times what multigrid does (bench/README.md); smaller
/// ones take little time, and the direct method does not mind how damaged the body is.
constexpr std::int64_t largest_direct_in_space = 10000;

/// Counts of the linear solver since the start.
struct LinearCount {
  long solves = 0, iterations = 0, fallbacks = 0;
};

/// How far a Newton step goes: as a backtracking line search on the residual says; all the way; or half of it, which ends
/// circles between states of contact or yielding whose corrections overshoot each other.
enum class StepLength { line_search, full, half };

class NewtonSolver {
public:
  /// r(x); false: x is outside of what the laws are defined for (the line search then shortens the step). Vectors hold
  /// the unknowns that this process owns.
  using Residual = std::function<bool(const std::vector<double>& x, std::vector<double>& r)>;
  /// Fills the matrix given to set_matrix at x.
  using Jacobian = std::function<void(const std::vector<double>& x)>;

  NewtonSolver(const Solver& options, const Comm& comm);
  ~NewtonSolver();

  /// The matrix that the Jacobian callback fills; one process uses its arrays in place, so it must outlive the solver or
  /// the next set_matrix. symmetric: also positive definite. Collective.
  ///
  /// Direct solver: MUMPS, L D L^T or L U. Iterative: conjugate gradients or GMRES with algebraic multigrid that knows the
  /// rigid modes and is kept for the next matrices while it serves. PETSc's options override everything.
  void set_matrix(CsrMatrix& matrix, const SystemLayout& layout, bool symmetric);
  /// What was chosen and why, for the log.
  const std::string& choice() const;

  /// Solves matrix * x = rhs with the values now in the matrix. False if the factorisation failed.
  bool solve_linear(const std::vector<double>& rhs, std::vector<double>& x);

  /// Newton from x until the residual norm is below `tolerance` [N], in at most so many steps; without a line search it
  /// ends as soon as the residual no longer falls.
  NewtonResult solve(std::vector<double>& x, double tolerance, StepLength length, int most, const Residual& residual,
                     const Jacobian& jacobian);

  /// Seconds spent in solving linear systems since the start, set-up included.
  double linear_seconds() const;
  LinearCount count() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace berm
