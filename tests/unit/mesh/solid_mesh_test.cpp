#include "mesh/solid_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "base/error.hpp"
#include "mesh/gmsh_model.hpp"
#include "solid_cells.hpp"

using namespace berm;
using solid_cells::volume;

namespace {

SolidShape box(const Vec3& min, const Vec3& max) { return {SolidBox{min, max}}; }
SolidShape combined(SolidCombination::Kind kind, std::vector<SolidShape> parts) {
  return {SolidCombination{kind, std::move(parts)}};
}
SolidShape minus(std::vector<SolidShape> parts) {
  return combined(SolidCombination::Kind::difference, std::move(parts));
}
SolidShape join(std::vector<SolidShape> parts) { return combined(SolidCombination::Kind::join, std::move(parts)); }

BodyMeshOptions options(BodyMeshKind kind, double size, int order = 1, bool structured = true) {
  BodyMeshOptions o;
  o.kind = kind;
  o.size = size;
  o.order = order;
  o.structured = structured;
  return o;
}

constexpr BodyMeshKind hexahedra = BodyMeshKind::hexahedra, tetrahedra = BodyMeshKind::tetrahedra;

CellKind kind_of(BodyMeshKind kind, int order) {
  if (kind == hexahedra) return order == 1 ? CellKind::hex8 : CellKind::hex20;
  return order == 1 ? CellKind::tet4 : CellKind::tet10;
}

bool all_of_kind(const Mesh& mesh, CellKind kind) {
  return std::all_of(mesh.kinds.begin(), mesh.kinds.end(), [&](CellKind k) { return k == kind; });
}

double worst_corner(const Mesh& mesh) {
  double worst = 1.0;
  for (int c = 0; c < mesh.n_cells(); ++c) worst = std::min(worst, smallest_corner_jacobian(mesh, c));
  return worst;
}

/// Area of the boundary's faces by their corners.
double surface(const Mesh& mesh) {
  double area = 0.0;
  for (const CellFace& face : boundary_faces(mesh)) {
    const Corners p = face_corners(mesh, face);
    area += p.n == 3 ? 0.5 * (p.x[1] - p.x[0]).cross(p.x[2] - p.x[0]).norm()
                     : 0.5 * (p.x[2] - p.x[0]).cross(p.x[3] - p.x[1]).norm();
  }
  return area;
}

/// No node twice, none unused.
void expect_tidy_nodes(const Mesh& mesh) {
  std::set<std::array<double, 3>> places;
  for (const Vec3& x : mesh.nodes) places.insert({x.x(), x.y(), x.z()});
  EXPECT_EQ(static_cast<int>(places.size()), mesh.n_nodes());
  const std::set<int> used(mesh.connectivity.begin(), mesh.connectivity.end());
  EXPECT_EQ(static_cast<int>(used.size()), mesh.n_nodes());
}

std::string error_of(const Shape& shape, const BodyMeshOptions& o) {
  try {
    mesh_shape(shape, o);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

const double pi = std::numbers::pi;

}  // namespace

TEST(CellTables, EdgesAndFacesAreThoseOfVtk) {
  for (CellKind kind : {CellKind::tet10, CellKind::hex20}) {
    const auto edges = edges_of(kind);
    ASSERT_EQ(static_cast<int>(edges.size()), nodes_of(kind) - corners_of(kind));
    for (std::size_t e = 0; e < edges.size(); ++e) {
      const Vec3 a = solid_cells::node_at(kind, edges[e][0]), b = solid_cells::node_at(kind, edges[e][1]);
      EXPECT_EQ(0.5 * (a + b), solid_cells::node_at(kind, corners_of(kind) + static_cast<int>(e)));
    }
    const Vec3 centre = is_simplex(kind) ? Vec3::Constant(0.25) : Vec3::Zero();
    Vec3 sum = Vec3::Zero();
    for (const FaceCorners& f : faces_of(kind)) {
      const auto at = [&](int i) { return solid_cells::node_at(kind, f.corner[i]); };
      const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0));
      EXPECT_GT(normal.dot(at(0) - centre), 0.0);
      sum += normal;
    }
    EXPECT_EQ(sum, Vec3::Zero());
  }
}

TEST(CellTables, ShapeFunctionsOfTheTestAreOneAtTheirNode) {
  for (CellKind kind : {CellKind::tet4, CellKind::tet10, CellKind::hex8, CellKind::hex20})
    for (int i = 0; i < nodes_of(kind); ++i)
      for (int j = 0; j < nodes_of(kind); ++j)
        EXPECT_EQ(solid_cells::shape(kind, i, solid_cells::node_at(kind, j)), i == j ? 1.0 : 0.0);
}

TEST(SolidMeshShape, Box) {
  const SolidShape shape = box(Vec3(0, -1, 0.5), Vec3(2, 0, 2));
  for (BodyMeshKind kind : {hexahedra, tetrahedra})
    for (int order : {1, 2}) {
      const Mesh mesh = mesh_shape(shape, options(kind, 0.26, order));
      EXPECT_EQ(mesh.n_cells(), 8 * 4 * 6 * (kind == hexahedra ? 1 : 6));
      EXPECT_TRUE(all_of_kind(mesh, kind_of(kind, order)));
      EXPECT_NEAR(volume(mesh), 3.0, 1e-13);
      EXPECT_NEAR(surface(mesh), 13.0, 1e-13);
      EXPECT_EQ(boundary_faces(mesh).size(), 2u * (8 * 4 + 4 * 6 + 8 * 6) * (kind == hexahedra ? 1 : 2));
      EXPECT_GT(worst_corner(mesh), kind == hexahedra ? 0.999999 : 0.3);
      solid_cells::expect_mid_sides(mesh, 1e-15);
      expect_tidy_nodes(mesh);
    }
  EXPECT_EQ(mesh_shape(shape, options(hexahedra, 50.0)).n_cells(), 1);
  EXPECT_EQ(mesh_shape(shape, options(hexahedra, 1.0, 2)).n_nodes(), 3 * 2 * 3 + 2 * 2 * 3 + 3 * 1 * 3 + 3 * 2 * 2);
}

TEST(SolidMeshShape, TetrahedraAreMirroredAboutTheMiddle) {
  const Mesh mesh = mesh_shape(box(Vec3(-1, -1, -1), Vec3(1, 1, 1)), options(tetrahedra, 1.0));
  std::vector<int> valence(mesh.n_nodes(), 0);
  for (int n : mesh.connectivity) ++valence[n];
  for (int n = 0; n < mesh.n_nodes(); ++n)
    if (mesh.nodes[n].norm() < 1e-12) {
      EXPECT_EQ(valence[n], 48);  // all eight diagonals end in the centre
    }
}

TEST(SolidMeshShape, BoxesWithNotchesAndSteps) {
  const SolidShape specimen =
      minus({join({box(Vec3(0, 0, 0), Vec3(0.3, 0.15, 0.05)), box(Vec3(0.3, 0, 0), Vec3(0.4, 0.05, 0.05))}),
             box(Vec3(0.1, -1, -1), Vec3(0.105, 0.02, 1)), box(Vec3(0.2, 0.1, 0.02), Vec3(0.23, 0.12, 0.03))});
  const double exact = 0.3 * 0.15 * 0.05 + 0.1 * 0.05 * 0.05 - 0.005 * 0.02 * 0.05 - 0.03 * 0.02 * 0.01;
  for (BodyMeshKind kind : {hexahedra, tetrahedra}) {
    const Mesh mesh = mesh_shape(specimen, options(kind, 0.01));
    EXPECT_NEAR(volume(mesh), exact, 1e-15);
    EXPECT_TRUE(all_of_kind(mesh, kind_of(kind, 1)));
    expect_tidy_nodes(mesh);
    const double outer = 2 * (0.3 * 0.15 + 0.1 * 0.05) + 0.05 * (2 * 0.15 + 2 * 0.4);
    const double notch = 2 * 0.02 * 0.05 - 2 * 0.005 * 0.02, cavity = 2 * (0.03 * 0.02 + 0.02 * 0.01 + 0.03 * 0.01);
    EXPECT_NEAR(surface(mesh), outer + notch + cavity, 1e-13);
  }
}

TEST(SolidMeshShape, CylinderAboutAnyAxis) {
  const double r = 0.075, length = 0.3;
  for (const Vec3& direction : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(1, 2, -0.5)})
    for (BodyMeshKind kind : {hexahedra, tetrahedra})
      for (int order : {1, 2}) {
        const Vec3 from(0.3, -0.2, 0.1), axis = direction.normalized();
        const SolidShape shape{Cylinder{from, from + length * axis, r}};
        const Mesh mesh = mesh_shape(shape, options(kind, 0.02, order));
        const int n = kind == hexahedra ? 7 : 6;  // sqrt(pi) r / h = 6.65
        EXPECT_EQ(mesh.n_cells(), n * n * 15 * (kind == hexahedra ? 1 : 6));
        EXPECT_TRUE(all_of_kind(mesh, kind_of(kind, order)));
        EXPECT_GT(worst_corner(mesh), 1e-3);
        EXPECT_NEAR(volume(mesh) / (pi * r * r * length), 1.0, order == 1 ? 0.04 : 4e-4);
        expect_tidy_nodes(mesh);
        Vec3 moment = Vec3::Zero();
        for (const Vec3& x : mesh.nodes) {
          const Vec3 d = x - from;
          EXPECT_LT(d.cross(axis).norm(), r * (1 + 1e-12));
          EXPECT_GT(d.dot(axis), -1e-12);
          EXPECT_LT(d.dot(axis), length + 1e-12);
          moment += d - 0.5 * length * axis;
        }
        EXPECT_LT(moment.norm(), 1e-10);
      }
}

TEST(SolidMeshShape, CurvedFacesOfQuadraticCylindersLieOnTheCylinder) {
  const SolidShape shape{Cylinder{Vec3(0, 0, 0), Vec3(0, 0, 1), 0.5}};
  for (BodyMeshKind kind : {hexahedra, tetrahedra}) {
    const Mesh mesh = mesh_shape(shape, options(kind, 0.1, 2));
    int on_the_side = 0;
    for (const CellFace& face : boundary_faces(mesh)) {
      const Corners p = face_corners(mesh, face);
      double lowest = 1.0, highest = 0.0;
      for (int i = 0; i < p.n; ++i) {
        lowest = std::min(lowest, p.x[i].z());
        highest = std::max(highest, p.x[i].z());
      }
      if (highest - lowest < 1e-9) continue;  // flat ends
      ++on_the_side;
      const FaceCorners& f = faces_of(mesh.kinds[face.cell])[face.local];
      const auto in_face = [&](int corner) {
        return std::count(f.corner.begin(), f.corner.begin() + f.n, corner) == 1;
      };
      const auto edges = edges_of(mesh.kinds[face.cell]);
      for (std::size_t e = 0; e < edges.size(); ++e)
        if (in_face(edges[e][0]) && in_face(edges[e][1])) {
          const Vec3& x = mesh.nodes[mesh.cell(face.cell)[corners_of(mesh.kinds[face.cell]) + e]];
          EXPECT_NEAR(x.head<2>().norm(), 0.5, 1e-14);
        }
    }
    EXPECT_EQ(on_the_side, kind == hexahedra ? 4 * 9 * 10 : 4 * 8 * 10 * 2);
  }
}

TEST(SolidMeshShape, VolumesOfCylindersConverge) {
  const double exact = pi * 0.25;
  const SolidShape shape{Cylinder{Vec3(0, 0, 0), Vec3(0, 0, 1), 0.5}};
  for (BodyMeshKind kind : {hexahedra, tetrahedra})
    for (int order : {1, 2}) {
      const auto error = [&](int n) {
        const double size = std::sqrt(pi) * 0.5 / n;
        return std::abs(volume(mesh_shape(shape, options(kind, size, order))) / exact - 1.0);
      };
      const double coarse = error(4), fine = error(8), ratio = coarse / fine;
      RecordProperty(kind == hexahedra ? "hexahedra" : "tetrahedra", ratio);
      EXPECT_GT(ratio, order == 1 ? 3.5 : 12.0);
      EXPECT_LT(fine, order == 1 ? 0.03 : 2e-4);
    }
}

TEST(SolidMeshShape, UnstructuredTetrahedra) {
  const Vec3 c(0.1, 0.2, 0.3);
  const std::pair<SolidShape, double> shapes[] = {
      {{Cylinder{Vec3(0, 0, 0), Vec3(0, 0, 0.2), 0.1}}, pi * 0.01 * 0.2},
      {{Sphere{c, 0.1}}, 4.0 / 3.0 * pi * 1e-3},
      {box(Vec3(0, 0, 0), Vec3(0.2, 0.1, 0.1)), 2e-3},
      {{Extrusion{{Vec2(0, 0), Vec2(0.2, 0), Vec2(0, 0.2)}, -0.1, 0.1}}, 0.02 * 0.2},
      {minus({box(Vec3(-0.1, -0.1, -0.1), Vec3(0.1, 0.1, 0.1)), {Sphere{Vec3::Zero(), 0.05}}}),
       8e-3 - 4.0 / 3.0 * pi * 1.25e-4},
  };
  for (const auto& [shape, exact] : shapes)
    for (int order : {1, 2}) {
      const Mesh mesh = mesh_shape(shape, options(tetrahedra, 0.04, order, false));
      EXPECT_TRUE(all_of_kind(mesh, kind_of(tetrahedra, order)));
      EXPECT_GT(worst_corner(mesh), 0.01);
      EXPECT_NEAR(volume(mesh) / exact, 1.0, order == 1 ? 0.08 : 4e-3);
      expect_tidy_nodes(mesh);
    }
}

TEST(SolidMeshShape, VolumeOfUnstructuredTetrahedraConverges) {
  const SolidShape shape{Cylinder{Vec3(0, 0, 0), Vec3(0, 0, 0.2), 0.1}};
  const double exact = pi * 0.01 * 0.2;
  for (int order : {1, 2}) {
    const auto error = [&](double size) {
      return std::abs(volume(mesh_shape(shape, options(tetrahedra, size, order, false))) / exact - 1.0);
    };
    EXPECT_GT(error(0.04) / error(0.02), order == 1 ? 2.5 : 6.0);
  }
}

TEST(SolidMeshShape, KindAndShapeMustGoTogether) {
  const SolidShape solid = box(Vec3::Zero(), Vec3::Ones()), ball{Sphere{Vec3::Zero(), 1.0}};
  const PlaneShape plane{Box{Vec2(0, 0), Vec2(1, 1)}};
  EXPECT_NE(error_of(plane, options(hexahedra, 0.1)).find("takes quads or triangles"), std::string::npos);
  EXPECT_NE(error_of(plane, options(tetrahedra, 0.1, 1, false)).find("takes quads or triangles"), std::string::npos);
  EXPECT_NE(error_of(solid, options(BodyMeshKind::quads, 0.1)).find("takes hexahedra or tetrahedra"),
            std::string::npos);
  EXPECT_NE(error_of(solid, options(BodyMeshKind::triangles, 0.1, 1, false)).find("takes hexahedra or tetrahedra"),
            std::string::npos);
  EXPECT_NE(error_of(solid, options(hexahedra, 0.1, 1, false)).find("structured = true"), std::string::npos);
  EXPECT_NE(error_of(ball, options(hexahedra, 0.1)).find("needs a cylinder or"), std::string::npos);
  EXPECT_NE(error_of(ball, options(tetrahedra, 0.1)).find("needs a cylinder or"), std::string::npos);
}

TEST(SolidMeshShape, RefusesBadOptionsAndShapes) {
  const SolidShape cube = box(Vec3::Zero(), Vec3::Ones());
  EXPECT_THROW(mesh_shape(cube, options(hexahedra, 0.0)), InputError);
  EXPECT_THROW(mesh_shape(cube, options(hexahedra, std::nan(""))), InputError);
  EXPECT_THROW(mesh_shape(cube, options(hexahedra, 0.1, 3)), InputError);
  EXPECT_THROW(mesh_shape(cube, options(hexahedra, 1e-4)), InputError);
  EXPECT_THROW(mesh_shape(cube, options(tetrahedra, 1e-4, 1, false)), InputError);
  EXPECT_THROW(mesh_shape(box(Vec3::Zero(), Vec3(1, 1, 0)), options(hexahedra, 0.1)), InputError);
  EXPECT_THROW(mesh_shape(minus({cube, box(-Vec3::Ones(), 2 * Vec3::Ones())}), options(hexahedra, 0.1)), InputError);
  EXPECT_THROW(mesh_shape(join({}), options(hexahedra, 0.1)), InputError);
  EXPECT_THROW(mesh_shape(SolidShape{Cylinder{Vec3::Zero(), Vec3::Zero(), 1}}, options(hexahedra, 0.1)), InputError);
  EXPECT_THROW(mesh_shape(SolidShape{Cylinder{Vec3::Zero(), Vec3::Ones(), -1}}, options(hexahedra, 0.1)), InputError);
  EXPECT_THROW(mesh_shape(SolidShape{Cylinder{Vec3::Zero(), Vec3::Ones(), 1}}, options(hexahedra, 1e-4)), InputError);
}

TEST(SolidMeshShape, HasStructuredMesh) {
  const SolidShape cube = box(Vec3::Zero(), Vec3::Ones()), rod{Cylinder{Vec3::Zero(), Vec3::Ones(), 1}};
  EXPECT_TRUE(has_structured_mesh(cube));
  EXPECT_TRUE(has_structured_mesh(minus({cube, join({cube, cube})})));
  EXPECT_TRUE(has_structured_mesh(rod));
  EXPECT_FALSE(has_structured_mesh(minus({cube, rod})));
  EXPECT_FALSE(has_structured_mesh(SolidShape{Sphere{Vec3::Zero(), 1}}));
  EXPECT_TRUE(has_structured_mesh(PlaneShape{Disc{Vec2(0, 0), 1}}));
  EXPECT_FALSE(has_structured_mesh(PlaneShape{Polygon{{Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}}}));
}
