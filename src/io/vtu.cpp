#include "io/vtu.hpp"

#include <fmt/core.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <stdexcept>
#include <string_view>

#include "io/file.hpp"

namespace berm {
namespace {

constexpr std::size_t block_size = std::size_t{1} << 20;
constexpr int compression_level = 1;  // higher levels gain nothing on doubles (ADR 0001)

std::string xml_escape(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void append_number(std::string& out, std::uint64_t value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Appends one array as vtkZLibDataCompressor stores it: number of blocks, size of a block, size of the last one if it
/// is smaller, compressed sizes, compressed blocks.
void append_compressed(std::string& out, std::string_view raw) {
  const std::size_t n_blocks = (raw.size() + block_size - 1) / block_size;
  append_number(out, n_blocks);
  append_number(out, block_size);
  append_number(out, raw.size() % block_size);
  const std::size_t sizes_at = out.size();
  out.append(n_blocks * sizeof(std::uint64_t), '\0');
  std::vector<Bytef> packed(compressBound(block_size));
  for (std::size_t b = 0; b < n_blocks; ++b) {
    const std::string_view block = raw.substr(b * block_size, block_size);
    uLongf packed_size = packed.size();
    if (compress2(packed.data(), &packed_size, reinterpret_cast<const Bytef*>(block.data()), block.size(),
                  compression_level) != Z_OK)
      throw std::runtime_error("zlib could not compress a block of output");
    const std::uint64_t size = packed_size;
    std::copy_n(reinterpret_cast<const char*>(&size), sizeof size,
                out.begin() + static_cast<std::ptrdiff_t>(sizes_at + b * sizeof size));
    out.append(reinterpret_cast<const char*>(packed.data()), packed_size);
  }
}

const char* type_of(const VtuField& field) {
  constexpr const char* types[] = {"Float64", "Int32", "Int64"};
  return types[field.values.index()];
}

/// Names of the components of vectors and symmetric tensors, which ParaView shows.
std::string component_names(int components) {
  static constexpr const char* vector[] = {"X", "Y", "Z"};
  static constexpr const char* tensor[] = {"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
  std::string names;
  if (components == 3 || components == 6)
    for (int k = 0; k < components; ++k)
      names += fmt::format(" ComponentName{}=\"{}\"", k, components == 3 ? vector[k] : tensor[k]);
  return names;
}

/// The XML part and the appended binary part grow together: an array's header carries its offset into the latter.
struct Document {
  std::string xml, appended;

  void array(std::string_view name, std::string_view type, int components, std::string_view raw) {
    xml += fmt::format(
        "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{} format=\"appended\" offset=\"{}\"/>\n",
        type, xml_escape(name), components, component_names(components), appended.size());
    append_compressed(appended, raw);
  }

  void fields(std::string_view element, const std::vector<VtuField>& all) {
    xml += fmt::format("      <{}>\n", element);
    for (const VtuField& field : all)
      array(field.name, type_of(field), field.components,
            std::visit([](const auto& values) { return bytes_of(values); }, field.values));
    xml += fmt::format("      </{}>\n", element);
  }
};

void check_fields(const std::vector<VtuField>& fields, std::size_t count, std::string_view of) {
  for (const VtuField& field : fields) {
    const std::size_t size = std::visit([](const auto& values) { return values.size(); }, field.values);
    if (field.components < 1 || size != count * static_cast<std::size_t>(field.components))
      throw std::invalid_argument(fmt::format("VTK field \"{}\": {} values for {} {} of {} components", field.name,
                                              size, count, of, field.components));
  }
}

void check(const VtuData& data) {
  if (data.offsets.size() != data.types.size())
    throw std::invalid_argument("VTK cells: offsets and types differ in number");
  if (!std::is_sorted(data.offsets.begin(), data.offsets.end()) ||
      (data.offsets.empty() ? 0 : data.offsets.back()) != static_cast<int>(data.connectivity.size()))
    throw std::invalid_argument("VTK cells: offsets do not fit the connectivity");
  const int n_points = static_cast<int>(data.points.size());
  if (std::any_of(data.connectivity.begin(), data.connectivity.end(), [&](int p) { return p < 0 || p >= n_points; }))
    throw std::invalid_argument("VTK cells: a point number is out of range");
  check_fields(data.point_fields, data.points.size(), "points");
  check_fields(data.cell_fields, data.types.size(), "cells");
}

}  // namespace

VtuData vertices(std::vector<Vec3> points) {
  VtuData data;
  const std::size_t n = points.size();
  data.points = std::move(points);
  data.connectivity.resize(n);
  std::iota(data.connectivity.begin(), data.connectivity.end(), 0);
  data.offsets.resize(n);
  std::iota(data.offsets.begin(), data.offsets.end(), 1);
  data.types.assign(n, vtk_vertex);
  return data;
}

void write_vtu(const std::string& path, const VtuData& data) {
  check(data);
  static_assert(sizeof(Vec3) == 3 * sizeof(double), "points are written as they lie in memory");
  Document document;
  document.xml = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\" "
      "compressor=\"vtkZLibDataCompressor\">\n"
      "  <UnstructuredGrid>\n    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", data.points.size(), data.types.size());
  document.fields("PointData", data.point_fields);
  document.fields("CellData", data.cell_fields);
  document.xml += "      <Points>\n";
  document.array("Points", "Float64", 3, bytes_of(data.points));
  document.xml += "      </Points>\n      <Cells>\n";
  document.array("connectivity", "Int32", 1, bytes_of(data.connectivity));
  document.array("offsets", "Int32", 1, bytes_of(data.offsets));
  document.array("types", "UInt8", 1, bytes_of(data.types));
  document.xml += "      </Cells>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_";

  OutputFile file(path);
  file.write(document.xml);
  file.write(document.appended);
  file.write("\n  </AppendedData>\n</VTKFile>\n");
  file.close();
}

void write_pvtu(const std::string& path, const VtuData& data, const std::vector<std::string>& pieces) {
  std::string xml = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\" "
      "compressor=\"vtkZLibDataCompressor\">\n  <PUnstructuredGrid GhostLevel=\"0\">\n",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian");
  const auto fields = [&](std::string_view element, const std::vector<VtuField>& all) {
    xml += fmt::format("    <P{}>\n", element);
    for (const VtuField& field : all)
      xml += fmt::format("      <PDataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\"{}/>\n", type_of(field),
                         xml_escape(field.name), field.components, component_names(field.components));
    xml += fmt::format("    </P{}>\n", element);
  };
  fields("PointData", data.point_fields);
  fields("CellData", data.cell_fields);
  xml += "    <PPoints>\n      <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n    </PPoints>\n";
  for (const std::string& piece : pieces) xml += fmt::format("    <Piece Source=\"{}\"/>\n", xml_escape(piece));
  xml += "  </PUnstructuredGrid>\n</VTKFile>\n";
  replace_file(path, xml);
}

PvdWriter::PvdWriter(std::string path) : path_(std::move(path)) {}

void PvdWriter::add(double time, const std::string& file) {
  const auto later = std::upper_bound(entries_.begin(), entries_.end(), time,
                                      [](double t, const auto& entry) { return t < entry.first; });
  entries_.insert(later, {time, file});
  std::string xml = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n";
  for (const auto& [t, name] : entries_)
    xml += fmt::format("    <DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", t, xml_escape(name));
  xml += "  </Collection>\n</VTKFile>\n";
  replace_file(path_, xml);
}

}  // namespace berm
