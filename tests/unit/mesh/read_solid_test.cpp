#include <fmt/format.h>
#include <gmsh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "mesh/gmsh.hpp"
#include "mesh/gmsh_model.hpp"
#include "msh_file.hpp"
#include "solid_cells.hpp"

using namespace berm;
using msh_file::error_of;
using msh_file::File;
using msh_file::replaced;

namespace {

std::string text_of(const std::vector<Vec3>& nodes, const std::vector<std::string>& elements) {
  std::string text = fmt::format("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{}\n", nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    text += fmt::format("{} {} {} {}\n", i + 1, nodes[i].x(), nodes[i].y(), nodes[i].z());
  text += fmt::format("$EndNodes\n$Elements\n{}\n", elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) text += fmt::format("{} {}\n", i + 1, elements[i]);
  return text + "$EndElements\n";
}

const std::vector<Vec3> cube = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};

/// A cube and a tetrahedron on half of its top (not conforming there, which reading does not mind).
const std::string cube_and_tetrahedron() {
  std::vector<Vec3> nodes = cube;
  nodes.emplace_back(0, 0, 2);
  std::string text = text_of(nodes, {"5 2 1 1 1 2 3 4 5 6 7 8", "4 2 2 2 5 6 8 9", "3 2 3 3 1 2 3 4"});
  return replaced(text, "$Nodes",
                  "$PhysicalNames\n3\n3 1 \"block\"\n3 2 \"cap\"\n2 3 \"base\"\n$EndPhysicalNames\n$Nodes");
}

/// A box [0, 1] x [0, 2] x [0, 3] by Gmsh, written to `path`.
void write_box(const std::string& path, bool hexahedra, int order, double version, bool binary) {
  with_gmsh("round trip", [&] {
    namespace geo = gmsh::model::geo;
    gmsh::option::setNumber("Mesh.MshFileVersion", version);
    gmsh::option::setNumber("Mesh.Binary", binary);
    gmsh::option::setNumber("Mesh.ElementOrder", order);
    gmsh::option::setNumber("Mesh.SecondOrderIncomplete", 1);
    gmsh::option::setNumber("Mesh.RecombineAll", 0);
    gmsh::option::setNumber("Mesh.MeshSizeMax", 1.5);
    const int p[] = {geo::addPoint(0, 0, 0), geo::addPoint(1, 0, 0), geo::addPoint(1, 2, 0), geo::addPoint(0, 2, 0)};
    std::vector<int> lines;
    for (int i = 0; i < 4; ++i) lines.push_back(geo::addLine(p[i], p[(i + 1) % 4]));
    const int base = geo::addPlaneSurface({geo::addCurveLoop(lines)});
    if (hexahedra) {
      for (int line : lines) geo::mesh::setTransfiniteCurve(line, 4);
      geo::mesh::setTransfiniteSurface(base);
      geo::mesh::setRecombine(2, base);
    }
    gmsh::vectorpair out;
    geo::extrude({{2, base}}, 0, 0, 3, out, hexahedra ? std::vector<int>{4} : std::vector<int>{}, {}, hexahedra);
    geo::synchronize();
    gmsh::model::setPhysicalName(3, gmsh::model::addPhysicalGroup(3, {out[1].second}), "block");
    gmsh::model::setPhysicalName(2, gmsh::model::addPhysicalGroup(2, {out[0].second}), "top");
    gmsh::model::mesh::generate(3);
    gmsh::write(path);
    return Mesh();
  });
}

}  // namespace

TEST(ReadSolidMsh, CellsNodesAndGroups) {
  const File file(cube_and_tetrahedron());
  const Mesh mesh = read_msh(file.path());
  EXPECT_EQ(mesh.dimension(), 3);
  ASSERT_EQ(mesh.n_cells(), 2);  // the base's quad is no cell
  EXPECT_EQ(mesh.n_nodes(), 9);
  EXPECT_NEAR(solid_cells::volume(mesh), 1.0 + 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(cell_measure(mesh, mesh.cell_groups.at("block").at(0)), 1.0, 1e-15);
  EXPECT_NEAR(cell_measure(mesh, mesh.cell_groups.at("cap").at(0)), 1.0 / 6.0, 1e-15);
  EXPECT_EQ(mesh.cell_groups.count("base"), 0u);
  ASSERT_EQ(mesh.node_groups.at("base").size(), 4u);
  for (int n : mesh.node_groups.at("base")) EXPECT_EQ(mesh.nodes[n].z(), 0.0);
}

TEST(ReadSolidMsh, WhatGmshItselfWrites) {
  const std::string path = (std::filesystem::temp_directory_path() / "berm_solid_round_trip.msh").string();
  for (bool hexahedra : {false, true})
    for (int order : {1, 2})
      for (double version : {2.2, 4.1})
        for (bool binary : {false, true}) {
          write_box(path, hexahedra, order, version, binary);
          const Mesh mesh = read_msh(path);
          const CellKind kind = hexahedra ? (order == 1 ? CellKind::hex8 : CellKind::hex20)
                                          : (order == 1 ? CellKind::tet4 : CellKind::tet10);
          EXPECT_EQ(std::count(mesh.kinds.begin(), mesh.kinds.end(), kind), mesh.n_cells());
          EXPECT_NEAR(solid_cells::volume(mesh), 6.0, 1e-12);
          solid_cells::expect_mid_sides(mesh, 1e-11);
          for (int c = 0; c < mesh.n_cells(); ++c) EXPECT_GT(smallest_corner_jacobian(mesh, c), 0.05);
          EXPECT_EQ(mesh.cell_groups.at("block").size(), static_cast<std::size_t>(mesh.n_cells()));
          const auto on_top = std::count_if(mesh.nodes.begin(), mesh.nodes.end(),
                                            [](const Vec3& x) { return std::abs(x.z() - 3.0) < 1e-9; });
          EXPECT_EQ(static_cast<long>(mesh.node_groups.at("top").size()), on_top);
          for (int n : mesh.node_groups.at("top")) EXPECT_NEAR(mesh.nodes[n].z(), 3.0, 1e-12);
          if (hexahedra) {
            EXPECT_EQ(mesh.n_cells(), 3 * 3 * 4);
            EXPECT_EQ(on_top, order == 1 ? 16 : 16 + 24);
          }
        }
  std::filesystem::remove(path);
}

TEST(ReadSolidMsh, InvertedCellsAreTurned) {
  const std::vector<Vec3> corners4 = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  // Gmsh's edges, with mid-sides a little off the middle, each in a way of its own.
  const int edges4[6][2] = {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}};
  const int edges8[12][2] = {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3},
                             {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}};
  for (bool hexahedron : {false, true})
    for (bool quadratic : {false, true})
      for (bool mirrored : {false, true}) {
        std::vector<Vec3> nodes = hexahedron ? cube : corners4;
        const auto middle = [&](const int* e) { return 0.5 * (nodes[e[0]] + nodes[e[1]]); };
        const int n_edges = hexahedron ? 12 : 6;
        for (int e = 0; quadratic && e < n_edges; ++e)
          nodes.push_back(middle(hexahedron ? edges8[e] : edges4[e]) + 0.002 * (e + 1) * Vec3(0.5, 1.0, -1.0));
        std::string element = hexahedron ? (quadratic ? "17 2 0 1" : "5 2 0 1") : (quadratic ? "11 2 0 1" : "4 2 0 1");
        for (std::size_t i = 1; i <= nodes.size(); ++i) element += fmt::format(" {}", i);
        if (mirrored)
          for (Vec3& x : nodes) x.x() = -x.x();
        const File file(text_of(nodes, {element}));
        const Mesh mesh = read_msh(file.path());
        ASSERT_EQ(mesh.n_cells(), 1);
        static double right_handed = 0.0;
        const double volume = solid_cells::volume(mesh);
        if (!mirrored) right_handed = volume;
        EXPECT_NEAR(volume, right_handed, 1e-14);
        EXPECT_NEAR(volume, hexahedron ? 1.0 : 1.0 / 6.0, quadratic ? 0.03 : 1e-15);
        EXPECT_GT(smallest_corner_jacobian(mesh, 0), 0.3);
        solid_cells::expect_mid_sides(mesh, 0.05);
      }
}

TEST(ReadSolidMsh, PlaneCellsThatAreNoFacesAreRefused) {
  const std::string good = cube_and_tetrahedron();
  const File file(replaced(good, "3 3 2 3 3 1 2 3 4", "3 2 2 3 3 1 2 3"));
  const std::string message = error_of(file.path());
  EXPECT_NE(message.find("plane and volume cells are mixed: the plane cell at (0, 0, 0)"), std::string::npos)
      << message;
}

TEST(ReadSolidMsh, ErrorsNameFileAndReason) {
  const std::string good = cube_and_tetrahedron();
  const std::pair<std::string, const char*> cases[] = {
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 4 2 2 2 5 6 8"), "an element of type 4 has 4 nodes"},
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 4 2 2 2 5 6 8 77"), "77"},
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 4 2 2 2 5 6 8 8"), "twice"},
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 6 2 2 2 1 2 4 5 6 8"), "element type 6 (6-node prism) is not supported"},
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 7 2 2 2 5 6 7 8 9"), "element type 7 (5-node pyramid) is not supported"},
      {replaced(good, "2 4 2 2 2 5 6 8 9", "2 99 2 2 2 5"), "tetrahedra of 4 and 10, hexahedra of 8 and 20"},
      {replaced(good, "9 0 0 2", "9 0 0 1.0000001"), "degenerate cell at ("},
      {replaced(good, "7 1 1 1", "7 0.2 0.2 0.2"), "degenerate cell at ("},
      {replaced(good, "9 0 0 2", "9 0 0 nan"), ""},
  };
  for (const auto& [text, reason] : cases) {
    const File file(text);
    const std::string message = error_of(file.path());
    EXPECT_EQ(message.find(file.path()), 0u) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
}

TEST(ReadSolidMsh, TruncatedFilesAreErrors) {
  const std::string text = cube_and_tetrahedron();
  for (std::size_t length = 0; length + 14 < text.size(); length += 7) {
    const File file(text.substr(0, length));
    EXPECT_THROW(read_msh(file.path()), InputError) << length;
  }
}

TEST(ReadSolidMsh, MalformedFilesOfTheProgramsTests) {
  const std::string folder = std::string(BERM_SOURCE_DIR) + "/tests/bad_input/mesh/";
  const std::pair<const char*, const char*> cases[] = {
      {"prism.msh", "element type 6 (6-node prism) is not supported"},
      {"pyramid.msh", "element type 7 (5-node pyramid) is not supported"},
      {"full_hexahedron.msh", "element type 12 (27-node hexahedron) is not supported"},
      {"mixed_cells.msh", "plane and volume cells are mixed: the plane cell at (1, 0, 0)"},
      {"flat_tetrahedron.msh", "degenerate cell at (0, 0, 0)"},
      {"inverted_corner.msh", "degenerate cell at (0, 0, 0)"},
      {"only_lines.msh", "has no plane cells"},
      {"no_elements.msh", "has no plane cells"},
  };
  for (const auto& [name, reason] : cases) {
    const std::string message = error_of(folder + name);
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
  EXPECT_EQ(read_msh(folder + "tetrahedron.msh").dimension(), 3);
}
