/// Reading STL files.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unordered_map>

#include "base/decimals.hpp"
#include "base/error.hpp"
#include "mesh/surface.hpp"

namespace berm {

namespace {

constexpr double merge_tolerance = 1e-9;  ///< vertices closer than this part of the surface's extent are one
constexpr std::size_t header = 84;        ///< bytes before the first triangle of a binary file
constexpr std::size_t record = 50;        ///< bytes of a triangle: normal, three corners (floats), two bytes more

using Corners = std::vector<Vec3>;  ///< three a triangle

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw InputError(fmt::format("{}: {}", path, what));
}

std::string read_all(const std::string& path) {
  if (std::filesystem::is_directory(path)) fail(path, "is a folder (an STL file is needed)");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail(path, "cannot be read (check the path and the permissions)");
  std::string content{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (file.bad() || content.empty()) fail(path, "is empty (an STL surface is needed)");
  return content;
}

std::uint32_t binary_count(const std::string& content) {  // little-endian on every machine
  std::uint32_t n = 0;
  for (int i = 3; i >= 0; --i) n = n << 8 | static_cast<unsigned char>(content[80 + i]);
  return n;
}

double binary_float(const char* bytes) {
  std::uint32_t bits = 0;
  for (int i = 3; i >= 0; --i) bits = bits << 8 | static_cast<unsigned char>(bytes[i]);
  float value;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

Corners read_binary(const std::string& path, const std::string& content) {
  const std::size_t n = binary_count(content), expected = header + record * n;
  if (content.size() < expected)
    fail(path, fmt::format("is truncated: {} triangles need {} bytes, there are {} (copy or export it again)", n,
                           expected, content.size()));
  Corners corners;
  corners.reserve(3 * n);
  for (std::size_t t = 0; t < n; ++t)
    for (int corner = 0; corner < 3; ++corner) {
      const char* x = &content[header + record * t + 12 * (corner + 1)];
      corners.emplace_back(binary_float(x), binary_float(x + 4), binary_float(x + 8));
    }
  return corners;
}

/// The words of an ASCII file, with the line that they are in.
class AsciiReader {
public:
  AsciiReader(const std::string& path, const std::string& content) : path_(path), content_(content) {}

  Corners run() {
    Corners corners;
    expect("solid");
    skip_line();
    for (std::string word = next(); !word.empty(); word = next()) {
      if (word == "facet") {
        read_facet(corners);
      } else if (word == "endsolid") {
        ended_ = true;
        skip_line();
      } else if (word == "solid" && ended_) {  // several solids in one file
        ended_ = false;
        skip_line();
      } else {
        wrong("facet or endsolid", word);
      }
    }
    if (!ended_)
      fail(path_, fmt::format("line {}: is truncated: endsolid is missing (copy or export it again)", line_));
    return corners;
  }

private:
  std::string next() {
    while (place_ < content_.size() && std::isspace(static_cast<unsigned char>(content_[place_])))
      line_ += content_[place_++] == '\n';
    std::string word;
    while (place_ < content_.size() && !std::isspace(static_cast<unsigned char>(content_[place_])))
      word += static_cast<char>(std::tolower(static_cast<unsigned char>(content_[place_++])));
    return word;
  }

  void skip_line() {
    while (place_ < content_.size() && content_[place_] != '\n') ++place_;
  }

  [[noreturn]] void wrong(const std::string& expected, const std::string& found) const {
    if (found.empty())
      fail(path_, fmt::format("line {}: is truncated: {} is missing (copy or export it again)", line_, expected));
    fail(path_, fmt::format("line {}: \"{}\" where {} should be (not a correct ASCII STL file)", line_,
                            found.substr(0, 40), expected));
  }

  void expect(const std::string& word) {
    const std::string found = next();
    if (found != word) wrong(word, found);
  }

  double number() {
    const std::string word = next();
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    if (word.empty() || *end != '\0') wrong("a number", word);
    return value;
  }

  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

  void read_facet(Corners& corners) {
    expect("normal");
    vector();  // many programs write zeros: the corners tell the normal
    expect("outer");
    expect("loop");
    for (int i = 0; i < 3; ++i) {
      expect("vertex");
      corners.push_back(vector());
    }
    expect("endloop");
    expect("endfacet");
  }

  const std::string& path_;
  const std::string& content_;
  std::size_t place_ = 0;
  int line_ = 1;
  bool ended_ = false;
};

/// A binary file tells its size; its header may begin with "solid" all the same.
Corners read_corners(const std::string& path) {
  const std::string content = read_all(path);
  if (content.size() >= header && content.size() == header + record * std::size_t{binary_count(content)})
    return read_binary(path, content);
  const bool text = content.find('\0') == std::string::npos;
  const std::size_t start = content.find_first_not_of(" \t\r\n");
  if (text && start != std::string::npos) {
    std::string word = content.substr(start, 5);
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (word == "solid") return AsciiReader(path, content).run();
  }
  if (text) fail(path, "is not an STL file (it neither begins with \"solid\" nor has the size of a binary one)");
  if (content.size() < header)
    fail(path,
         fmt::format("is truncated: a binary STL file has at least {} bytes, this one {}", header, content.size()));
  return read_binary(path, content);
}

/// Numbers vertices so that those within the tolerance get the same number (of the first one met).
class VertexMerger {
public:
  VertexMerger(std::vector<Vec3>& vertices, const Vec3& origin, double tolerance)
      : vertices_(vertices), origin_(origin), tolerance_(tolerance) {}

  int number(const Vec3& x) {
    // Wide bins: nearly always all candidates are in one.
    const double width = 1e3 * tolerance_;
    const Eigen::Array3d offset = (x - origin_).array(), own = (offset / width).floor();
    const Eigen::Array3d low = ((offset - tolerance_) / width).floor(), high = ((offset + tolerance_) / width).floor();
    for (double i = low[0]; i <= high[0]; ++i)
      for (double j = low[1]; j <= high[1]; ++j)
        for (double k = low[2]; k <= high[2]; ++k) {
          const auto [first, last] = bins_.equal_range(key(i, j, k));
          for (auto it = first; it != last; ++it)
            if ((vertices_[it->second] - x).norm() <= tolerance_) return it->second;
        }
    const int added = static_cast<int>(vertices_.size());
    bins_.emplace(key(own[0], own[1], own[2]), added);
    vertices_.push_back(x);
    return added;
  }

private:
  /// Different bins may share a key: that costs time only.
  static std::uint64_t key(double i, double j, double k) {
    const auto bits = [](double v) { return static_cast<std::uint64_t>(static_cast<std::int64_t>(v)); };
    return bits(i) * 0x9E3779B97F4A7C15u ^ bits(j) * 0xC2B2AE3D27D4EB4Fu ^ bits(k) * 0x165667B19E3779F9u;
  }

  std::vector<Vec3>& vertices_;
  Vec3 origin_;
  double tolerance_;
  std::unordered_multimap<std::uint64_t, int> bins_;
};

std::string place(const Vec3& x) { return fmt::format("({:g}, {:g}, {:g})", x.x(), x.y(), x.z()); }

void refuse_flat(const TriangleSurface& surface, double tolerance, const std::string& path) {
  for (int t = 0; t < surface.n_triangles(); ++t) {
    double longest = 0.0;
    for (int i = 0; i < 3; ++i)
      longest = std::max(longest, (surface.corner(t, i) - surface.corner(t, (i + 1) % 3)).norm());
    if (!(2.0 * area_vector(surface, t).norm() > tolerance * longest))
      fail(path, fmt::format("triangle {} at {} is degenerate: its corners lie on a line or coincide (remove such "
                             "triangles in the program that made the file)",
                             t + 1, place(surface.corner(t, 0))));
  }
}

}  // namespace

TriangleSurface read_stl(const std::string& path) {
  const Corners corners = read_corners(path);
  if (corners.empty()) fail(path, "has no triangles (a closed surface is needed)");
  Vec3 low = corners[0], high = corners[0];
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!corners[i].allFinite())
      fail(path, fmt::format("triangle {} has a coordinate that is not a finite number", i / 3 + 1));
    low = low.cwiseMin(corners[i]);
    high = high.cwiseMax(corners[i]);
  }
  const double tolerance = merge_tolerance * (high - low).norm();
  if (!(tolerance > 0.0) || !std::isfinite(tolerance)) fail(path, "all vertices coincide or lie too far apart");
  TriangleSurface surface;
  VertexMerger merger(surface.vertices, low, tolerance);
  for (std::size_t i = 0; i < corners.size(); i += 3)
    surface.triangles.push_back(
        {merger.number(corners[i]), merger.number(corners[i + 1]), merger.number(corners[i + 2])});
  refuse_flat(surface, tolerance, path);
  if (volume(surface) < 0.0)
    for (std::array<int, 3>& t : surface.triangles) std::swap(t[1], t[2]);
  for (int t = 0; t < surface.n_triangles(); ++t) surface.normals.push_back(area_vector(surface, t).normalized());
  check_closed(surface, path);
  refuse_crossings(surface, path);
  return surface;
}

TriangleSurface read_stl(const SurfaceFile& file) {
  TriangleSurface surface = read_stl(file.path);
  const double decimals = decimals_at(file.moved);
  for (Vec3& x : surface.vertices)
    for (int i = 0; i < 3; ++i) x[i] = difference(x[i], -file.moved[i], decimals);
  return surface;
}

}  // namespace berm
