#pragma once
/// What all that calls PETSc needs. For la/ only.

#include <petscksp.h>

namespace berm {

/// Throws RunError with PETSc's text unless code is 0.
void check_petsc(PetscErrorCode code, const char* what);

/// True if x solves matrix * x = b by that solver; `iterations` says in how many.
bool solve_by(KSP solver, Mat matrix, Vec b, Vec x, int* iterations);

}  // namespace berm
