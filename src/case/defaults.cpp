#include "case/defaults.hpp"

#include <fmt/format.h>

#include "bc/case_lookup.hpp"
#include "law/kinds.hpp"

namespace berm {
namespace {

/// Elastic bodies with a Poisson ratio above this lock as those do that flow without change of volume.
constexpr double nearly_incompressible = 0.45;

struct Choice {
  const char* value;
  const char* why;
};

bool is_given(const Node& root, const char* table, const char* key) {
  const Node::Entry* entry = root.find(table);
  return entry && entry->value.find(key);
}

/// Writes a choice into the tree of the case and remembers it for `check` and the log.
void write(Case& c, Node& root, const char* table, const char* key, const Choice& choice) {
  Node::Entry* entry = root.find(table);
  Node& node = entry ? entry->value : root.set(table, Node());
  node.set(key, Node(std::string(choice.value)));
  c.choices.push_back(fmt::format("{}.{} = \"{}\": {}", table, key, choice.value, choice.why));
}

bool all_damage(const Case& c) {
  return !c.materials.empty() && !any_law(c, [](const AnyLaw& law) { return !is_damage(law); });
}

bool has_boxes(const Case& c) {
  const auto* grid = std::get_if<StructuredGrid>(&c.grid);
  return grid && (grid->kind == GridKind::quads || grid->kind == GridKind::hexahedra);
}

/// Laws that flow while their volume stays, or is bound to the shear, and bodies that are nearly incompressible.
bool locks(const Case& c) {
  return any_law(c, [](const AnyLaw& law) {
    const auto lame = elastic_constants(law);
    return is_plastic(law) || (lame && lame->lambda / (2.0 * (lame->lambda + lame->mu)) >= nearly_incompressible);
  });
}

bool has_fluid(const Case& c) {
  return any_law(c, [](const AnyLaw& law) { return std::holds_alternative<Newtonian>(law); });
}

void choose_formulation(Case& c, Node& root) {
  if (c.kinematics == Kinematics::small || is_given(root, "model", "formulation")) return;
  if (c.is_dynamic() || meets_deformable_bodies(c)) return;
  const bool mixed = c.volumetric == Volumetric::mixed && !any_law(c, is_soil);
  if (!mixed && !all_damage(c)) return;
  c.formulation = Formulation::total_lagrangian;
  write(c, root, "model", "formulation",
        {"total_lagrangian", mixed ? "the mixed formulation goes with linear functions, which lose stress where points cross cells"
                                   : "specimens of brittle laws crack but hardly move: no point crosses a cell"});
}

void choose_functions(Case& c, Node& root) {
  const bool moves = moves_through_grid(c);
  if (is_given(root, "grid", "shape_functions")) {
    if (c.shape_functions != ShapeFunctions::linear) return;
    if (has_points_of_files(c))
      c.choices.push_back("grid.shape_functions = \"linear\", as the case says: points of a mesh file weigh unevenly in the cells (a block under pressure is up to a "
                          "fifth too soft); without the key their domains fill the cells");
    if (moves)
      c.choices.push_back("grid.shape_functions = \"linear\", as the case says: points that cross cells lose stress and "
                          "energy (a block squeezed by 10 % carries two thirds of its load); without the key they do not");
    return;
  }
  const bool fits = c.quadrature == Quadrature::points && c.volumetric != Volumetric::mixed && !has_gauss_points(c);
  if (!moves && !(fits && has_points_of_files(c))) return write(c, root, "grid", "shape_functions", {"linear", "no point crosses a cell"});
  if (!fits)
    return write(c, root, "grid", "shape_functions", {"linear", "what else the case asks for goes with no other ones"});
  const bool soil = any_law(c, is_soil);
  if (!has_boxes(c)) {
    c.shape_functions = ShapeFunctions::cpdi;
    write(c, root, "grid", "shape_functions",
          {"cpdi", moves ? "points move through the grid, which is not of boxes" : "points of a mesh file lie anywhere in the cells, which are no boxes"});
  } else if (moves && soil && !has_fluid(c)) {  // water with ugimp runs through the floor of the grid
    c.shape_functions = ShapeFunctions::ugimp;
    write(c, root, "grid", "shape_functions",
          {"ugimp", "points move through the grid and far past each other: their domains keep their size"});
  } else {
    c.shape_functions = ShapeFunctions::cpgimp;
    write(c, root, "grid", "shape_functions",
          {"cpgimp", moves ? "points move through the grid: their domains cross the lines of the cells smoothly"
                           : "points of a mesh file lie anywhere in the cells: their domains fill them"});
  }
}

void choose_volumetric(Case& c, Node& root) {
  const bool fits = has_boxes(c) && c.space != Space::plane_stress && c.quadrature == Quadrature::points;
  if (c.space == Space::plane_stress || has_fluid(c) || !locks(c)) return;  // a fluid has nothing against hourglass modes
  if (is_given(root, "model", "volumetric") || !fits) {
    if (c.volumetric == Volumetric::standard)
      c.choices.push_back(fmt::format("model.volumetric = \"standard\"{}: cells lock where a law flows without change of volume: too stiff, and failure "
                                      "loads too high (a vertical cut in clay by a quarter); f_bar{} does not",
                                      is_given(root, "model", "volumetric") ? ", as the case says" : "",
                                      fits ? "" : ", on a grid of quads or hexahedra with quadrature = \"points\","));
    return;
  }
  c.volumetric = Volumetric::f_bar;
  write(c, root, "model", "volumetric",
        {"f_bar", "a law flows without change of volume, or nearly so, and would lock"});
}

void tell_locking_elements(Case& c) {
  if (c.space == Space::plane_stress || !locks(c)) return;
  for (const Body& b : c.bodies)
    if (!b.rigid && b.shape && b.mesh.order == 1)
      c.choices.push_back(fmt::format("body.{0}.mesh.order = 1: linear elements lock where a law flows without change of volume: too stiff, and failure loads "
                                      "too high; order = 2 does not", b.name));
}

bool all_elastic_or_fluid(const Case& c) {
  return !any_law(c, [](const AnyLaw& law) {
    return !std::holds_alternative<LinearElastic>(law) && !std::holds_alternative<NeoHookean>(law) &&
           !std::holds_alternative<Newtonian>(law);
  });
}

/// Velocities can be fitted with the consistent mass where points carry nothing else. Soil that flows takes several times as
/// many iterations with it, and keeps noise.   [dynamics (20)]
void choose_mass(Case& c, Node& root) {
  for (Stage& s : c.stages) {
    if (s.steps.analysis != Analysis::dynamic) continue;
    Node* at = &root;
    if (!s.name.empty()) at = &root.find("stage")->value.find(s.name)->value;
    Node::Entry* entry = at->find("dynamics");
    if (entry && entry->value.find("mass")) continue;
    const bool fits = all_elastic_or_fluid(c) && s.dynamics.transfer != Dynamics::Transfer::apic &&
                      s.dynamics.integrator == Dynamics::Integrator::newmark && s.dynamics.projection_order == 1;
    s.dynamics.mass = fits ? Dynamics::Mass::consistent : Dynamics::Mass::lumped;
    Node& node = entry ? entry->value : at->set("dynamics", Node());
    node.set("mass", Node(std::string(fits ? "consistent" : "lumped")));
    if (fits)
      c.choices.push_back(fmt::format("dynamics.mass = \"consistent\"{}: nothing of the motion is lost between points and grid",
                                      s.name.empty() ? "" : " in stage " + s.name));
  }
}

/// Forces between deformable bodies act at nodes. In equilibrium a penalty of ten cells' stiffness costs nothing; in motion it
/// makes bodies chatter, and what slides loses a part of its friction.
void choose_contact(Case& c, Node& root) {
  for (Contact& contact : c.contacts) {
    if (contact.other.empty() || contact.kind == Contact::Kind::tie) continue;
    Node& node = root.find("contact")->value.find(contact.name)->value;
    if (node.find("stiffness")) continue;
    const bool moves = std::any_of(c.stages.begin(), c.stages.end(), [&](const Stage& s) {
      return s.steps.analysis == Analysis::dynamic && acts_in(contact.stages, s.name);
    });
    contact.stiffness = moves ? 1.0 : 10.0;
    node.set("stiffness", Node(contact.stiffness));
    c.choices.push_back(fmt::format("contact.{}.stiffness = {:g}: {}", contact.name, contact.stiffness,
                                    moves ? "stiffer contact chatters in motion" : "as stiff as ten cells"));
  }
}

}  // namespace

void choose_defaults(Case& c, Node& root) {
  if (c.method == Method::fem) tell_locking_elements(c);
  if (c.method != Method::mpm || !root.find("grid")) return;  // check_case says what is missing
  choose_formulation(c, root);
  choose_volumetric(c, root);
  choose_functions(c, root);
  choose_mass(c, root);
  choose_contact(c, root);
}

}  // namespace berm
