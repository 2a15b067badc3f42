/// Absorbing boundaries.
#include <fmt/format.h>

#include "base/findings.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"

namespace berm {

void BoundaryConditions::read_absorbing(const Case& c, const std::vector<SurfacePoint>& surface) {
  Findings found;
  std::vector<std::vector<SurfacePart>> parts(c.absorbing.size());
  for (std::size_t k = 0; k < c.absorbing.size(); ++k) {
    const Absorbing& spec = c.absorbing[k];
    const int body = body_index(c, spec.body);
    found.look([&] {
      parts[k] = caught_surface("absorbing." + spec.name, spec.where, body, spec.body, surface, dimension_);
      for (std::size_t j = 0; j < k; ++j)
        if (share_a_stage(c.absorbing[j].stages, spec.stages) && overlap(parts[j], parts[k]))
          throw InputError(fmt::format("[absorbing.{}] and [absorbing.{}] act on the same part of the surface of \"{}\", where "
                                       "their dashpots would add up: make their regions disjoint",
                                       c.absorbing[j].name, spec.name, spec.body));
    });
    for (const auto& [s, share] : parts[k]) {
      const Mat3 nn = s.normal * s.normal.transpose();
      DashpotPoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(dashpots_.size());
      point.absorbing = static_cast<int>(k);
      point.damping =
          share * s.area * spec.density * (spec.p_wave_speed * nn + spec.s_wave_speed * (Mat3::Identity() - nn));
      dashpots_.push_back(point);
    }
  }
  found.throw_if_any();
}

/// t = -rho (c_p n n + c_s (1 - n n)) v   [boundaries (13)]
void BoundaryConditions::add_dashpots(const NodalVector& v, double dv_by_du, NodalVector& f,
                                      BlockAssembler* matrix) const {
  for (const DashpotPoint& p : dashpots_) {
    if (!acts(case_.absorbing[p.absorbing].stages)) continue;
    add_at(p.anchor, -p.damping * p.anchor.stencil->interpolate(v), dv_by_du * p.damping, f, matrix);
  }
}

}  // namespace berm
