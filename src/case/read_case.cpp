#include "case/read_case.hpp"

#include "base/error.hpp"
#include "case/load.hpp"
#include "case/tables.hpp"

namespace berm {
namespace {

/// Plain numbers of loads and motions are reached at the end of the run.
void set_ends(Case& c) {
  const double end = c.steps.duration;
  for_each_motion(c, [end](TimeFunction& f) { f.set_end(end); });
  for (Pressure& p : c.pressures) {
    p.value.set_end(end);
    if (p.traction)
      for (TimeFunction& f : p.traction->component) f.set_end(end);
  }
}

}  // namespace

Case read_case(const std::string& path, const std::vector<std::string>& overrides) {
  Problems problems;
  Node root = load_case(path, overrides, problems);
  problems.throw_if_any(path);  // without a tree every key would be missing

  if (root.find("variant"))
    throw InputError(path + ": this is a sweep file, not a case: run it with berm sweep " + path);

  Case c;
  c.file = path;
  Scope scope{problems, root, "", {path, "", 0, 0}};
  check_dimension(scope);
  problems.throw_if_any(path);
  case_table().read(scope, c);
  check_case(c, root, problems);
  problems.throw_if_any(path);
  set_ends(c);

  c.resolved = "# The effective case: base merged, overrides applied, defaults written out.\n" + write_toml(root);
  c.warnings = problems.warnings();
  return c;
}

}  // namespace berm
