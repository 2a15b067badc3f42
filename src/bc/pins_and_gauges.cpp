#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"

namespace berm {

void BoundaryConditions::read_pins_and_gauges(const Case& c, const Discretisation& d) {
  for (const Pin& spec : c.pins) {
    PinPoint pin;
    const int body = body_index(c, spec.body);
    pin.anchor = anchor_at(body, spec.at);
    pin.id = pin.pin = static_cast<int>(pins_.size());
    for (int i = 0; i < dimension_; ++i)
      if (spec.fixed[i]) pin.stiffness[i] = stiffness_of(c, body) * (is_plane(c.space) ? c.thickness : d.cell_size());
    pins_.push_back(pin);
  }
  std::map<int, Region> regions;
  for (const Gauge& spec : c.output.gauges) {
    GaugeLine g;
    g.name = spec.name;
    g.from = anchor_at(-1, spec.from);
    g.to = anchor_at(-1, spec.to);
    g.direction = (spec.to - spec.from).normalized();
    // Each end belongs to the deformable body that holds it, or else to the first one.
    for (Anchor* a : {&g.from, &g.to})
      for (std::size_t b = 0; b < c.bodies.size(); ++b) {
        if (c.bodies[b].rigid) continue;
        if (a->body < 0) a->body = static_cast<int>(b);
        if (!c.bodies[b].shape) continue;
        const int index = static_cast<int>(b);
        if (regions.try_emplace(index, *c.bodies[b].shape, cell_size_).first->second.contains(a->X)) {
          a->body = index;
          break;
        }
      }
    gauges_.push_back(g);
  }
}

void BoundaryConditions::share_gauges() {
  std::vector<double> values;
  for (const GaugeLine& g : gauges_)
    for (const auto& [anchor, here] : {std::pair(&g.from, g.from_here), std::pair(&g.to, g.to_here)})
      for (const Vec3* v : {&anchor->x, &anchor->u})
        for (int i = 0; i < 3; ++i) values.push_back(here ? (*v)[i] : 0.0);
  comm_.sum(values);
  const double* value = values.data();
  for (GaugeLine& g : gauges_)
    for (Anchor* a : {&g.from, &g.to})
      for (Vec3* v : {&a->x, &a->u}) {
        *v = Vec3(value[0], value[1], value[2]);
        value += 3;
      }
}

void BoundaryConditions::add_gauge_functional(int gauge, NodalVector& functional) const {
  const GaugeLine& g = gauges_[gauge];
  const auto add = [&](const Stencil& s, double sign) {
    for (int k = 0; k < s.n; ++k) functional[s.node[k]] += sign * s.N[k] * g.direction;
  };
  if (g.to_here) add(*g.to.stencil, 1.0);
  if (g.from_here) add(*g.from.stencil, -1.0);
}

}  // namespace berm
