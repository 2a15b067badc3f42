#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <cstring>
#include <fstream>

#include "base/error.hpp"
#include "mesh/gmsh_solid.hpp"
#include "mesh/solid_region.hpp"

using namespace berm;

namespace {

using Facet = std::array<Vec3, 3>;

std::vector<Facet> facets_of(const TriangleSurface& surface) {
  std::vector<Facet> facets;
  for (int t = 0; t < surface.n_triangles(); ++t)
    facets.push_back({surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)});
  return facets;
}

std::vector<Facet> cube(const Vec3& low = Vec3::Zero(), double edge = 1.0) {
  constexpr int corners[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                  {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  const auto at = [&](int c) -> Vec3 { return low + edge * Vec3((c + 1) / 2 % 2, c / 2 % 2, c / 4); };  // VTK order
  std::vector<Facet> facets;
  for (const auto& c : corners) facets.push_back({at(c[0]), at(c[1]), at(c[2])});
  return facets;
}

std::string ascii(const std::vector<Facet>& facets) {
  std::string text = "solid a name with words\n";
  char line[200];
  for (const Facet& f : facets) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const Vec3& x : f) {
      std::snprintf(line, sizeof line, "   vertex %.17g %.17g %.17e\n", x.x(), x.y(), x.z());
      text += line;
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid a name with words\n";
}

std::string binary(const std::vector<Facet>& facets, const std::string& title = "binary surface") {
  std::string bytes = title;
  bytes.resize(80, '\0');
  const auto put = [&](const void* data, std::size_t n) { bytes.append(static_cast<const char*>(data), n); };
  const auto count = static_cast<std::uint32_t>(facets.size());
  put(&count, 4);
  for (const Facet& f : facets) {
    bytes.append(12, '\0');
    for (const Vec3& x : f)
      for (int d = 0; d < 3; ++d) {
        const auto value = static_cast<float>(x[d]);
        put(&value, 4);
      }
    bytes.append(2, '\0');
  }
  return bytes;
}

class Stl : public ::testing::Test {
protected:
  std::string write(const std::string& content) const {
    const std::string path =
        ::testing::TempDir() + "stl_test_" + ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".stl";
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }
  TriangleSurface read(const std::string& content) const { return read_stl(write(content)); }
  /// What the refusal says; it names the file.
  std::string refusal(const std::string& content) const {
    const std::string path = write(content);
    try {
      read_stl(path);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.rfind(path + ": ", 0), 0u) << message;
      return message.substr(path.size() + 2);
    }
    return "accepted";
  }
};

bool has(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_F(Stl, PassesThroughItself) {
  std::vector<Facet> pulled = cube();  // its last corner through the first one
  for (Facet& f : pulled)
    for (Vec3& x : f)
      if (x == Vec3::Ones()) x = Vec3::Constant(-0.3);
  EXPECT_NE(refusal(ascii(pulled)).find("passes through itself"), std::string::npos);
  for (Facet& f : pulled)
    for (Vec3& x : f)
      if (x == Vec3::Constant(-0.3)) x = Vec3::Constant(0.3);  // a dent
  EXPECT_EQ(read(ascii(pulled)).n_triangles(), 12);
}

TEST_F(Stl, AsciiRoundTrip) {
  const TriangleSurface original = triangulate({Sphere{Vec3(1, 2, 3), 0.5}}, 0.1);
  const TriangleSurface back = read(ascii(facets_of(original)));
  EXPECT_EQ(back.vertices.size(), original.vertices.size());
  EXPECT_EQ(facets_of(back), facets_of(original));
  EXPECT_NEAR(volume(back), volume(original), 1e-15);
  EXPECT_NEAR(back.normals[5].dot(original.normals[5]), 1.0, 1e-2);
}

TEST_F(Stl, BinaryRoundTrip) {
  const TriangleSurface original = triangulate({Cylinder{Vec3(0, 0, 0), Vec3(0, 0, 0.2), 0.05}}, 0.01);
  for (const char* title : {"binary surface", "solid that begins like a text"}) {
    const TriangleSurface back = read(binary(facets_of(original), title));
    EXPECT_EQ(back.vertices.size(), original.vertices.size());
    EXPECT_EQ(back.triangles.size(), original.triangles.size());
    EXPECT_NEAR(volume(back), volume(original), 1e-6 * volume(original));
  }
}

TEST_F(Stl, VerticesAlmostAlikeAreOne) {
  std::vector<Facet> facets = cube();
  facets[3][1] += Vec3(3e-10, -3e-10, 3e-10);
  EXPECT_EQ(read(ascii(facets)).vertices.size(), 8u);
  facets[3][1] += Vec3(1e-7, 0, 0);
  EXPECT_PRED2(has, refusal(ascii(facets)), "not closed");
}

TEST_F(Stl, InsideOutIsTurned) {
  std::vector<Facet> facets = cube();
  for (Facet& f : facets) std::swap(f[0], f[1]);
  const SolidRegion r(read(ascii(facets)));
  EXPECT_NEAR(r.volume(), 1.0, 1e-14);
  EXPECT_TRUE(r.contains({0.5, 0.5, 0.5}));
  EXPECT_LT((r.nearest({2, 0.3, 0.6}).normal - Vec3(1, 0, 0)).norm(), 1e-14);
}

TEST_F(Stl, SeveralPartsAndCavities) {
  std::vector<Facet> facets = cube();
  for (const Facet& f : cube(Vec3(2, 0, 0))) facets.push_back(f);
  for (Facet f : cube(Vec3(0.25, 0.25, 0.25), 0.5)) facets.push_back({f[1], f[0], f[2]});
  EXPECT_NEAR(volume(read(ascii(facets))), 2.0 - 0.125, 1e-14);
  // A part that is inside out, and one inside of another.
  std::vector<Facet> wrong = cube(Vec3(0, 0, 0), 2.0);
  for (const Facet& f : cube(Vec3(5, 0, 0))) wrong.push_back({f[1], f[0], f[2]});
  EXPECT_PRED2(has, refusal(ascii(wrong)), "is inside out");
  wrong = cube();
  for (const Facet& f : cube(Vec3(0.25, 0.25, 0.25), 0.5)) wrong.push_back(f);
  EXPECT_PRED2(has, refusal(ascii(wrong)), "lies inside of another one");
}

TEST_F(Stl, BadSurfaces) {
  std::vector<Facet> facets = cube();
  facets.pop_back();
  EXPECT_PRED2(has, refusal(ascii(facets)), "not closed: 3 open edge(s), the first one at (");
  facets = cube();
  std::swap(facets[4][0], facets[4][1]);
  EXPECT_PRED2(has, refusal(ascii(facets)), "run against each other at 3 edge(s)");
  facets = cube();
  facets.push_back(facets[2]);
  EXPECT_PRED2(has, refusal(binary(facets)), "the same corners");
  facets = cube();
  for (const Facet& f : cube(Vec3(1, 1, 0))) facets.push_back(f);  // touches along the edge x = y = 1
  EXPECT_PRED2(has, refusal(ascii(facets)),
               "1 edge(s) belong to more than two triangles, the first one at (1, 1, 0.5)");
  facets = cube();
  facets[6][1] = facets[6][0];
  EXPECT_PRED2(has, refusal(ascii(facets)), "triangle 7 at");
  facets = cube();
  facets[6][1] = 0.5 * (facets[6][0] + facets[6][2]);
  EXPECT_PRED2(has, refusal(ascii(facets)), "degenerate");
  facets = cube();
  facets[1][0].y() = std::nan("");
  EXPECT_PRED2(has, refusal(ascii(facets)), "triangle 2 has a coordinate that is not a finite number");
  EXPECT_PRED2(has, refusal(binary(facets)), "not a finite number");
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(1, 1, 0), d(0, 1, 0);
  EXPECT_PRED2(has, refusal(ascii({{a, b, c}, {a, c, d}, {a, d, b}, {b, d, c}})), "encloses no volume");
}

TEST_F(Stl, BadFiles) {
  EXPECT_PRED2(has, refusal(""), "is empty");
  EXPECT_PRED2(has, refusal("# a list of points\n1 2 3\n"), "is not an STL file");
  EXPECT_PRED2(has, refusal("solid x\nendsolid x\n"), "no triangles");
  EXPECT_PRED2(has, refusal(binary({})), "no triangles");
  const std::string bytes = binary(cube()), words = ascii(cube());
  EXPECT_PRED2(has, refusal(bytes.substr(0, bytes.size() - 30)), "is truncated: 12 triangles need 684 bytes");
  EXPECT_PRED2(has, refusal(bytes.substr(0, 82)), "is truncated");
  EXPECT_PRED2(has, refusal(binary(cube(), "solid").substr(0, 300)), "is truncated");
  for (std::size_t n : {std::size_t{30}, words.size() / 2, words.size() - 30})
    EXPECT_PRED2(has, refusal(words.substr(0, n)), "line ");
  EXPECT_PRED2(has, refusal("solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\n"),
               "line 4: \"zero\" where a number should be");
  EXPECT_THROW(read_stl(::testing::TempDir()), InputError);
  EXPECT_THROW(read_stl("/nowhere/at/all.stl"), InputError);
}

TEST_F(Stl, MeshOfItsInside) {
  const std::string path = write(ascii(cube()));
  for (int order : {1, 2}) {
    const SolidMesh mesh = mesh_solid({SurfaceFile{path}}, 0.25, order);
    double total = 0.0;
    for (std::size_t c = 0; c < mesh.connectivity.size(); c += mesh.nodes_per_cell) {
      const auto x = [&](int i) { return mesh.nodes[mesh.connectivity[c + i]]; };
      total += (x(1) - x(0)).dot((x(2) - x(0)).cross(x(3) - x(0))) / 6.0;
      if (order == 2) {
        EXPECT_LT((x(8) - 0.5 * (x(1) + x(3))).norm(), 1e-12);
        EXPECT_LT((x(9) - 0.5 * (x(2) + x(3))).norm(), 1e-12);
      }
    }
    EXPECT_NEAR(total, 1.0, 1e-12);
    EXPECT_GT(mesh.connectivity.size() / mesh.nodes_per_cell, 300u);
  }
}

TEST_F(Stl, MeshOfPartsAndCavities) {
  const auto filled = [&](const std::vector<Facet>& facets) {
    const SolidMesh mesh = mesh_solid({SurfaceFile{write(ascii(facets))}}, 0.25, 1);
    double total = 0.0;
    for (std::size_t c = 0; c < mesh.connectivity.size(); c += 4) {
      const auto x = [&](int i) { return mesh.nodes[mesh.connectivity[c + i]]; };
      total += (x(1) - x(0)).dot((x(2) - x(0)).cross(x(3) - x(0))) / 6.0;
    }
    return total;
  };
  std::vector<Facet> facets = cube();
  for (Facet f : cube(Vec3(0.25, 0.25, 0.25), 0.5)) facets.push_back({f[1], f[0], f[2]});
  EXPECT_NEAR(filled(facets), 0.875, 1e-12);
  for (const Facet& f : cube(Vec3(2, 0, 0))) facets.push_back(f);
  EXPECT_NEAR(filled(facets), 1.875, 1e-12);
}
