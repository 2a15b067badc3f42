/// The stages of a run and how the time of each is cut into increments.

#include "case/tables.hpp"

namespace berm {
namespace {

/// The keys of Steps in a table of something that has them; get: T& -> Steps&.
template <class T, class Get>
void add_steps(Table<T>& t, Get get) {
  const auto of = [=](auto member) { return [=](T & x) -> auto& { return get(x).*member; }; };
  t.choice("analysis", of(&Steps::analysis),
           Words<Analysis>{{"quasi_static", Analysis::quasi_static}, {"dynamic", Analysis::dynamic}},
           "equilibrium of forces, or motion with inertia");
  t.number("duration", of(&Steps::duration), Unit::time, Range{1e-100, 1e100}, "how long it takes");
  t.integer("count", of(&Steps::count), {1.0}, "increments when none is cut");
  t.boolean("adaptive", of(&Steps::adaptive), "steps shrink where they must and grow again where they can");
  t.number("min_fraction", of(&Steps::min_fraction), Unit::none, {0.0, 1.0, true, false},
           "smallest step, as a fraction of duration/count");
  t.number("max_fraction", of(&Steps::max_fraction), Unit::none, positive(),
           "largest step, as a fraction of duration/count");
  t.number("error_tolerance", of(&Steps::error_tolerance), Unit::none, positive(),
           "impl_ex: largest error of a stress by the extrapolated damage, over the strength; steps with more are cut");
  t.integer("easy_iterations", of(&Steps::easy_iterations), {1.0},
            "implicit: steps grow after fewer iterations than this");
  t.check([=](Scope& s, T& x) {
    if (get(x).max_fraction < get(x).min_fraction)
      s.error("max_fraction", "must not be smaller than \"min_fraction\"");
  });
}

const Table<Stage>& stage_table() {
  static const Table<Stage> table = [] {
    Table<Stage> t(
        "Stages of the run, in the order of the file, in place of [steps]: each with an analysis of its own; the state is "
        "carried over. The time t of loads and motions runs through all of them.");
    add_steps(t, [](Stage& s) -> Steps& { return s.steps; });
    t.boolean("reset_displacements", &Stage::reset_displacements,
              "displacements of material points count from the beginning of this stage; strains and stresses stay");
    t.table("solver", &Stage::solver, solver_table());
    t.table("dynamics", &Stage::dynamics, dynamics_table());
    return t;
  }();
  return table;
}

/// What a stage does not say of its solver is as in [solver] of the whole run; but for keys that belong to another one that
/// it does say.
void inherit(Scope& root, Node& stage, const char* key) {
  const Node::Entry* common = root.node.find(key);
  if (!common || !common->value.is_object()) return;
  Node::Entry* own = stage.find(key);
  if (!own) {
    stage.set(key, common->value);
    return;
  }
  if (!own->value.is_object()) return;  // reported where it is read
  const auto belongs_to = [](const std::string& name) -> std::string_view {
    return name == "alpha" ? "integrator" : name == "flip_fraction" || name == "projection_order" ? "transfer" : "";
  };
  std::vector<Node::Entry> missing;
  for (const Node::Entry& entry : common->value.object())
    if (!own->value.find(entry.key) && !own->value.find(belongs_to(entry.key))) missing.push_back(entry);
  for (Node::Entry& entry : missing) own->value.set(entry.key, std::move(entry.value));
}

}  // namespace

Table<Steps> steps_table() {
  Table<Steps> t("How the time of a run with a single stage is cut into increments.");
  add_steps(t, [](Steps& s) -> Steps& { return s; });
  return t;
}

KeyInfo stage_info() { return table_info("stage", stage_table().doc(), stage_table().keys(), true); }

void read_stages(Scope& root, Node::Entry& entry, Case& c) {
  auto all = root.child(entry);
  if (!all) return;
  if (all->node.object().empty()) root.error("stage", "has no stage: give each a name, [stage.NAME]");
  for (Node::Entry& one : all->node.object()) {
    if (!one.value.is_object()) {
      all->error(one.key, "must be a table: stages have names, [stage.NAME]");
      continue;
    }
    report_bad_name(*all, one);
    auto scope = all->child(one);
    if (!scope) continue;
    for (const char* key : {"solver", "dynamics"}) inherit(root, scope->node, key);
    Stage& stage = c.stages.emplace_back();
    stage.name = one.key;
    stage_table().read(*scope, stage);
  }
}

}  // namespace berm
