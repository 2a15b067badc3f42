#include "mesh/gmsh.hpp"

#include <gmsh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>

#include "base/error.hpp"
#include "mesh/gmsh_model.hpp"
#include "msh_file.hpp"

using namespace berm;
using msh_file::error_of;
using msh_file::File;
using msh_file::replaced;

namespace {

PlaneShape box(double x0, double y0, double x1, double y1) { return {Box{Vec2(x0, y0), Vec2(x1, y1)}}; }
PlaneShape disc(double x, double y, double r) { return {Disc{Vec2(x, y), r}}; }
PlaneShape minus(std::vector<PlaneShape> parts) {
  return {Combination{Combination::Kind::difference, std::move(parts)}};
}

PlaneShape slit_specimen() {
  return minus({box(-0.15, 0, 0.15, 0.15), box(-0.0775, 0, -0.0725, 0.02), box(0.0725, 0, 0.0775, 0.02),
                box(-0.0775, 0.13, -0.0725, 0.15), box(0.0725, 0.13, 0.0775, 0.15)});
}

BodyMeshOptions options(BodyMeshKind kind, double size, int order = 1, bool structured = false) {
  BodyMeshOptions o;
  o.kind = kind;
  o.size = size;
  o.order = order;
  o.structured = structured;
  return o;
}

double total_area(const Mesh& mesh) {
  double area = 0.0;
  for (int c = 0; c < mesh.n_cells(); ++c) area += cell_measure(mesh, c);
  return area;
}

double worst_corner(const Mesh& mesh) {
  double worst = 1.0;
  for (int c = 0; c < mesh.n_cells(); ++c) worst = std::min(worst, smallest_corner_jacobian(mesh, c));
  return worst;
}

bool all_of_kind(const Mesh& mesh, CellKind kind) {
  return std::all_of(mesh.kinds.begin(), mesh.kinds.end(), [&](CellKind k) { return k == kind; });
}

/// Mid-side nodes of straight boundary and interior sides lie half-way.
void expect_mid_sides(const Mesh& mesh, double tolerance) {
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int n = corners_of(mesh.kinds[c]);
    const int* nodes = mesh.cell(c);
    for (int i = 0; i < n; ++i) {
      const Vec3 middle = 0.5 * (mesh.nodes[nodes[i]] + mesh.nodes[nodes[(i + 1) % n]]);
      EXPECT_LT((mesh.nodes[nodes[n + i]] - middle).norm(), tolerance);
    }
  }
}

/// Two unit squares side by side, the right one halved; node 9 is used by a line only, node 20 by nothing. The left
/// square is clockwise and is listed twice (groups "left" and "all").
const char* two_squares =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n4\n1 5 \"bottom\"\n2 1 \"left\"\n2 2 \"right\"\n2 3 \"all\"\n$EndPhysicalNames\n"
    "$Nodes\n8\n1 0 0 0\n2 1 0 0\n13 2 0 0\n4 2 1 0\n5 1 1 0\n6 0 1 0\n9 3 0 0\n20 5 5 1\n$EndNodes\n"
    "$Elements\n7\n"
    "1 1 2 5 1 1 2\n2 1 2 5 1 2 13\n3 1 2 5 1 13 9\n"
    "4 3 2 1 1 1 6 5 2\n5 3 2 3 3 1 6 5 2\n"
    "6 2 2 2 2 2 13 4\n7 2 2 2 2 2 4 5\n"
    "$EndElements\n";

}  // namespace

TEST(ReadMsh, CellsNodesAndGroups) {
  const File file(two_squares);
  const Mesh mesh = read_msh(file.path());
  ASSERT_EQ(mesh.n_cells(), 3);
  EXPECT_EQ(mesh.n_nodes(), 6);
  EXPECT_NEAR(total_area(mesh), 2.0, 1e-15);
  EXPECT_GT(worst_corner(mesh), 0.7);
  ASSERT_EQ(mesh.node_groups.count("bottom"), 1u);
  EXPECT_EQ(mesh.node_groups.at("bottom").size(), 3u);
  for (int n : mesh.node_groups.at("bottom")) EXPECT_EQ(mesh.nodes[n].y(), 0.0);
  ASSERT_EQ(mesh.cell_groups.at("left").size(), 1u);
  EXPECT_EQ(mesh.kinds[mesh.cell_groups.at("left")[0]], CellKind::quad4);
  EXPECT_EQ(mesh.cell_groups.at("all"), mesh.cell_groups.at("left"));
  EXPECT_EQ(mesh.cell_groups.at("right").size(), 2u);
  EXPECT_EQ(boundary_faces(mesh).size(), 6u);
}

TEST(ReadMsh, Version41WithQuadraticCells) {
  const File file(
      "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
      "$Entities\n0 0 1 0\n1 0 0 0 1 1 0 0 0\n$EndEntities\n"
      "$Nodes\n1 8 1 8\n2 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n"
      "0 0 0\n0 1 0\n1 1 0\n1 0 0\n0 0.5 0\n0.5 1.1 0\n1 0.5 0\n0.5 0 0\n$EndNodes\n"
      "$Elements\n1 1 1 1\n2 1 16 1\n1 1 2 3 4 5 6 7 8\n$EndElements\n");
  const Mesh mesh = read_msh(file.path());
  ASSERT_EQ(mesh.n_cells(), 1);
  EXPECT_EQ(mesh.kinds[0], CellKind::quad8);
  EXPECT_NEAR(cell_measure(mesh, 0), 1.0, 1e-15);
  for (int i = 0; i < 4; ++i) {
    const Vec3 middle = 0.5 * (mesh.nodes[mesh.cell(0)[i]] + mesh.nodes[mesh.cell(0)[(i + 1) % 4]]);
    EXPECT_LT((mesh.nodes[mesh.cell(0)[4 + i]] - middle).norm(), 0.11);
  }
}

TEST(ReadMsh, ErrorsNameFileAndReason) {
  EXPECT_NE(error_of("/nowhere/dam.msh").find("/nowhere/dam.msh: there is no such file"), std::string::npos);
  const std::pair<std::string, const char*> cases[] = {
      {"", "empty"},
      {"hello\n", "$MeshFormat"},
      {"$MeshFormat\n1.0 0 8\n$EndMeshFormat\n", "version 1.0"},
      {"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "no nodes"},
      {replaced(two_squares, "$Nodes\n8", "$Nodes\n7"), "$EndNodes is expected"},
      {replaced(two_squares, "20 5 5 1\n", "1 5 5 1\n"), "exists already"},
      {replaced(two_squares, "20 5 5 1\n", "20 5,0 5,0 1,0\n"), "numbers with a decimal point"},
      {replaced(two_squares, "20 5 5 1\n", "20 5 5\n"), "three coordinates are expected here"},
      {replaced(two_squares, "7 2 2 2 2 2 4 5", "7 2 2 2 2 2 4"), "has 3 nodes"},
      {replaced(two_squares, "4 2 1 0", "4 2 1 0.5"), "z = 0.5"},
      {replaced(two_squares, "6 2 2 2 2 2 13 4", "6 2 2 2 2 2 13 77"), "77"},
      {replaced(two_squares, "6 2 2 2 2 2 13 4", "6 2 2 2 2 2 13 13"), "twice"},
      {replaced(two_squares, "13 2 0 0", "13 1.5 0.5 0"), "degenerate"},
      {replaced(two_squares, "7 2 2 2 2 2 4 5", "7 4 2 2 2 2 4 5 1"), "plane and volume cells are mixed"},
      {replaced(two_squares, "7 2 2 2 2 2 4 5", "7 10 2 2 2 1 2 5 6 4 9 20 13 4"), "not supported"},
      {std::string(two_squares).substr(0, 300), ""},
  };
  for (const auto& [text, reason] : cases) {
    const File file(text);
    const std::string message = error_of(file.path());
    EXPECT_EQ(message.find(file.path()), 0u) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
}

TEST(ReadMsh, TruncatedFilesAreErrors) {
  const std::string text = two_squares;
  for (std::size_t length = 0; length + 14 < text.size(); length += 7) {
    const File file(text.substr(0, length));
    EXPECT_THROW(read_msh(file.path()), InputError) << length;
  }
}

TEST(ReadMsh, WhatGmshItselfWrites) {
  const std::string path = (std::filesystem::temp_directory_path() / "berm_round_trip.msh").string();
  for (double version : {2.2, 4.1})
    for (bool binary : {false, true})
      for (int order : {1, 2}) {
        with_gmsh("round trip", [&] {
          namespace geo = gmsh::model::geo;
          gmsh::option::setNumber("Mesh.MshFileVersion", version);
          gmsh::option::setNumber("Mesh.Binary", binary);
          gmsh::option::setNumber("Mesh.ElementOrder", order);
          gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 1);
          gmsh::option::setNumber("Mesh.RecombineAll", 0);
          const int p[] = {geo::addPoint(0, 0, 0, 0.2), geo::addPoint(2, 0, 0, 0.2), geo::addPoint(2, 1, 0, 0.2),
                           geo::addPoint(0, 1, 0, 0.2)};
          std::vector<int> lines;
          for (int i = 0; i < 4; ++i) lines.push_back(geo::addLine(p[i], p[(i + 1) % 4]));
          const int surface = geo::addPlaneSurface({geo::addCurveLoop(lines)});
          geo::synchronize();
          gmsh::model::setPhysicalName(2, gmsh::model::addPhysicalGroup(2, {surface}), "plate");
          gmsh::model::setPhysicalName(1, gmsh::model::addPhysicalGroup(1, {lines[2]}), "top");
          gmsh::model::mesh::generate(2);
          gmsh::write(path);
          return Mesh();
        });
        const Mesh mesh = read_msh(path);
        EXPECT_TRUE(all_of_kind(mesh, order == 1 ? CellKind::tri3 : CellKind::tri6));
        EXPECT_NEAR(total_area(mesh), 2.0, 1e-12);
        EXPECT_EQ(mesh.cell_groups.at("plate").size(), static_cast<std::size_t>(mesh.n_cells()));
        EXPECT_EQ(mesh.node_groups.at("top").size(), order == 1 ? 11u : 21u);
        for (int n : mesh.node_groups.at("top")) EXPECT_NEAR(mesh.nodes[n].y(), 1.0, 1e-12);
      }
  std::filesystem::remove(path);
}

TEST(MeshShape, StructuredDiscIsSymmetricAndFillsTheDisc) {
  for (int order : {1, 2}) {
    const Mesh mesh = mesh_shape(disc(0.3, -0.2, 0.075), options(BodyMeshKind::quads, 0.005, order, true));
    EXPECT_EQ(mesh.n_cells(), 27 * 27);  // round(sqrt(pi) R / h) = 27
    double area = 0.0;
    Vec3 moment = Vec3::Zero();
    for (int c = 0; c < mesh.n_cells(); ++c) {
      EXPECT_GT(cell_measure(mesh, c), 0.0);
      area += cell_measure(mesh, c);
    }
    for (const Vec3& x : mesh.nodes) moment += x - Vec3(0.3, -0.2, 0.0);
    EXPECT_NEAR(area / (std::numbers::pi * 0.075 * 0.075), 1.0, 0.003);
    EXPECT_NEAR(moment.norm(), 0.0, 1e-12);
  }
}

TEST(MeshShape, StructuredBox) {
  const Mesh quads = mesh_shape(box(0, -1, 2, 0), options(BodyMeshKind::quads, 0.26, 1, true));
  EXPECT_EQ(quads.n_cells(), 8 * 4);
  EXPECT_TRUE(all_of_kind(quads, CellKind::quad4));
  EXPECT_NEAR(total_area(quads), 2.0, 1e-14);

  const Mesh triangles = mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::triangles, 0.5, 1, true));
  EXPECT_EQ(triangles.n_cells(), 8);
  std::vector<int> valence(triangles.n_nodes(), 0);
  for (int n : triangles.connectivity) ++valence[n];
  EXPECT_EQ(*std::max_element(valence.begin(), valence.end()), 8);  // union jack: all meet in the centre
}

TEST(MeshShape, StructuredQuadratic) {
  const Mesh quads = mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::quads, 0.5, 2, true));
  EXPECT_TRUE(all_of_kind(quads, CellKind::quad8));
  EXPECT_EQ(quads.n_nodes(), 9 + 12);
  expect_mid_sides(quads, 1e-15);
  const Mesh triangles = mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::triangles, 0.5, 2, true));
  EXPECT_TRUE(all_of_kind(triangles, CellKind::tri6));
  EXPECT_EQ(triangles.n_nodes(), 25);
  expect_mid_sides(triangles, 1e-15);
}

TEST(MeshShape, StructuredSlits) {
  const Mesh mesh = mesh_shape(slit_specimen(), options(BodyMeshKind::quads, 0.005, 1, true));
  EXPECT_EQ(mesh.n_cells(), (15 + 1 + 29 + 1 + 15) * 30 - 4 * 4);
  EXPECT_NEAR(total_area(mesh), 0.045 - 4e-4, 1e-14);
  double length = 0.0;
  for (const CellFace& e : boundary_faces(mesh))
    length += (mesh.nodes[mesh.cell(e.cell)[e.local]] - mesh.nodes[mesh.cell(e.cell)[(e.local + 1) % 4]]).norm();
  EXPECT_NEAR(length, 0.9 + 8 * 0.02, 1e-13);
  const PlaneShape triangle{Polygon{{Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}}};
  EXPECT_THROW(mesh_shape(triangle, options(BodyMeshKind::quads, 0.1, 1, true)), InputError);
}

TEST(MeshShape, DiscOfQuads) {
  for (double h : {0.01, 0.005, 0.0025}) {
    const Mesh mesh = mesh_shape(disc(0.1, 0.2, 0.075), options(BodyMeshKind::quads, h));
    const double expected = std::acos(-1.0) * 0.075 * 0.075 / (h * h);
    EXPECT_TRUE(all_of_kind(mesh, CellKind::quad4));
    EXPECT_NEAR(mesh.n_cells(), expected, 0.15 * expected);
    EXPECT_GT(worst_corner(mesh), 0.5);
    EXPECT_NEAR(total_area(mesh), std::acos(-1.0) * 0.075 * 0.075, 4e-3 * 0.0177);
    for (const CellFace& e : boundary_faces(mesh))
      EXPECT_NEAR((mesh.nodes[mesh.cell(e.cell)[e.local]] - Vec3(0.1, 0.2, 0.0)).norm(), 0.075, 1e-12);
  }
}

TEST(MeshShape, QuadraticDiscFollowsTheArc) {
  for (BodyMeshKind kind : {BodyMeshKind::quads, BodyMeshKind::triangles}) {
    const Mesh mesh = mesh_shape(disc(0, 0, 0.075), options(kind, 0.01, 2));
    EXPECT_TRUE(all_of_kind(mesh, kind == BodyMeshKind::quads ? CellKind::quad8 : CellKind::tri6));
    EXPECT_GT(worst_corner(mesh), 0.4);
    for (const CellFace& e : boundary_faces(mesh)) {
      const int mid = mesh.cell(e.cell)[corners_of(mesh.kinds[e.cell]) + e.local];
      EXPECT_NEAR(mesh.nodes[mid].norm(), 0.075, 1e-6);
    }
  }
}

TEST(MeshShape, QuadsAroundCornersHolesAndSlits) {
  const PlaneShape shapes[] = {
      slit_specimen(),
      minus({box(-0.1, -0.1, 0.1, 0.1), disc(0, 0, 0.03)}),
      {Polygon{{{0, 0}, {0.5, 0}, {0.5, 0.5}, {0.25, 0.5}, {0.25, 0.25}, {0, 0.25}}}},
      {Combination{Combination::Kind::join, {box(0, 0, 0.1, 0.1), box(0.1, 0, 0.2, 0.05), disc(0.05, 0.1, 0.05)}}},
  };
  for (const PlaneShape& shape : shapes) {
    const double area = PlaneRegion(shape).area(), h = std::sqrt(area / 900.0);
    const Mesh mesh = mesh_shape(shape, options(BodyMeshKind::quads, h));
    EXPECT_TRUE(all_of_kind(mesh, CellKind::quad4));
    EXPECT_NEAR(mesh.n_cells(), 900, 225);
    EXPECT_GT(worst_corner(mesh), 0.3);
    EXPECT_NEAR(total_area(mesh), area, 2e-3 * area);
  }
}

TEST(MeshShape, Triangles) {
  const Mesh mesh = mesh_shape(disc(0, 0, 0.075), options(BodyMeshKind::triangles, 0.005));
  const double expected = std::acos(-1.0) * 0.075 * 0.075 / (std::sqrt(3.0) / 4.0 * 0.005 * 0.005);
  EXPECT_TRUE(all_of_kind(mesh, CellKind::tri3));
  EXPECT_NEAR(mesh.n_cells(), expected, 0.2 * expected);
  EXPECT_GT(worst_corner(mesh), 0.5);
}

TEST(MeshShape, Deterministic) {
  const auto once = [] { return mesh_shape(slit_specimen(), options(BodyMeshKind::quads, 0.01)); };
  const Mesh first = once();
  mesh_shape(disc(0, 0, 1), options(BodyMeshKind::triangles, 0.3));
  const Mesh second = once();
  ASSERT_EQ(first.connectivity, second.connectivity);
  for (int n = 0; n < first.n_nodes(); ++n) EXPECT_EQ(first.nodes[n], second.nodes[n]);
}

TEST(MeshShape, CoarserThanTheShape) {
  const Mesh mesh = mesh_shape(disc(0, 0, 0.075), options(BodyMeshKind::quads, 0.2));
  EXPECT_GT(mesh.n_cells(), 0);
  EXPECT_TRUE(all_of_kind(mesh, CellKind::quad4));
  EXPECT_EQ(mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::quads, 5.0, 1, true)).n_cells(), 1);
}

TEST(MeshShape, RefusesBadOptions) {
  EXPECT_THROW(mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::quads, 0.0)), InputError);
  EXPECT_THROW(mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::quads, 0.1, 3)), InputError);
  EXPECT_THROW(mesh_shape(box(0, 0, 1, 1), options(BodyMeshKind::quads, 1e-5)), InputError);
  EXPECT_THROW(mesh_shape(box(0, 0, 1, 0), options(BodyMeshKind::quads, 0.1)), InputError);
}
