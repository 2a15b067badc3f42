#include <fmt/core.h>

#include <cmath>
#include <cstdlib>

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
  EXPECT_EQ(content(path("p.pvd")),
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n"
            "    <DataSet timestep=\"0\" part=\"0\" file=\"p_0000.vtu\"/>\n"
            "    <DataSet timestep=\"0.1\" part=\"0\" file=\"p_0001.vtu\"/>\n  </Collection>\n</VTKFile>\n");
  EXPECT_FALSE(std::filesystem::exists(path("p.pvd.tmp")));
}

TEST_F(Vtu, UnwritableSeriesIsNamed) {
  PvdWriter series(path("no_such_folder/p.pvd"));
  EXPECT_THROW(series.add(0.0, "p.vtu"), RunError);
}

}  // namespace
}  // namespace berm
