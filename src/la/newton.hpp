#pragma once
/// Newton's method through PETSc's SNES, and the linear solver inside it. The only header above PETSc.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "method/csr.hpp"

namespace berm {

/// Starts PETSc (and MPI) unless they run already; they end with the process.
/// options: as on a PETSc command line, e.g. "-ksp_view". Throws RunError.
void start_petsc(const std::string& options = "");

struct NewtonResult {
  bool converged = false;
  int iterations = 0;
  double residual = 0.0;          ///< last norm [N]
  std::vector<double> residuals;  ///< norm of every iteration, the first one before any
  std::string reason;             ///< why it did not converge
};

class NewtonSolver {
public:
  /// r(x); false: x is outside of what the laws are defined for (the line search then shortens the step).
  using Residual = std::function<bool(const std::vector<double>& x, std::vector<double>& r)>;
  /// Fills the matrix given to set_matrix at x.
  using Jacobian = std::function<void(const std::vector<double>& x)>;

  explicit NewtonSolver(int max_iterations);
  ~NewtonSolver();

  /// The matrix that the Jacobian callback fills; its arrays are used in place, so it must outlive the solver or the
  /// next set_matrix. symmetric: LDL^T, else LU, both by MUMPS; PETSc's options override either.
  void set_matrix(CsrMatrix& matrix, bool symmetric);

  /// Solves matrix * x = rhs with the values now in the matrix. False if the factorisation failed.
  bool solve_linear(const std::vector<double>& rhs, std::vector<double>& x);

  /// Newton from x until the residual norm is below `tolerance` [N], with a backtracking line search or with full
  /// steps.
  NewtonResult solve(std::vector<double>& x, double tolerance, bool line_search, const Residual& residual,
                     const Jacobian& jacobian);

  /// Seconds spent in factorisation and substitution since the start.
  double linear_seconds() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace berm
