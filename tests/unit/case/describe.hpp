#pragma once
/// All that a case says, as text with full precision: two cases are the same if their descriptions are.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "case/case.hpp"

namespace berm {

inline std::string describe(const Vec2& v) { return fmt::format("({}, {})", v.x(), v.y()); }
inline std::string describe(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }
inline std::string describe(double x) { return fmt::format("{}", x); }
inline std::string describe(const std::string& text) { return text; }
inline std::string describe(const TimeFunction& f) {
  return f.is_number() ? fmt::format("{}", f.number()) : f.text();
}
inline std::string describe(const VectorFunction& v) {
  return fmt::format("({}, {}, {})", describe(v.component[0]), describe(v.component[1]), describe(v.component[2]));
}
template <class T>
std::string describe(const std::optional<T>& value) {
  return value ? describe(*value) : "-";
}

inline std::string describe(const PlaneShape& shape) {
  if (const auto* box = std::get_if<Box>(&shape.form)) return "box " + describe(box->min) + describe(box->max);
  if (const auto* disc = std::get_if<Disc>(&shape.form))
    return "disc " + describe(disc->centre) + describe(disc->radius);
  std::string text = "polygon";
  if (const auto* polygon = std::get_if<Polygon>(&shape.form)) {
    for (const Vec2& vertex : polygon->vertices) text += describe(vertex);
    return text;
  }
  const auto& combination = std::get<Combination>(shape.form);
  text = combination.kind == Combination::Kind::join ? "union{" : "difference{";
  for (const PlaneShape& part : combination.parts) text += describe(part) + ";";
  return text + "}";
}

inline std::string describe(const SolidShape& shape) {
  if (const auto* box = std::get_if<SolidBox>(&shape.form)) return "box " + describe(box->min) + describe(box->max);
  if (const auto* c = std::get_if<Cylinder>(&shape.form))
    return "cylinder " + describe(c->from) + describe(c->to) + describe(c->radius);
  if (const auto* s = std::get_if<Sphere>(&shape.form)) return "sphere " + describe(s->centre) + describe(s->radius);
  if (const auto* file = std::get_if<SurfaceFile>(&shape.form)) return "surface " + file->path;
  std::string text = "extrusion";
  if (const auto* extrusion = std::get_if<Extrusion>(&shape.form)) {
    for (const Vec2& vertex : extrusion->vertices) text += describe(vertex);
    return text + fmt::format("{} {}", extrusion->from, extrusion->to);
  }
  const auto& combination = std::get<SolidCombination>(shape.form);
  text = combination.kind == SolidCombination::Kind::join ? "union{" : "difference{";
  for (const SolidShape& part : combination.parts) text += describe(part) + ";";
  return text + "}";
}

inline std::string describe(const Shape& shape) {
  return std::visit([](const auto& form) { return describe(form); }, shape);
}

inline std::string describe(const BodyMeshOptions& m) {
  return fmt::format("mesh {} {} {} {}", int(m.kind), m.size, m.order, m.structured);
}

inline std::string describe(const Where& w) {
  std::string text = "where " + describe(w.min) + describe(w.max) + describe(w.group);
  if (w.sector) text += describe(w.sector->centre) + fmt::format("{} {}", w.sector->from, w.sector->to);
  return text;
}

inline std::string describe(const Material& m) {
  std::string text = fmt::format("material {} {} {} {}", m.name, m.density, int(m.crack_band), m.crack_band_length);
  std::visit(
      [&]<class L>(const L& law) {
        text += std::string(" ") + std::string(L::name);
        for (const auto& p : L::parameters()) text += fmt::format(" {}={}", p.key, law.*(p.member));
      },
      m.law);
  return text;
}

inline std::string describe(const Body& b) {
  return fmt::format("body {} {} {} shape {} file {} {} points {} {} {} {} {} {} displacement {}", b.name, b.rigid,
                     b.material, describe(b.shape), b.mesh_file, b.mesh_group, int(b.points.kind),
                     b.points.per_direction, int(b.points.placement), b.points.per_element, describe(b.points.mesh),
                     describe(b.mesh), describe(b.displacement));
}

inline std::string describe_grid(const Case& c) {
  if (const auto* file = std::get_if<std::string>(&c.grid)) return "grid " + *file;
  const auto& g = std::get<StructuredGrid>(c.grid);
  return fmt::format("grid {} {} {} {} {} {} {}", int(g.kind), describe(g.origin), describe(g.cell_size), g.nx, g.ny,
                     g.nz, g.angle);
}

inline std::string describe_run(const Case& c) {
  const Steps& t = c.steps;
  const Solver& s = c.solver;
  const Nominal& n = c.output.nominal;
  std::string references;
  for (const ReferenceCurve& r : c.output.references)
    references += fmt::format(" {} {} {} {} {}", r.file, r.x, r.y, r.delimiter, r.label);
  return fmt::format(
      "control {} {} {}\nsteps {} {} {} {} {} {}\nsolver {} {} {} {} {} {} {} {} {} {}\noutput {} {} {}\n"
      "nominal {} {} {} {} {}\ncheckpoint {} {}\nparallel {}\n",
      int(c.control.kind), c.control.gauge, c.control.target, t.count, t.adaptive, t.min_fraction, t.max_fraction,
      t.error_tolerance, t.easy_iterations, int(s.integration), int(s.snap_back), s.relative_tolerance,
      s.absolute_tolerance, s.max_iterations, s.line_search, s.ghost_penalty.value_or(-1.0), int(s.linear), s.linear_tolerance,
      s.petsc, c.output.vtk_every, c.output.frames, references, fmt::join(n.load, " "), n.displacement,
      describe(n.direction), n.area, n.length, c.checkpoint.every_steps, c.checkpoint.every_minutes,
      c.parallel.rebalance);
}

inline std::string describe(const Case& c) {
  std::string text = fmt::format("{} {} {} {} {} {}\n", c.title, int(c.method), int(c.space), int(c.kinematics),
                                 c.thickness, describe(c.gravity));
  text += describe_grid(c) + "\n" + describe_run(c);
  for (const auto& m : c.materials) text += describe(m) + "\n";
  for (const auto& b : c.bodies) text += describe(b) + "\n";
  for (const auto& b : c.boundaries)
    text += fmt::format("boundary {} {} {} {} {}\n", b.name, describe(b.where), describe(b.u[0]), describe(b.u[1]),
                        describe(b.u[2]));
  for (const auto& p : c.pins)
    text += fmt::format("pin {} {} {} {}\n", p.name, p.body, describe(p.at), fmt::join(p.fixed, " "));
  for (const auto& p : c.pressures)
    text += fmt::format("pressure {} {} {} {}\n", p.name, p.body, describe(p.where), describe(p.value));
  for (const auto& k : c.contacts)
    text += fmt::format("contact {} {} {} {} {}\n", k.name, k.body, k.rigid, int(k.kind), k.stiffness);
  for (const auto& g : c.output.gauges)
    text += fmt::format("gauge {} {} {}\n", g.name, describe(g.from), describe(g.to));
  for (const auto& p : c.output.probes)
    text += fmt::format("probe {} {} {}\n", p.name, describe(p.at), int(p.quantity));
  return text;
}

}  // namespace berm
