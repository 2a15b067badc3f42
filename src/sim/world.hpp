#pragma once
/// A case that is ready to run: discretisation, boundary conditions, and where the run is.

#include <memory>

#include "bc/boundary.hpp"
#include "case/case.hpp"
#include "method/discretisation.hpp"
#include "sim/body_parts.hpp"

namespace berm {

struct BodySummary {
  std::string name;
  bool rigid = false;
  double measure = 0.0, mass = 0.0;  ///< [m2] or [m3], [kg]
  int points = 0, elements = 0;
};

struct World {
  Case spec;
  Comm comm;
  std::unique_ptr<Discretisation> discretisation;
  std::unique_ptr<BoundaryConditions> boundary;
  std::vector<BodySummary> bodies;
  std::vector<std::string> warnings;    ///< of the model
  std::vector<std::string> thin_parts;  ///< of bodies: too few cells through them to bend as they should

  // the state at t_n besides what the points carry
  double time = 0.0;           ///< [s]
  std::size_t stage = 0;       ///< of the case
  double load_factor = 0.0;    ///< gauge: of the pressures; else the share of the time that has passed
  double elastic_scale = 0.0;  ///< E h t of the stiffest material: a force that means nothing below 1e-10 of it [N]

  const Stage& present_stage() const { return spec.stages[stage]; }
  bool step_begun = false;     ///< begin_step has been called for the state at t_n

  std::string file_contents;  ///< of the files that the case names, as numbers (case/differences)
  Neighbours neighbours;      ///< of deformable bodies at the start
  std::vector<int> layers;    ///< of the grid's nodes, by body; mpm
  std::vector<BodyParts> parts;  ///< at the start, by body

  /// Points and anchors find cells and processes; connectivity and prescribed unknowns of the coming step. Collective.
  void begin_step();
  /// Of all processes [J]. Collective.
  double kinetic_energy() const { return comm.sum(discretisation->kinetic_energy(present_stage().dynamics)); }
  /// Points of all processes. Collective.
  long n_points() const { return comm.sum(long(discretisation->material.size())); }
};

/// What the cells of [grid] take, used or not [bytes].
double grid_bytes(const Case& c);
/// Of the cells: some are much longer than they are wide [m].
double longest_edge(const Mesh& mesh);

/// Builds everything that the case describes. Throws InputError, the same on all processes.
std::unique_ptr<World> build_world(Case spec, const Comm& comm = {});

/// What `berm check` prints: bodies, masses, points per cell, dofs, memory, what supports and loads hold, warnings. Collective.
std::string describe(const World& world);

}  // namespace berm
