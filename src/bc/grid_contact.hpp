#pragma once
/// Contact with Coulomb friction between deformable bodies, at the nodes of the grid where their fields meet
/// (Bardenhagen, Brackbill and Sulsky 2000, here within the implicit residual).   [docs/theory/contact.md]

#include <map>

#include "bc/coulomb.hpp"
#include "method/discretisation.hpp"

namespace berm {

struct FieldContact {
  int field_a = 0, field_b = 0;  ///< a < b
  double friction = 0.0;         ///< coefficient [-]
  double stiffness = 0.0;        ///< penalty of a node [N/m]
};

class GridContact {
public:
  /// Contacts of a stage; forces are kept.
  void set(std::vector<FieldContact> contacts) { contacts_ = std::move(contacts); }
  bool empty() const { return contacts_.empty(); }

  /// Forces that resist du, of the interfaces that this process owns, added to f; their matrix, if wanted.
  void add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const;
  /// Work that the forces take over the step, of this process: friction, and the little that the penalty stores [J].
  double work(const Discretisation& d, const NodalVector& du) const;
  /// The forces at du are those of t_n now. Collective.
  void commit(const Discretisation& d, const NodalVector& du);

  /// What is kept from step to step, five numbers a node in contact: its number in field a, field b, force. The same on
  /// all processes.
  std::vector<double> rows() const;
  void restore(const std::vector<double>& rows);

private:
  const FieldContact* find(const Interface& at) const;
  Vec3 carried(const Discretisation& d, const Interface& at) const;
  /// Calls work(interface, force) for those in contact at du.
  template <class Work>
  void for_touching(const Discretisation& d, const NodalVector& du, Work work) const;

  std::vector<FieldContact> contacts_;
  std::map<std::pair<std::int64_t, int>, Vec3> carried_;  ///< by node of field a, and field b
};

}  // namespace berm
