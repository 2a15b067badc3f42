#pragma once
/// What can be seen to be wrong before a run: bodies in one place, gaps that the grid does not see, bodies that nothing holds.

#include "bc/surface.hpp"
#include "sim/world.hpp"
#include "transfer/mpm.hpp"

namespace berm {

/// The bodies as they were built, before their points and surfaces are dealt out to the processes.
struct BuiltBodies {
  std::vector<SurfacePoint> surface;         ///< of all deformable bodies
  std::vector<std::vector<Vec3>> places;     ///< by body of the case: of points or elements
  std::vector<std::vector<double>> measures; ///< their areas [m2] or volumes [m3]
};

/// Throws InputError if two deformable bodies, or a deformable and a rigid one that touch by contact, fill the same place.
/// `size`: of the cells.
void refuse_overlaps(const Case& c, const BuiltBodies& built, double size);

/// Throws InputError if the grid's functions join the two sides of a gap in a body, or between bodies without a contact;
/// a warning in its place if the case allows it.
void refuse_glued_gaps(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface);

/// Warns of quadrilateral cells that are much longer than wide where a law with a crack band takes one length for both.
void warn_of_flat_cells(World& w);

/// Warns of deformable bodies that have nothing to do with each other: no joint, no contact.
void warn_of_strangers(World& w);

/// Warns of bodies that nothing joins but the functions of the grid where they touch at a corner.
void warn_of_corners(World& w);

/// Of a world whose first step has begun: the same for bodies that hang on held nodes beside them. Collective.
void refuse_hanging_bodies(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface);

/// Warns of boundaries whose nodes are not those on which the surface in their region lies.
void warn_of_loose_supports(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface);

/// Parts of a body whose elements have no place of a node in common; a seam is told, and parts nothing.
BodyParts parts_of_mesh(const Mesh& mesh);

/// Notes parts of bodies with so few linear cells through their thickness that they would be too stiff in bending. Collective.
void note_thin_parts(World& w, const std::vector<SurfacePoint>& surface);

/// Warns of what is out of proportion, so that a unit seems wrong: weights and pressures to a stiffness, motions to the bodies. Notes
/// bodies that are smaller than a cell.
void warn_of_proportions(World& w, const BuiltBodies& built);

/// Warns of pressures on surfaces along which bodies are joined.
void warn_of_loaded_joints(World& w, const std::vector<SurfacePoint>& surface);

/// Warns of places where nodes of a body's mesh lie in one another: elements are not joined there.
void tell_seams(World& w, const std::string& body, const Mesh& mesh);

/// Throws InputError if a body can move without any resistance in a quasi-static stage, has fewer points than B-splines need, or
/// if a dynamic first stage begins with a jump of a support, or if its weight draws it from all that could carry it. Warns of
/// surfaces that begin inside of rigid bodies. Collective.
void refuse_free_bodies(World& w);

}  // namespace berm
