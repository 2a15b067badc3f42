#include "la/direct.hpp"

#include <algorithm>

#include "comm/mpi.hpp"
#include "la/petsc.hpp"

namespace berm {

DirectSolver::DirectSolver(Mat matrix, bool symmetric, const std::string& prefix, const Comm& comm, Where where, int& space)
    : matrix_(matrix), symmetric_(symmetric), prefix_(prefix), comm_(comm), where_(where), space_(space) {
  make_solver();
}

DirectSolver::~DirectSolver() {
  KSPDestroy(&ksp_);
  VecScatterDestroy(&to_first_);
  VecDestroy(&b_);
  VecDestroy(&x_);
  if (gathered_) MatDestroySubMatrices(1, &gathered_);
}

void DirectSolver::make_solver() {
  PC pc;
  KSPDestroy(&ksp_);
  check_petsc(KSPCreate(gathers() ? PETSC_COMM_SELF : mpi_comm(comm_), &ksp_), "creating a solver");
  KSPSetOptionsPrefix(ksp_, prefix_.c_str());
  KSPSetType(ksp_, KSPPREONLY);
  KSPGetPC(ksp_, &pc);
  PCSetType(pc, symmetric_ ? PCCHOLESKY : PCLU);
  PCFactorSetMatSolverType(pc, MATSOLVERMUMPS);
  check_petsc(KSPSetFromOptions(ksp_), "reading solver options");
}

/// All rows to the first process, none to the others.
void DirectSolver::gather_matrix() {
  IS rows, columns;
  PetscInt n = 0;
  check_petsc(MatGetSize(matrix_, &n, nullptr), "asking for the size of the matrix");
  if (!comm_.is_root()) n = 0;
  check_petsc(ISCreateStride(PETSC_COMM_SELF, n, 0, 1, &rows), "naming the rows");
  check_petsc(ISCreateStride(PETSC_COMM_SELF, n, 0, 1, &columns), "naming the columns");
  check_petsc(MatCreateSubMatrices(matrix_, 1, &rows, &columns, gathered_ ? MAT_REUSE_MATRIX : MAT_INITIAL_MATRIX, &gathered_),
              "gathering the matrix");
  ISDestroy(&rows);
  ISDestroy(&columns);
  if (symmetric_) MatSetOption(gathered_[0], MAT_SPD, PETSC_TRUE);
}

bool DirectSolver::solve_gathered(Vec b, Vec x) {
  gather_matrix();
  if (!to_first_) {
    check_petsc(VecScatterCreateToZero(b, &to_first_, &b_), "preparing to gather a vector");
    check_petsc(VecDuplicate(b_, &x_), "creating a vector");
  }
  VecScatterBegin(to_first_, b, b_, INSERT_VALUES, SCATTER_FORWARD);
  VecScatterEnd(to_first_, b, b_, INSERT_VALUES, SCATTER_FORWARD);
  int solved = 0;
  comm_.agree([&] {
    if (comm_.is_root()) solved = solve_here(gathered_[0], b_, x_);
  });
  solved = comm_.broadcast(solved);
  VecScatterBegin(to_first_, x_, x, INSERT_VALUES, SCATTER_REVERSE);
  VecScatterEnd(to_first_, x_, x, INSERT_VALUES, SCATTER_REVERSE);
  return solved != 0;
}

/// MUMPS guesses its work space before it pivots: INFOG(1) = -8, -9 say that it was too small, by how much nobody knows.
bool DirectSolver::ran_out_of_space() const {
  PC pc;
  Mat factors = nullptr;
  PetscInt info = 0;
  KSPGetPC(ksp_, &pc);
  if (PCFactorGetMatrix(pc, &factors) != 0 || !factors) return false;
  MatMumpsGetInfog(factors, 1, &info);  // of all its processes
  return info == -8 || info == -9;
}

/// To the factorisations to come.
void DirectSolver::give_space(Mat matrix) {
  PC pc;
  Mat factors = nullptr;
  make_solver();
  KSPGetPC(ksp_, &pc);
  KSPSetOperators(ksp_, matrix, matrix);
  if (PCFactorSetUpMatSolverType(pc) == 0 && PCFactorGetMatrix(pc, &factors) == 0 && factors)
    MatMumpsSetIcntl(factors, 14, space_);
}

bool DirectSolver::solve_here(Mat matrix, Vec b, Vec x) {
  constexpr int least = 100, most = 1600;  // [%]
  if (space_ > 0 && !started_) give_space(matrix);
  started_ = true;
  while (!solve_by(ksp_, matrix, b, x, &iterations_)) {
    if (!ran_out_of_space() || space_ >= most) return false;
    space_ = std::max(least, 4 * space_);
    give_space(matrix);
  }
  return true;
}

bool DirectSolver::solve(Vec b, Vec x) { return gathers() ? solve_gathered(b, x) : solve_here(matrix_, b, x); }

}  // namespace berm
