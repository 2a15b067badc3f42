#include "mesh/gmsh_solid.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <Eigen/Geometry>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/error.hpp"
#include "mesh/gmsh_model.hpp"
#include "mesh/shape_rings.hpp"
#include "mesh/solid_region.hpp"

namespace berm {

namespace {

namespace occ = gmsh::model::occ;
using Parts = gmsh::vectorpair;

std::string at(const Vec3& x) { return fmt::format("({:g}, {:g}, {:g})", x.x(), x.y(), x.z()); }

/// Sets options of Gmsh and puts the old values back.
class Options {
public:
  explicit Options(const std::vector<std::pair<std::string, double>>& settings) {
    for (const auto& [name, value] : settings) {
      double old = 0.0;
      gmsh::option::getNumber(name, old);
      old_.emplace_back(name, old);
      gmsh::option::setNumber(name, value);
    }
  }
  ~Options() {
    for (const auto& [name, value] : old_) gmsh::option::setNumber(name, value);
  }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

private:
  std::vector<std::pair<std::string, double>> old_;
};

/// All options that a mesh depends on, since other meshes may have left theirs.
std::vector<std::pair<std::string, double>> settings(double size, int chords, int order) {
  return {
      {"Geometry.OCCUnionUnify", 0},  // keeps the parts of unions known (see gmsh_body.cpp)
      {"Mesh.MeshSizeMin", 0},
      {"Mesh.MeshSizeMax", size},
      {"Mesh.MeshSizeFactor", 1},
      {"Mesh.MeshSizeFromPoints", 0},
      {"Mesh.MeshSizeFromCurvature", chords},
      {"Mesh.MeshSizeExtendFromBoundary", 0},
      {"Mesh.Algorithm", 6},    // frontal Delaunay
      {"Mesh.Algorithm3D", 1},  // Delaunay
      {"Mesh.Optimize", 1},
      {"Mesh.RecombineAll", 0},
      {"Mesh.ElementOrder", order},
      {"Mesh.SecondOrderIncomplete", 0},
      {"Mesh.SecondOrderLinear", 0},
      {"Mesh.HighOrderOptimize", 0},
      {"Mesh.RandomSeed", 1},
  };
}

/// Builds shapes in the OpenCASCADE kernel.
struct Builder {
  Parts operator()(const SolidBox& box) const {
    const Vec3 d = box.max - box.min;
    if (!d.allFinite() || !(d.minCoeff() > 0.0))
      throw InputError(
          fmt::format("shape: the box from {} to {} is empty (min must be below max)", at(box.min), at(box.max)));
    return {{3, occ::addBox(box.min.x(), box.min.y(), box.min.z(), d.x(), d.y(), d.z())}};
  }

  Parts operator()(const Cylinder& c) const {
    const Vec3 axis = c.to - c.from;
    check_radius("cylinder", c.radius);
    if (!axis.allFinite() || !(axis.norm() > 0.0))
      throw InputError(fmt::format("shape: cylinder from {} to {} (the two ends must be apart)", at(c.from), at(c.to)));
    return {{3, occ::addCylinder(c.from.x(), c.from.y(), c.from.z(), axis.x(), axis.y(), axis.z(), c.radius)}};
  }

  Parts operator()(const Sphere& s) const {
    check_radius("sphere", s.radius);
    if (!s.centre.allFinite()) throw InputError("shape: the centre of a sphere is not finite");
    return {{3, occ::addSphere(s.centre.x(), s.centre.y(), s.centre.z(), s.radius)}};
  }

  Parts operator()(const Extrusion& e) const {
    if (!(e.to > e.from) || !std::isfinite(e.to - e.from))
      throw InputError(fmt::format("shape: extrusion from z = {:g} to {:g} m (from must be below to)", e.from, e.to));
    evaluate_shape(PlaneShape{Polygon{e.vertices}}, 8);  // refuses polygons that are flat or cross themselves
    std::vector<int> points, lines;
    for (const Vec2& x : e.vertices) points.push_back(occ::addPoint(x.x(), x.y(), e.from));
    for (std::size_t i = 0; i < points.size(); ++i)
      lines.push_back(occ::addLine(points[i], points[(i + 1) % points.size()]));
    const int base = occ::addPlaneSurface({occ::addCurveLoop(lines)});
    Parts out, solid;
    occ::extrude({{2, base}}, 0.0, 0.0, e.to - e.from, out);
    for (const auto& part : out)
      if (part.first == 3) solid.push_back(part);
    return solid;
  }

  Parts operator()(const SurfaceFile& file) const {
    throw InputError(
        fmt::format("{}: an STL surface cannot be united with or cut by other shapes (do that in the program "
                    "that made it, or use the surface alone)",
                    file.path));
  }

  Parts operator()(const SolidCombination& combination) const {
    if (combination.parts.empty()) throw InputError("shape: a combination without parts");
    const bool join = combination.kind == SolidCombination::Kind::join;
    Parts result = std::visit(*this, combination.parts.front().form);
    for (std::size_t i = 1; i < combination.parts.size(); ++i) {
      const Parts other = std::visit(*this, combination.parts[i].form);
      Parts out;
      std::vector<Parts> map;
      if (join)
        occ::fuse(result, other, out, map);
      else
        occ::cut(result, other, out, map);
      result.clear();
      for (const auto& part : out)
        if (part.first == 3) result.push_back(part);
      if (result.empty()) throw InputError("shape: nothing is left of it (the parts taken away cover it)");
    }
    return result;
  }

  static void check_radius(const char* what, double radius) {
    if (!(radius > 0.0) || !std::isfinite(radius))
      throw InputError(fmt::format("shape: {} of radius {:g} m (it must be positive)", what, radius));
  }
};

struct Measures {
  double volume = 0.0, area = 0.0;
  bool only_planes = true;
};

bool is_plane(int face) {
  std::string type;
  gmsh::model::getType(2, face, type);
  return type == "Plane";
}

/// Builds the shape as the current model.
Measures build(const SolidShape& shape) {
  gmsh::model::add("solid");
  std::visit(Builder{}, shape.form);
  occ::synchronize();
  Measures measures;
  Parts solids, faces;
  gmsh::model::getEntities(solids, 3);
  gmsh::model::getEntities(faces, 2);
  double value = 0.0;
  for (const auto& [dim, tag] : solids) {
    occ::getMass(dim, tag, value);
    measures.volume += value;
  }
  for (const auto& [dim, tag] : faces) {
    occ::getMass(dim, tag, value);
    measures.area += value;
    measures.only_planes = measures.only_planes && is_plane(tag);
  }
  if (!(measures.volume > 0.0)) throw InputError("shape: nothing is left of it (its volume is zero)");
  return measures;
}

void check_size(double size, double count, const char* what) {
  if (!(size > 0.0)) throw InputError(fmt::format("solid: size {:g} m (it must be positive)", size));
  if (count > 5e6)
    throw InputError(fmt::format("solid: size {:g} m gives too many {} (more than five million)", size, what));
}

/// Nodes of the current mesh in the order of their tags.
struct Nodes {
  std::vector<Vec3> positions;
  std::unordered_map<std::size_t, int> number;
};

Nodes current_nodes() {
  std::vector<std::size_t> tags;
  std::vector<double> x, parameters;
  gmsh::model::mesh::getNodes(tags, x, parameters, -1, -1, false, false);
  std::vector<std::size_t> order(tags.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return tags[a] < tags[b]; });
  Nodes nodes;
  for (std::size_t i : order)
    if (nodes.number.emplace(tags[i], static_cast<int>(nodes.positions.size())).second)
      nodes.positions.emplace_back(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
  return nodes;
}

/// Drops nodes without cells. Returns how many are left.
void drop_unused(std::vector<Vec3>& nodes, int* connectivity, std::size_t n) {
  std::vector<int> renumbered(nodes.size(), -1);
  for (std::size_t i = 0; i < n; ++i) renumbered[connectivity[i]] = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (renumbered[i] == 0) {
      renumbered[i] = static_cast<int>(kept);
      nodes[kept++] = nodes[i];
    }
  nodes.resize(kept);
  for (std::size_t i = 0; i < n; ++i) connectivity[i] = renumbered[connectivity[i]];
}

/// A triangulated CAD surface on its way to the right volume.
class SurfaceFit {
public:
  explicit SurfaceFit(double volume) : volume_(volume) {}

  TriangleSurface run(const std::string& subject) {
    extract();
    turn_outward(surface_);
    for (int t = 0; t < surface_.n_triangles(); ++t) surface_.normals[t] = area_vector(surface_, t).normalized();
    measure_gaps();
    move_vertices(subject);
    return std::move(surface_);
  }

private:
  struct Face {
    int tag;
    bool plane;
    int first, last;  ///< triangles
  };

  void extract() {
    Nodes nodes = current_nodes();
    Parts faces;
    gmsh::model::getEntities(faces, 2);
    for (const auto& [dim, tag] : faces) {
      std::vector<std::size_t> tags, corners;
      gmsh::model::mesh::getElementsByType(2, tags, corners, tag);
      const int first = surface_.n_triangles();
      for (std::size_t i = 0; i < corners.size(); i += 3)
        surface_.triangles.push_back(
            {nodes.number.at(corners[i]), nodes.number.at(corners[i + 1]), nodes.number.at(corners[i + 2])});
      faces_.push_back({tag, is_plane(tag), first, surface_.n_triangles()});
    }
    surface_.vertices = std::move(nodes.positions);
    surface_.normals.assign(surface_.triangles.size(), Vec3::Zero());
    drop_unused(surface_.vertices, surface_.triangles.data()->data(), 3 * surface_.triangles.size());
  }

  /// True normals at the triangles' centres, and how far the true surface lies outside of the triangles there.
  void measure_gaps() {
    gaps_.assign(surface_.triangles.size(), 0.0);
    for (const Face& face : faces_) {
      if (face.first == face.last) continue;
      std::vector<double> centres, parameters, points, normals;
      for (int t = face.first; t < face.last; ++t) {
        const Vec3 c = (surface_.corner(t, 0) + surface_.corner(t, 1) + surface_.corner(t, 2)) / 3.0;
        centres.insert(centres.end(), c.data(), c.data() + 3);
      }
      gmsh::model::getParametrization(2, face.tag, centres, parameters);
      gmsh::model::getValue(2, face.tag, parameters, points);
      gmsh::model::getNormal(face.tag, parameters, normals);
      for (int t = face.first; t < face.last; ++t) {
        const int i = 3 * (t - face.first);
        Vec3 normal(normals[i], normals[i + 1], normals[i + 2]);
        const Vec3 facet = surface_.normals[t];
        if (normal.dot(facet) < 0.0) normal = -normal;
        if (!(normal.dot(facet) > 0.5)) continue;  // no normal at poles: the facet's own stays
        surface_.normals[t] = normal.normalized();
        if (!face.plane)
          gaps_[t] = (Vec3(points[i], points[i + 1], points[i + 2]) - Vec3(centres[i], centres[i + 1], centres[i + 2]))
                         .dot(facet);
      }
    }
  }

  /// What a vertex sees of one face: mean normal and gap of its triangles there, weighted by area.
  struct View {
    int face;
    Vec3 normal = Vec3::Zero();
    double gap = 0.0, area = 0.0;
  };

  std::vector<std::vector<View>> views() const {
    std::vector<std::vector<View>> views(surface_.vertices.size());
    for (int f = 0; f < static_cast<int>(faces_.size()); ++f)
      for (int t = faces_[f].first; t < faces_[f].last; ++t) {
        const double area = area_vector(surface_, t).norm();
        for (int v : surface_.triangles[t]) {
          if (views[v].empty() || views[v].back().face != f) views[v].push_back({f});
          View& view = views[v].back();
          view.normal += area * surface_.normals[t];
          view.gap += area * gaps_[t];
          view.area += area;
        }
      }
    return views;
  }

  /// The shortest move that lifts the vertex by the gap off each curved face and keeps it in each plane one.
  Vec3 move_of(const std::vector<View>& views, bool absolute) const {
    std::vector<Vec3> fixed;  // orthonormal
    for (const View& view : views)
      if (faces_[view.face].plane) {
        Vec3 n = view.normal.normalized();
        for (int pass = 0; pass < 2; ++pass)
          for (const Vec3& f : fixed) n -= f.dot(n) * f;
        if (n.norm() > 1e-6) fixed.push_back(n.normalized());
      }
    const auto free_part = [&](Vec3 x) {
      for (const Vec3& f : fixed) x -= f.dot(x) * f;
      return x;
    };
    if (fixed.size() == 3) return Vec3::Zero();
    // Least squares by the normal equations, without the directions that hardly any face has. Fixed sizes only: Gmsh has
    // Eigen in it too, and templates over dynamic sizes would be mixed up with its own at run time.
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    double largest = -1.0;
    for (const View& view : views) {
      const Vec3 direction = faces_[view.face].plane ? Vec3::Zero() : free_part(view.normal.normalized());
      if (direction.norm() < 0.2) continue;  // nearly tangent to the plane: cannot follow
      const double gap = (absolute ? std::abs(view.gap) : view.gap) / view.area;
      normal += direction * direction.transpose();
      right += gap * direction;
      largest = std::max(largest, std::abs(gap));
    }
    if (largest < 0.0) return Vec3::Zero();
    const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(normal);
    Vec3 move = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
      const Vec3 axis = spectrum.eigenvectors().col(i);
      const double value = spectrum.eigenvalues()[i];
      if (value > 0.01 * spectrum.eigenvalues()[2]) move += axis.dot(right) / value * axis;
    }
    move = free_part(move);
    const double limit = 3.0 * largest;
    return move.norm() > limit ? Vec3(limit / move.norm() * move) : move;
  }

  /// The gap of a quadratic surface is 3/4 of that at the centre on average. The small rest that is missing to the true
  /// volume is shared out in proportion to the gaps' sizes, so that convex and concave faces do not cancel.
  void move_vertices(const std::string& subject) {
    const std::vector<std::vector<View>> seen = views();
    std::vector<Vec3> rest;
    const double size = std::cbrt(volume_);
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const Vec3 move = move_of(seen[v], false);
      // Below this it is rounding: bodies with plane faces stay as they are.
      if (move.norm() > 1e-13 * size) surface_.vertices[v] += 0.75 * move;
      const Vec3 more = move_of(seen[v], true);
      rest.push_back(more.norm() > 1e-13 * size ? more : Vec3::Zero());
    }
    const std::vector<Vec3> start = surface_.vertices;
    const auto missing = [&](double factor) {
      for (std::size_t v = 0; v < start.size(); ++v) surface_.vertices[v] = start[v] + factor * rest[v];
      return volume(surface_) - volume_;
    };
    double f0 = 0.0, f1 = 0.01, m0 = missing(f0), m1 = missing(f1);
    for (int step = 0; step < 6 && m1 != m0 && std::abs(m1) > 1e-14 * volume_; ++step) {
      const double next = f1 - m1 * (f1 - f0) / (m1 - m0);
      f0 = f1;
      m0 = m1;
      f1 = std::clamp(next, -0.5, 0.5);
      m1 = missing(f1);
    }
    if (!(std::abs(m1) <= 1e-6 * volume_))
      throw InputError(
          fmt::format("{}: the triangles enclose {:g} m3, the body has {:g} m3 (take a smaller size, and let "
                      "parts overlap clearly or stay apart)",
                      subject, m1 + volume_, volume_));
  }

  double volume_;
  TriangleSurface surface_;
  std::vector<Face> faces_;
  std::vector<double> gaps_;
};

/// Hands a surface to Gmsh as the boundary of the only solid of the model.
void build_from(const TriangleSurface& surface) {
  gmsh::model::add("solid");
  gmsh::model::addDiscreteEntity(2, 1);
  std::vector<std::size_t> node_tags, triangle_tags, corners;
  std::vector<double> x;
  for (std::size_t v = 0; v < surface.vertices.size(); ++v) {
    node_tags.push_back(v + 1);
    x.insert(x.end(), surface.vertices[v].data(), surface.vertices[v].data() + 3);
  }
  for (int t = 0; t < surface.n_triangles(); ++t) {
    triangle_tags.push_back(t + 1);
    for (int v : surface.triangles[t]) corners.push_back(v + 1);
  }
  gmsh::model::mesh::addNodes(2, 1, node_tags, x);
  gmsh::model::mesh::addElementsByType(1, 2, triangle_tags, corners);
  gmsh::model::geo::addVolume({gmsh::model::geo::addSurfaceLoop({1})});
  gmsh::model::geo::synchronize();
}

/// Edges of a tetrahedron that carry nodes 4 .. 9 in VTK order.
constexpr std::array<std::array<int, 2>, 6> edges = {{{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};

double corner_jacobian(const SolidMesh& mesh, const int* cell) {
  const Vec3& a = mesh.nodes[cell[0]];
  return (mesh.nodes[cell[1]] - a).dot((mesh.nodes[cell[2]] - a).cross(mesh.nodes[cell[3]] - a));
}

/// Smallest Jacobian at the nodes of a quadratic cell, over that of the straight one.
double smallest_jacobian(const SolidMesh& mesh, const int* cell) {
  double smallest = 1.0;
  for (int node = 0; node < 10; ++node) {
    Eigen::Vector4d l = Eigen::Vector4d::Zero();  // barycentric coordinates
    if (node < 4)
      l[node] = 1.0;
    else
      l[edges[node - 4][0]] = l[edges[node - 4][1]] = 0.5;
    Eigen::Matrix<double, 3, 4> d = Eigen::Matrix<double, 3, 4>::Zero();  // derivatives by them
    for (int i = 0; i < 4; ++i) d.col(i) += (4.0 * l[i] - 1.0) * mesh.nodes[cell[i]];
    for (int e = 0; e < 6; ++e) {
      d.col(edges[e][0]) += 4.0 * l[edges[e][1]] * mesh.nodes[cell[4 + e]];
      d.col(edges[e][1]) += 4.0 * l[edges[e][0]] * mesh.nodes[cell[4 + e]];
    }
    const double j = (d.col(1) - d.col(0)).dot((d.col(2) - d.col(0)).cross(d.col(3) - d.col(0)));
    smallest = std::min(smallest, j / corner_jacobian(mesh, cell));
  }
  return smallest;
}

/// Cells that curved faces turn inside out get straight edges.
void straighten(SolidMesh& mesh) {
  constexpr double acceptable = 0.05;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t c = 0; c < mesh.connectivity.size(); c += 10) {
      const int* cell = &mesh.connectivity[c];
      if (smallest_jacobian(mesh, cell) > acceptable) continue;
      for (int e = 0; e < 6; ++e) {
        const Vec3 middle = 0.5 * (mesh.nodes[cell[edges[e][0]]] + mesh.nodes[cell[edges[e][1]]]);
        changed = changed || mesh.nodes[cell[4 + e]] != middle;
        mesh.nodes[cell[4 + e]] = middle;
      }
    }
  }
}

/// Volume of the cells with their edges straight.
double straight_volume(const SolidMesh& mesh) {
  double volume = 0.0;
  for (std::size_t c = 0; c < mesh.connectivity.size(); c += mesh.nodes_per_cell)
    volume += corner_jacobian(mesh, &mesh.connectivity[c]) / 6.0;
  return volume;
}

/// Gmsh fills cavities of a surface from a file too: keeps the cells of the body.
void keep_inside(SolidMesh& mesh, const SolidRegion& body) {
  std::vector<int> kept;
  for (auto cell = mesh.connectivity.begin(); cell != mesh.connectivity.end(); cell += mesh.nodes_per_cell) {
    const Vec3 sum = mesh.nodes[cell[0]] + mesh.nodes[cell[1]] + mesh.nodes[cell[2]] + mesh.nodes[cell[3]];
    if (body.contains(0.25 * sum)) kept.insert(kept.end(), cell, cell + mesh.nodes_per_cell);
  }
  mesh.connectivity = std::move(kept);
  drop_unused(mesh.nodes, mesh.connectivity.data(), mesh.connectivity.size());
}

SolidMesh current_tetrahedra(int order, const std::string& subject) {
  Nodes nodes = current_nodes();
  SolidMesh mesh{std::move(nodes.positions), order == 1 ? 4 : 10, {}};
  std::vector<std::size_t> tags, cell_nodes;
  gmsh::model::mesh::getElementsByType(order == 1 ? 4 : 11, tags, cell_nodes);
  for (std::size_t n : cell_nodes) mesh.connectivity.push_back(nodes.number.at(n));
  for (std::size_t c = 0; c < mesh.connectivity.size(); c += mesh.nodes_per_cell) {
    int* cell = &mesh.connectivity[c];
    if (order == 2) std::swap(cell[8], cell[9]);  // Gmsh: edge (2, 3) before (1, 3)
    if (corner_jacobian(mesh, cell) < 0.0) {
      std::swap(cell[1], cell[2]);
      if (order == 2) {
        std::swap(cell[4], cell[6]);
        std::swap(cell[8], cell[9]);
      }
    }
    const Vec3 side = mesh.nodes[cell[1]] - mesh.nodes[cell[0]];
    if (!(corner_jacobian(mesh, cell) > 1e-9 * std::pow(side.norm(), 3)))
      throw InputError(fmt::format("{}: a cell at {} is flat (take another size)", subject, at(mesh.nodes[cell[0]])));
  }
  drop_unused(mesh.nodes, mesh.connectivity.data(), mesh.connectivity.size());
  if (order == 2) straighten(mesh);
  return mesh;
}

}  // namespace

TriangleSurface triangulate(const SolidShape& shape, double size) {
  check_size(size, 0.0, "triangles");
  if (const SurfaceFile* file = std::get_if<SurfaceFile>(&shape.form)) return read_stl(*file);
  const std::string subject = fmt::format("surface of triangles of {:g} m", size);
  TriangleSurface surface;
  with_gmsh(subject, [&] {
    constexpr int chords = 60;
    const Options options(settings(size, chords, 1));
    const Measures measures = build(shape);
    if (measures.only_planes)
      gmsh::option::setNumber("Mesh.MeshSizeMax", 1e22);
    else
      check_size(size, 2.3 * measures.area / (size * size), "triangles");
    gmsh::model::mesh::generate(2);
    surface = SurfaceFit(measures.volume).run(subject);
    return Mesh{};
  });
  return surface;
}

SolidMesh mesh_solid(const SolidShape& shape, double size, int order) {
  check_size(size, 0.0, "cells");
  if (order != 1 && order != 2) throw InputError(fmt::format("solid: order {} (1 and 2 are possible)", order));
  const std::string subject = fmt::format("solid mesh of size {:g} m", size);
  const SurfaceFile* file = std::get_if<SurfaceFile>(&shape.form);
  const TriangleSurface surface = file ? read_stl(*file) : TriangleSurface{};
  SolidMesh mesh;
  with_gmsh(subject, [&] {
    constexpr int chords = 12;  // coarser than this no circle is
    const Options options(settings(size, chords, order));
    const Measures measures = file ? Measures{volume(surface), 0.0, true} : build(shape);
    const double body = measures.volume;
    check_size(size, 8.5 * body / (size * size * size), "cells");
    if (file) build_from(split(surface, 1.2 * size));
    gmsh::model::mesh::generate(3);
    mesh = current_tetrahedra(order, subject);
    if (file) keep_inside(mesh, SolidRegion(surface));
    // Curved faces lose up to a part of 0.3 to their chords.
    const double filled = straight_volume(mesh) / body, tolerance = measures.only_planes ? 1e-6 : 0.5;
    if (!(std::abs(filled - 1.0) <= tolerance))
      throw InputError(
          fmt::format("{}: Gmsh filled {:g} times the body's volume (take another size)", subject, filled));
    return Mesh{};
  });
  return mesh;
}

}  // namespace berm
