#pragma once
/// What a case may ask of PETSc: some options of solvers, with values in a range. Of PETSc's others some reach the whole process, write files,
/// load libraries or run programs, which a case file from elsewhere must not do, and some end the process or never end.

#include <string>

namespace berm {

/// Why the options are refused, or "". `files`: the user lets them be anything (--allow-petsc-files).
std::string problem_of_petsc(const std::string& options, bool files);

}  // namespace berm
