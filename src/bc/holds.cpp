/// What holds the bodies, and what no longer does.
#include <fmt/format.h>

#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"

namespace berm {

std::vector<BoundaryConditions::Hold> BoundaryConditions::holds(const Discretisation& d) const {
  std::vector<Hold> all;
  const auto along_axes = [&](Hold hold, const auto& held) {
    for (int i = 0; i < dimension_; ++i)
      if (held(i)) {
        hold.direction = Vec3::Unit(i);
        all.push_back(hold);
      }
  };
  for (const auto& [k, node] : local_conditions_)
    if (node < d.halo.n_owned)
      all.push_back({-1, node, conditions_[k].boundary, conditions_[k].at, Vec3::Unit(conditions_[k].component)});
  for (int node = 0; node < d.halo.n_owned; ++node)
    if (moved_by_[node] >= 0) along_axes({-1, node, -1, d.nodes[node], Vec3::Zero()}, [](int) { return true; });
  for (const LocalInclined& local : local_inclined_)
    if (local.node < d.halo.n_owned) {
      const int boundary = inclined_[local.index].boundary;
      all.push_back({-1, local.node, boundary, d.nodes[local.node], *case_.boundaries[boundary].normal});
    }
  for (const HeldPoint& p : held_) {
    if (!acts(case_.boundaries[p.boundary].stages)) continue;
    if (p.slides)
      all.push_back({p.anchor.body, -1, p.boundary, p.anchor.X, p.normal});
    else
      along_axes({p.anchor.body, -1, p.boundary, p.anchor.X, Vec3::Zero()},
                 [&](int i) { return case_.boundaries[p.boundary].u[i].has_value(); });
  }
  for (const PinPoint& p : pins_)
    if (acts(case_.pins[p.pin].stages))
      along_axes({p.anchor.body, -1, -1, p.anchor.X, Vec3::Zero()}, [&](int i) { return p.stiffness[i] > 0.0; });
  for (const ContactPoint& p : contacts_) {
    const Contact& contact = case_.contacts[p.contact];
    if (!acts(contact.stages)) continue;
    Hold hold{p.anchor.body, -1, -1, p.anchor.X, p.normal};
    if (contact.kind != Contact::Kind::tie) hold.contact = p.contact, hold.gap = p.gap, hold.push = p.normal, hold.inward = p.anchor.inward;
    if (contact.kind == Contact::Kind::frictionless)
      all.push_back(hold);
    else
      along_axes(hold, [](int) { return true; });
  }
  return all;
}

std::map<int, double> BoundaryConditions::tied_apart() const {
  std::vector<double> apart(case_.contacts.size(), 0.0);
  const auto look = [&](int contact, const Vec3& normal, const Vec3& relative) {
    if (contact >= 0) apart[contact] = std::max(apart[contact], normal.isZero(0.0) ? relative.norm() : std::abs(normal.dot(relative)));
  };
  for (const ContactPoint& p : contacts_)
    if (case_.contacts[p.contact].kind == Contact::Kind::tie) look(p.contact, p.anchor.inward, p.anchor.u - rigid_offset_[rigid_of_contact_[p.contact]]);
  for (const TiePoint& p : ties_.points()) look(ties_.contact_of(p), p.ends.a.inward, p.ends.b.u - p.ends.a.u);
  std::map<int, double> by_contact;
  for (std::size_t k = 0; k < apart.size(); ++k)
    if (const double most = comm_.max(apart[k]); most > 0.0) by_contact[static_cast<int>(k)] = most;
  return by_contact;
}

std::vector<std::string> BoundaryConditions::slipping() const {
  constexpr double at_the_limit = 0.999, most = 0.9;
  std::vector<double> touching(case_.contacts.size(), 0.0), sliding = touching;
  for (const ContactPoint& p : contacts_) {
    const Contact& contact = case_.contacts[p.contact];
    if (contact.kind != Contact::Kind::friction || !acts(contact.stages) || p.gap >= 0.0) continue;
    touching[p.contact] -= p.stiffness * p.gap;
    if (p.slip.norm() >= at_the_limit * contact.friction * -p.gap) sliding[p.contact] -= p.stiffness * p.gap;
  }
  comm_.sum(touching), comm_.sum(sliding);
  std::vector<std::string> sentences;
  for (std::size_t k = 0; k < touching.size(); ++k)
    if (touching[k] > 0.0 && sliding[k] > most * touching[k])
      sentences.push_back(fmt::format("body \"{}\" slides on \"{}\": the friction of [contact.{}] is used up", case_.contacts[k].body,
                                      case_.contacts[k].rigid, case_.contacts[k].name));
  return sentences;
}

}  // namespace berm
