#pragma once
/// Contact with Coulomb friction between deformable bodies, at the nodes of the grid where their fields meet
/// (Bardenhagen, Brackbill and Sulsky 2000, here within the implicit residual).   [docs/theory/contact.md]

#include "method/discretisation.hpp"

namespace berm {

struct FieldContact {
  int field_a = 0, field_b = 0;  ///< a < b
  double friction = 0.0;         ///< coefficient [-]
  double stiffness = 0.0;        ///< penalty of a node [N/m]
};

class GridContact {
public:
  void clear() { contacts_.clear(); }
  void add(const FieldContact& contact) { contacts_.push_back(contact); }

  /// Forces that resist du, of the interfaces that this process owns, added to f; their matrix, if wanted.
  void add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const;
  /// Work that the forces take over the step: friction, and the little that the penalty needs [J].
  double work(const Discretisation& d, const NodalVector& du) const;
  bool empty() const { return contacts_.empty(); }

private:
  const FieldContact* find(const Interface& at) const;
  std::vector<FieldContact> contacts_;
};

}  // namespace berm
