#include "case/read_case.hpp"

#include "base/error.hpp"
#include "case/defaults.hpp"
#include "case/doubts.hpp"
#include "case/load.hpp"
#include "case/tables.hpp"

namespace berm {
namespace {

/// One after the other; a case without stages has one.
void line_up_stages(Case& c) {
  if (c.stages.empty()) {
    Stage only;
    only.steps = c.steps;
    only.solver = c.solver;
    only.dynamics = c.dynamics;
    c.stages.push_back(only);
  }
  double time = 0.0;
  for (Stage& s : c.stages) {
    s.begin = time;
    time = s.end();
  }
}

/// Plain numbers are reached at the end of the first stage and held; loads on a body that can fall from the start.
void set_ends(Case& c) {
  const Stage& first = c.stages.front();
  const double end = first.end(), load_end = first.steps.analysis == Analysis::dynamic ? 0.0 : end;
  for_each_motion(c, [end](TimeFunction& f) { f.set_end(end); });
  for (TimeFunction& g : c.gravity.component) g.set_end(load_end);
  for (Body& b : c.bodies) {
    for (TimeFunction& a : b.acceleration.component) a.set_end(load_end);
    for (TimeFunction& v : b.velocity.component) v.set_end(0.0);
  }
  for (Pressure& p : c.pressures) {
    p.value.set_end(load_end);
    if (p.traction)
      for (TimeFunction& f : p.traction->component) f.set_end(load_end);
  }
}

void remember_places(const Node& root, Case& c) {
  for (const Node::Entry& kind : root.object()) {
    if (!kind.value.is_object()) continue;
    for (const Node::Entry& one : kind.value.object())
      if (one.value.is_object()) c.places[kind.key + "." + one.key] = one.place.text();
  }
}

}  // namespace

Case read_case(const std::string& path, const std::vector<std::string>& overrides, const ReadOptions& options) {
  Problems problems;
  Node root = load_case(path, overrides, options.text, problems);
  problems.throw_if_any(path);  // without a tree every key would be missing

  if (root.find("variant"))
    throw InputError(path + ": this is a sweep file, not a case: run it with berm sweep " + path);

  Case c;
  c.file = path;
  Scope scope{problems, root, "", {path, "", 0, 0}};
  check_dimension(scope);
  problems.throw_if_any(path);
  case_table().read(scope, c);
  line_up_stages(c);
  if (problems.empty()) choose_defaults(c, root);  // else the tree may hold anything
  check_case(c, root, problems, options.allow_petsc_files);
  problems.throw_if_any(path);
  doubt_case(c, root, problems);
  set_ends(c);
  check_functions(c, root, problems);
  problems.throw_if_any(path);
  remember_places(root, c);
  if (const Node::Entry* solver = root.find("solver"))
    if (const Node::Entry* petsc = solver->value.find("petsc")) c.petsc_place = petsc->value.place.text();

  c.resolved = "# The effective case: base merged, overrides applied, defaults written out.\n" + write_toml(root);
  c.warnings = problems.warnings();
  return c;
}

}  // namespace berm
