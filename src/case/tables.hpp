#pragma once
/// The tables of the case file, by topic; case_table() is the whole of it.

#include "case/case.hpp"
#include "case/table.hpp"

namespace berm {

// shape_table.cpp
KeyInfo shape_info();
Node shape_schema();
void read_shape(Scope& scope, Node::Entry& entry, Body& body);

// material_table.cpp
std::vector<KeyInfo> material_keys();
std::string material_doc();
/// Reads [material.NAME]; which keys there are depends on `law`.
void read_material(Scope& scope, Material& material);

// body_table.cpp
Table<Body> body_table();

// load_table.cpp
Table<NodeBoundary> boundary_table();
Table<Pin> pin_table();
Table<Pressure> pressure_table();
Table<Absorbing> absorbing_table();
Table<Contact> contact_table();

// run_table.cpp
Table<Control> control_table();
Table<Solver> solver_table();
Table<Dynamics> dynamics_table();
// stage_table.cpp
Table<Steps> steps_table();
KeyInfo stage_info();
/// Reads [stage.NAME] of all names, in the order of the file. Before [solver] and [dynamics] are read, so that stages inherit
/// what is written there and no defaults.
void read_stages(Scope& root, Node::Entry& entry, Case& c);

// reference_table.cpp
KeyInfo references_info();
/// Reads output.references, and the curves: those that cannot be drawn are errors, files that are not there warnings.
std::vector<ReferenceCurve> read_references(Scope& scope, Node::Entry& entry);

// run_table.cpp
Table<Output> output_table();
Table<Checkpoint> checkpoint_table();
Table<Parallel> parallel_table();
Table<Gauge> gauge_table();
Table<Probe> probe_table();

// case_table.cpp
/// Reports a [model] dimension other than 2 and 3. Nothing else can be judged before it is right.
void check_dimension(const Scope& root);
const Table<Case>& case_table();

// check_case.cpp
/// What no single table can see: names that refer to other tables, what the method needs, what the user lets the case do.
void check_case(const Case& c, Node& root, Problems& problems, bool allow_petsc_files);

}  // namespace berm
