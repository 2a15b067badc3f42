#pragma once
/// What a case may ask of PETSc: options of solvers. PETSc's others reach the whole process, and some write files, load
/// libraries or run programs, which a case file from elsewhere must not do.

#include <string>

namespace berm {

/// Why the options are refused, or "". `files`: the user lets them be anything (--allow-petsc-files).
std::string problem_of_petsc(const std::string& options, bool files);

}  // namespace berm
