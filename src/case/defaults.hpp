#pragma once
/// What a case gets that does not say how it is to be computed.   [docs/adr/0016]

#include "case/case.hpp"
#include "case/node.hpp"

namespace berm {

/// Fills in formulation, shape functions and volumetric strain where the file is silent, writes them into its tree, and
/// says in `c.choices` what was chosen and why. Before check_case.
void choose_defaults(Case& c, Node& root);

}  // namespace berm
