#include "la/petsc.hpp"

#include <string>

#include "base/error.hpp"

namespace berm {

void check_petsc(PetscErrorCode code, const char* what) {
  if (code == 0) return;
  const char* kind = nullptr;
  char* words = nullptr;  // of the function that has failed: names and values
  PetscErrorMessage(code, &kind, &words);
  std::string text = kind ? kind : "unknown error";
  if (words && *words) text += std::string(" (") + words + ")";
  throw RunError(std::string("PETSc: ") + what + " failed: " + text);
}

bool solve_by(KSP solver, Mat matrix, Vec b, Vec x, int* iterations) {
  KSPSetOperators(solver, matrix, matrix);
  if (KSPSolve(solver, b, x) != 0) return false;
  KSPConvergedReason reason;
  KSPGetConvergedReason(solver, &reason);
  PetscInt n = 0;
  KSPGetIterationNumber(solver, &n);
  *iterations = static_cast<int>(n);
  return reason > 0;
}

}  // namespace berm
