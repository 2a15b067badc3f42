#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "base/error.hpp"
#include "io/vtu.hpp"
#include "temporary_folder.hpp"

namespace berm {
namespace {

class Vtu : public TemporaryFolder {};

/// Two quadratic triangles, a triangle and a quad on shared points; tests/python/test_vtu.py knows the same numbers.
VtuData mixed_mesh() {
  VtuData data;
  for (int i = 0; i < 12; ++i) data.points.emplace_back(0.1 * i, 1.0 / (i + 1), 0.0);
  data.connectivity = {0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 1, 10, 11};
  data.offsets = {6, 9, 13};
  data.types = {vtk_quadratic_triangle, vtk_triangle, vtk_quad};
  std::vector<double> displacement;
  for (int i = 0; i < 36; ++i) displacement.push_back(std::sin(1.0 * i));
  data.point_fields = {{"displacement", 3, displacement}};
  data.cell_fields = {{"body", 1, std::vector<int>{-7, 0, 2147483647}},
                      {"a<b & \"c\"", 1, std::vector<double>{1e-300, 0.1, -1e300}}};
  return data;
}

/// One cell of every solid kind, the linear ones on the corners of the quadratic ones; 64-bit numbers.
VtuData solid_mesh() {
  VtuData data;
  const std::vector<Vec3> tetrahedron = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},  {0, 0, 1},   {.5, 0, 0},
                                         {.5, .5, 0}, {0, .5, 0}, {0, 0, .5}, {.5, 0, .5}, {0, .5, .5}};
  const std::vector<Vec3> hexahedron = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {0, 0, 2}, {2, 0, 2}, {2, 2, 2},
                                        {0, 2, 2}, {1, 0, 0}, {2, 1, 0}, {1, 2, 0}, {0, 1, 0}, {1, 0, 2}, {2, 1, 2},
                                        {1, 2, 2}, {0, 1, 2}, {0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};
  data.points = tetrahedron;
  for (const Vec3& x : hexahedron) data.points.push_back(x + Vec3(3, 0, 0));
  const auto add = [&](VtkType type, int first, int n) {
    for (int i = 0; i < n; ++i) data.connectivity.push_back(first + i);
    data.offsets.push_back(static_cast<int>(data.connectivity.size()));
    data.types.push_back(type);
  };
  add(vtk_tetra, 0, 4);
  add(vtk_quadratic_tetra, 0, 10);
  add(vtk_hexahedron, 10, 8);
  add(vtk_quadratic_hexahedron, 10, 20);
  for (int i = 0; i < 4; ++i) data.connectivity.push_back(std::array{10, 11, 12, 13}[i]);
  data.offsets.push_back(static_cast<int>(data.connectivity.size()));
  data.types.push_back(vtk_quad);
  std::vector<std::int64_t> id;
  for (int i = 0; i < 30; ++i) id.push_back((std::int64_t(1) << 53) + 1 - i);
  data.point_fields = {{"id", 1, id}};
  data.cell_fields = {{"pair", 2,
                       std::vector<std::int64_t>{1, -1, std::numeric_limits<std::int64_t>::max(),
                                                 std::numeric_limits<std::int64_t>::min(), 0, 5, 6, 7, 8, 9}}};
  return data;
}

/// More than one compressed block (1 MiB) per array, the last one not full.
VtuData cloud(int n) {
  std::vector<Vec3> points;
  std::vector<double> stress;
  for (int i = 0; i < n; ++i) {
    points.emplace_back(i, 0.5 * i, 0.0);
    for (int k = 0; k < 6; ++k) stress.push_back(1e6 * i + k);
  }
  VtuData data = vertices(std::move(points));
  data.point_fields = {{"stress", 6, std::move(stress)}};
  return data;
}

TEST_F(Vtu, VtkReadsEveryValue) {
  write_vtu(path("mixed.vtu"), mixed_mesh());
  write_vtu(path("cloud.vtu"), cloud(100001));
  write_vtu(path("block.vtu"), cloud(131072));  // connectivity and offsets fill their last block exactly
  write_vtu(path("empty.vtu"), vertices({}));
  write_vtu(path("solid.vtu"), solid_mesh());
  // A distributed cloud: three processes, one of them without points.
  for (const auto& [name, n] : {std::pair{"part_0.vtu", 5}, std::pair{"part_1.vtu", 0}, std::pair{"part<2>.vtu", 3}}) {
    VtuData part = vertices(std::vector<Vec3>(n, Vec3(n, 0, 1)));
    part.point_fields = {{"id", 1, std::vector<std::int64_t>(n, 10000000000 + n)},
                         {"stress", 6, std::vector<double>(6 * n, 0.5 * n)},
                         {"a<b", 1, std::vector<int>(n, n)}};
    write_vtu(path(name), part);
    if (n == 5) write_pvtu(path("whole.pvtu"), part, {"part_0.vtu", "part_1.vtu", "part<2>.vtu"});
  }
  PvdWriter series(path("series.pvd"));
  series.add(0.0, "mixed.vtu");
  series.add(1.0 / 3.0, "cloud.vtu");

  const std::string source = BERM_SOURCE_DIR;
  const std::string command = fmt::format(
      "BERM_VTU_SAMPLES='{}' PYTHONPATH='{}/python' /usr/bin/python3 -m unittest discover -s '{}/tests/python' -p "
      "test_vtu.py",
      path(""), source, source);
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST_F(Vtu, ListOfPiecesHoldsTheFieldsOnce) {
  write_pvtu(path("w.pvtu"), solid_mesh(), {"a/0.vtu", "a/1.vtu"});
  const std::string text = content(path("w.pvtu"));
  for (
      const char* line :
      {"<PUnstructuredGrid GhostLevel=\"0\">\n",
       "    <PPointData>\n      <PDataArray type=\"Int64\" Name=\"id\" NumberOfComponents=\"1\"/>\n    </PPointData>\n",
       "    <PCellData>\n      <PDataArray type=\"Int64\" Name=\"pair\" NumberOfComponents=\"2\"/>\n    </PCellData>\n",
       "    <Piece Source=\"a/0.vtu\"/>\n    <Piece Source=\"a/1.vtu\"/>\n"})
    EXPECT_NE(text.find(line), std::string::npos) << line;
  EXPECT_FALSE(std::filesystem::exists(path("w.pvtu.tmp")));
  EXPECT_THROW(write_pvtu(path("no_such_folder/w.pvtu"), solid_mesh(), {}), RunError);
}

TEST_F(Vtu, CompressesRepetition) {
  write_vtu(path("cloud.vtu"), cloud(100000));
  const auto raw = 100000 * (9 * sizeof(double) + 2 * sizeof(int) + 1);
  EXPECT_LT(std::filesystem::file_size(path("cloud.vtu")), raw / 3);
}

TEST_F(Vtu, UnwritableFileIsNamed) {
  const std::string file = path("no_such_folder/a.vtu");
  try {
    write_vtu(file, cloud(3));
    FAIL() << "no error";
  } catch (const RunError& error) {
    EXPECT_EQ(std::string(error.what()), "cannot write " + file + ": No such file or directory");
  }
}

TEST_F(Vtu, FullDiskIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  EXPECT_THROW(write_vtu("/dev/full", cloud(3)), RunError);
}

TEST_F(Vtu, ArraysThatDoNotFitAreRefused) {
  const auto refused = [&](auto spoil) {
    VtuData data = mixed_mesh();
    spoil(data);
    EXPECT_THROW(write_vtu(path("bad.vtu"), data), std::invalid_argument);
  };
  refused([](VtuData& d) { d.point_fields[0].components = 2; });
  refused([](VtuData& d) { d.cell_fields[0].values = std::vector<int>{1, 2}; });
  refused([](VtuData& d) { d.connectivity[3] = 12; });
  refused([](VtuData& d) { d.offsets.back() = 12; });
  refused([](VtuData& d) { d.types.pop_back(); });
  EXPECT_FALSE(std::filesystem::exists(path("bad.vtu")));
}

TEST_F(Vtu, SeriesIsCompleteAfterEveryAddition) {
  PvdWriter series(path("p.pvd"));
  EXPECT_FALSE(std::filesystem::exists(path("p.pvd")));
  series.add(0.0, "p_0000.vtu");
  EXPECT_NE(content(path("p.pvd")).find("</VTKFile>"), std::string::npos);
  series.add(0.1, "p_0001.vtu");
  ASSERT_EQ(series.entries().size(), 2u);
  EXPECT_EQ(content(path("p.pvd")),
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n"
            "    <DataSet timestep=\"0\" part=\"0\" file=\"p_0000.vtu\"/>\n"
            "    <DataSet timestep=\"0.1\" part=\"0\" file=\"p_0001.vtu\"/>\n  </Collection>\n</VTKFile>\n");
  EXPECT_FALSE(std::filesystem::exists(path("p.pvd.tmp")));
}

/// A run that goes on: the files of its earlier part stay, in the order of time.
TEST_F(Vtu, SeriesGoesOnWhereItEnded) {
  PvdWriter first(path("a.pvd"));
  first.add(0.0, "0.vtu");
  first.add(0.5, "2.vtu");
  PvdWriter second(path("b.pvd"));
  second.restore(first.entries());
  second.add(0.25, "1.vtu");
  first.add(0.25, "1.vtu");
  EXPECT_EQ(content(path("b.pvd")), content(path("a.pvd")));
  EXPECT_EQ(second.entries()[1].second, "1.vtu");
}

TEST_F(Vtu, UnwritableSeriesIsNamed) {
  PvdWriter series(path("no_such_folder/p.pvd"));
  EXPECT_THROW(series.add(0.0, "p.vtu"), RunError);
}

}  // namespace
}  // namespace berm
