#pragma once
/// VTK unstructured grids (.vtu: appended, raw, zlib-compressed) and their time series (.pvd). See
/// docs/adr/0001-vtk-writer.md.

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

/// Cell types of the VTK file format.
enum VtkType : unsigned char {
  vtk_vertex = 1,
  vtk_triangle = 5,
  vtk_quad = 9,
  vtk_tetra = 10,
  vtk_hexahedron = 12,
  vtk_quadratic_triangle = 22,
  vtk_quadratic_quad = 23,
  vtk_quadratic_tetra = 24,
  vtk_quadratic_hexahedron = 25
};

/// Values of all points or all cells, one after the other: components of the first, components of the second, ...
struct VtuField {
  std::string name;
  int components = 1;
  std::variant<std::vector<double>, std::vector<int>, std::vector<std::int64_t>> values;
};

struct VtuData {
  std::vector<Vec3> points;          ///< positions [m]
  std::vector<int> connectivity;     ///< point numbers of the cells, one cell after the other
  std::vector<int> offsets;          ///< cell c ends before connectivity[offsets[c]] (VTK's convention: no leading 0)
  std::vector<unsigned char> types;  ///< VtkType of every cell
  std::vector<VtuField> point_fields, cell_fields;
};

/// A point cloud: one vertex cell a point.
VtuData vertices(std::vector<Vec3> points);

/// Writes the file. Throws RunError naming the file if it cannot be written, std::invalid_argument if the arrays of
/// `data` do not fit each other.
void write_vtu(const std::string& path, const VtuData& data);

/// Writes the list of the pieces of a distributed grid (.pvtu) with the fields of `data`, which every piece has.
/// pieces: paths relative to the folder of the file. Throws RunError.
void write_pvtu(const std::string& path, const VtuData& data, const std::vector<std::string>& pieces);

/// A time series of .vtu files. The .pvd is rewritten after every addition, so that a killed run leaves a valid one.
class PvdWriter {
public:
  /// Writes nothing yet.
  explicit PvdWriter(std::string path);
  /// Adds a file (path relative to the folder of the .pvd) at that time; the entries are kept in the order of time.
  /// Throws RunError.
  void add(double time, const std::string& file);

  /// Times and files so far, and those of an earlier part of the run.
  const std::vector<std::pair<double, std::string>>& entries() const { return entries_; }
  void restore(std::vector<std::pair<double, std::string>> entries) { entries_ = std::move(entries); }

private:
  std::string path_;
  std::vector<std::pair<double, std::string>> entries_;
};

}  // namespace berm
