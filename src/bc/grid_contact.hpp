#pragma once
/// Contact with Coulomb friction between deformable bodies, at the nodes of the grid where their fields meet
/// (Bardenhagen, Brackbill and Sulsky 2000, here within the implicit residual).   [docs/theory/contact.md]

#include <limits>
#include <map>

#include "method/discretisation.hpp"

namespace berm {

struct FieldContact {
  int field_a = 0, field_b = 0;  ///< a < b
  double friction = 0.0;         ///< coefficient [-]
  double stiffness = 0.0;        ///< penalty [N/m3]
};

struct ContactWork {
  double total = 0.0;  ///< heat, and what the penalty stores or gives back
  double heat = 0.0;   ///< of sliding
};

/// No gap is as small as this.
inline constexpr double none_closed = -std::numeric_limits<double>::infinity();

class GridContact {
public:
  /// Contacts of a stage; forces are kept, unless there is no contact left.
  void set(std::vector<FieldContact> contacts);
  bool empty() const { return contacts_.empty(); }

  /// The interfaces of the coming step. Before the four that follow.
  void begin_step(const Discretisation& d);
  /// Friction is limited by the pressure of now where bodies meet and, `in_equilibrium`, where they press the same nodes as at t_n;
  /// else by that at t_n. For the next begin_step.
  void limit_at_once(bool yes, bool in_equilibrium) { at_once_ = yes, settled_at_once_ = yes && in_equilibrium; }
  /// Bodies that meet count as closed up to that gap, while a step is guessed; else none_closed [m].
  void keep_closed(double gap) { kept_closed_ = gap; }
  /// Whether, on this process, friction is limited by the pressure of now anywhere.
  bool some_at_once() const;
  /// What is open, sticks or slides at du stays so until the next begin_step: Newton's method would go round in circles.
  void freeze(const NodalVector& du);
  /// How far the forces at du are from those of a contact that is not frozen, over the latter [-]. Collective.
  double violation(const Discretisation& d, const NodalVector& du) const;
  /// Forces that resist du, of the interfaces that this process owns, added to f; their matrix, if wanted.
  void add_forces(const Discretisation& d, const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const;
  /// What the forces take over the step, of this process [J].
  ContactWork work(const NodalVector& du) const;
  /// Largest scatter of a gap that closed in the step that has been committed last, of this process [m].
  double scatter(const Discretisation& d) const;
  /// The forces at du are those of t_n now. Collective.
  void commit(const Discretisation& d, const NodalVector& du);

  /// What is kept from step to step, five numbers a node in contact: its number in field a, field b, force. The same on
  /// all processes.
  std::vector<double> rows() const;
  void restore(const std::vector<double>& rows);

private:
  enum class Status { undecided, open, sticks, slides };
  /// An interface of the step with a contact.
  struct Touch {
    const Interface* at;
    FieldContact contact;
    Vec3 carried;  ///< force of a on b at t_n
    double gap;
    bool meets = false;                 ///< the bodies did not press each other anywhere at t_n
    bool at_once = false;               ///< friction is limited by the pressure of now
    Status status = Status::undecided;  ///< or frozen
    Vec3 shear = Vec3::Zero();          ///< of a frozen one that slides
  };
  struct Force {
    Status status = Status::open;
    double pressure = 0.0;
    Vec3 shear = Vec3::Zero(), force = Vec3::Zero();
    Mat3 stiffness = Mat3::Zero();
  };
  Vec3 carried(const Discretisation& d, const Interface& at) const;
  Force force_at(const Touch& t, const Vec3& relative) const;

  std::vector<FieldContact> contacts_;
  std::map<std::pair<std::int64_t, int>, Vec3> carried_;  ///< by node of field a, and field b
  std::vector<Touch> touches_;                            ///< of the step
  bool at_once_ = true, settled_at_once_ = false;
  double kept_closed_ = none_closed;
};

}  // namespace berm
