#include "mesh/surface.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "base/error.hpp"
#include "mesh/solid_angle.hpp"

namespace berm {

namespace {

/// One triangle's use of an edge.
struct EdgeUse {
  int low, high, triangle;
  bool forward;  ///< the triangle runs from the lower to the higher vertex number
  bool same_edge(const EdgeUse& other) const { return low == other.low && high == other.high; }
};

/// All uses, those of one edge next to each other.
std::vector<EdgeUse> edge_uses(const TriangleSurface& surface) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (int t = 0; t < surface.n_triangles(); ++t)
    for (int i = 0; i < 3; ++i) {
      const int a = surface.triangles[t][i], b = surface.triangles[t][(i + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& p, const EdgeUse& q) {
    return std::tie(p.low, p.high, p.triangle) < std::tie(q.low, q.high, q.triangle);
  });
  return uses;
}

/// Calls visit(first, last) for the uses of every edge.
template <class Visit>
void for_each_edge(const std::vector<EdgeUse>& uses, const Visit& visit) {
  for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
    while (last < uses.size() && uses[last].same_edge(uses[first])) ++last;
    visit(first, last);
  }
}

std::string at(const Vec3& x) { return fmt::format("({:g}, {:g}, {:g})", x.x(), x.y(), x.z()); }

/// Triangles that hang together by edges with two neighbours.
struct Patches {
  std::vector<int> of_triangle;
  std::vector<std::vector<int>> triangles;  ///< in every patch
  std::vector<char> against;                ///< the triangle runs the other way round than the first of its patch
};

Patches find_patches(const TriangleSurface& surface) {
  struct Neighbour {
    int triangle;
    bool against;
  };
  std::vector<std::array<Neighbour, 3>> neighbours(surface.triangles.size());
  std::vector<int> count(surface.triangles.size(), 0);
  const std::vector<EdgeUse> uses = edge_uses(surface);
  for_each_edge(uses, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const EdgeUse &p = uses[first], &q = uses[first + 1];
    const bool against = p.forward == q.forward;
    neighbours[p.triangle][count[p.triangle]++] = {q.triangle, against};
    neighbours[q.triangle][count[q.triangle]++] = {p.triangle, against};
  });
  Patches patches{std::vector<int>(surface.triangles.size(), -1), {}, std::vector<char>(surface.triangles.size(), 0)};
  for (int seed = 0; seed < surface.n_triangles(); ++seed) {
    if (patches.of_triangle[seed] >= 0) continue;
    const int number = static_cast<int>(patches.triangles.size());
    std::vector<int> members = {seed};
    patches.of_triangle[seed] = number;
    for (std::size_t next = 0; next < members.size(); ++next)
      for (int i = 0; i < count[members[next]]; ++i) {
        const Neighbour& n = neighbours[members[next]][i];
        if (patches.of_triangle[n.triangle] >= 0) continue;
        patches.of_triangle[n.triangle] = number;
        patches.against[n.triangle] = static_cast<char>((patches.against[members[next]] != 0) != n.against);
        members.push_back(n.triangle);
      }
    patches.triangles.push_back(std::move(members));
  }
  return patches;
}

double volume_of(const TriangleSurface& surface, const std::vector<int>& triangles, const Vec3& origin) {
  double six = 0.0;
  for (int t : triangles)
    six += (surface.corner(t, 0) - origin).dot((surface.corner(t, 1) - origin).cross(surface.corner(t, 2) - origin));
  return six / 6.0;
}

/// How often the triangles wind around x.
double winding(const TriangleSurface& surface, const std::vector<int>& triangles, const Vec3& x) {
  double sum = 0.0;
  for (int t : triangles) sum += winding_part(x, surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2));
  return sum;
}

struct Extent {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool holds(const Vec3& x) const { return (x.array() >= low.array()).all() && (x.array() <= high.array()).all(); }
};

/// Does every patch lie in an odd number of others (and so bounds a cavity)? Patches must be oriented in themselves.
std::vector<char> cavities(const TriangleSurface& surface, const std::vector<std::vector<int>>& patches) {
  std::vector<Extent> extents(patches.size());
  for (std::size_t p = 0; p < patches.size(); ++p)
    for (int t : patches[p])
      for (int i = 0; i < 3; ++i) extents[p].add(surface.corner(t, i));
  std::vector<char> inside(patches.size(), 0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    const int t = patches[p][0];
    const Vec3 x = (surface.corner(t, 0) + surface.corner(t, 1) + surface.corner(t, 2)) / 3.0;
    for (std::size_t q = 0; q < patches.size(); ++q)
      if (q != p && extents[q].holds(x) && std::abs(winding(surface, patches[q], x)) > 0.5) inside[p] ^= 1;
  }
  return inside;
}

void flip(TriangleSurface& surface, int triangle) {
  std::swap(surface.triangles[triangle][1], surface.triangles[triangle][2]);
  surface.normals[triangle] = -surface.normals[triangle];
}

/// One pass of `split`: every edge that is too long gets a vertex in its middle.
class Halving {
public:
  Halving(TriangleSurface& surface, double longest) : surface_(surface), longest_(longest) {}

  bool run() {
    TriangleSurface out;
    for (int t = 0; t < surface_.n_triangles(); ++t) divide(t, out);
    const bool changed = !middles_.empty();
    surface_.triangles = std::move(out.triangles);
    surface_.normals = std::move(out.normals);
    return changed;
  }

private:
  double length(int a, int b) const { return (surface_.vertices[a] - surface_.vertices[b]).norm(); }

  int middle(int a, int b) {
    if (length(a, b) <= longest_) return -1;
    const auto [place, is_new] = middles_.emplace(std::minmax(a, b), static_cast<int>(surface_.vertices.size()));
    if (is_new)
      surface_.vertices.push_back(0.5 *
                                  (surface_.vertices[place->first.first] + surface_.vertices[place->first.second]));
    return place->second;
  }

  void divide(int t, TriangleSurface& out) {
    const auto add = [&](int a, int b, int c) {
      out.triangles.push_back({a, b, c});
      out.normals.push_back(surface_.normals[t]);
    };
    const std::array<int, 3> v = surface_.triangles[t];
    const std::array<int, 3> m = {middle(v[0], v[1]), middle(v[1], v[2]), middle(v[2], v[0])};
    const int halved = (m[0] >= 0) + (m[1] >= 0) + (m[2] >= 0);
    if (halved == 0) return add(v[0], v[1], v[2]);
    if (halved == 3) {
      for (int i = 0; i < 3; ++i) add(v[i], m[i], m[(i + 2) % 3]);
      return add(m[0], m[1], m[2]);
    }
    int i = 0;  // the side with a middle (one) or the first of the two with one
    if (halved == 1)
      while (m[i] < 0) ++i;
    else
      while (m[(i + 2) % 3] >= 0) ++i;
    const int a = v[i], b = v[(i + 1) % 3], c = v[(i + 2) % 3], ab = m[i], bc = m[(i + 1) % 3];
    if (halved == 1) {
      add(a, ab, c);
      return add(ab, b, c);
    }
    add(ab, b, bc);
    if (length(a, bc) <= length(ab, c)) {  // the shorter diagonal of what is left
      add(a, ab, bc);
      add(a, bc, c);
    } else {
      add(a, ab, c);
      add(ab, bc, c);
    }
  }

  TriangleSurface& surface_;
  double longest_;
  std::map<std::pair<int, int>, int> middles_;
};

/// Two triangles with the same three corners.
std::optional<int> repeated_triangle(const TriangleSurface& surface) {
  std::vector<std::pair<std::array<int, 3>, int>> keys;
  for (int t = 0; t < surface.n_triangles(); ++t) {
    keys.emplace_back(surface.triangles[t], t);
    std::sort(keys.back().first.begin(), keys.back().first.end());
  }
  std::sort(keys.begin(), keys.end());
  const auto found =
      std::adjacent_find(keys.begin(), keys.end(), [](const auto& p, const auto& q) { return p.first == q.first; });
  if (found == keys.end()) return std::nullopt;
  return found->second;
}

void check_edges(const TriangleSurface& surface, const std::string& subject) {
  int open = 0, crowded = 0, twisted = 0;
  std::string open_at, crowded_at, twisted_at;
  const std::vector<EdgeUse> uses = edge_uses(surface);
  const auto note = [&](int& count, std::string& place, const EdgeUse& use) {
    if (count++ == 0) place = at(0.5 * (surface.vertices[use.low] + surface.vertices[use.high]));
  };
  for_each_edge(uses, [&](std::size_t first, std::size_t last) {
    if (last - first == 1) note(open, open_at, uses[first]);
    if (last - first > 2) note(crowded, crowded_at, uses[first]);
    if (last - first == 2 && uses[first].forward == uses[first + 1].forward) note(twisted, twisted_at, uses[first]);
  });
  if (crowded > 0)
    throw InputError(
        fmt::format("{}: {} edge(s) belong to more than two triangles, the first one at {} (take inner walls "
                    "out of the surface, and keep parts that touch along an edge apart)",
                    subject, crowded, crowded_at));
  if (open > 0)
    throw InputError(fmt::format(
        "{}: the surface is not closed: {} open edge(s), the first one at {} (close the holes in the program "
        "that made it; vertices of neighbours must coincide)",
        subject, open, open_at));
  if (twisted > 0)
    throw InputError(
        fmt::format("{}: neighbouring triangles run against each other at {} edge(s), the first one at {} (export the "
                    "surface again with all normals pointing outwards)",
                    subject, twisted, twisted_at));
}

}  // namespace

double volume(const TriangleSurface& surface) {
  if (surface.triangles.empty()) return 0.0;
  std::vector<int> all(surface.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  return volume_of(surface, all, 0.5 * (low_corner(surface) + high_corner(surface)));
}

Vec3 low_corner(const TriangleSurface& surface) {
  Extent extent;
  for (const Vec3& x : surface.vertices) extent.add(x);
  return extent.low;
}

Vec3 high_corner(const TriangleSurface& surface) {
  Extent extent;
  for (const Vec3& x : surface.vertices) extent.add(x);
  return extent.high;
}

Vec3 area_vector(const TriangleSurface& surface, int triangle) {
  const Vec3& a = surface.corner(triangle, 0);
  return 0.5 * (surface.corner(triangle, 1) - a).cross(surface.corner(triangle, 2) - a);
}

TriangleSurface split(const TriangleSurface& surface, double longest) {
  if (!(longest > 0.0)) throw InputError(fmt::format("surface: edges of {:g} m (they must be positive)", longest));
  TriangleSurface out = surface;
  while (Halving(out, longest).run()) {
  }
  return out;
}

void turn_outward(TriangleSurface& surface) {
  const Patches patches = find_patches(surface);
  for (int t = 0; t < surface.n_triangles(); ++t)
    if (patches.against[t]) flip(surface, t);
  const std::vector<char> hollow = cavities(surface, patches.triangles);
  for (std::size_t p = 0; p < patches.triangles.size(); ++p) {
    const std::vector<int>& members = patches.triangles[p];
    if ((volume_of(surface, members, surface.corner(members[0], 0)) < 0.0) == (hollow[p] != 0)) continue;
    for (int t : members) flip(surface, t);
  }
}

void check_closed(const TriangleSurface& surface, const std::string& subject) {
  if (const std::optional<int> t = repeated_triangle(surface))
    throw InputError(fmt::format("{}: two triangles have the same corners, one of them {} (remove one of the two)",
                                 subject, at(surface.corner(*t, 0))));
  check_edges(surface, subject);
  double area = 0.0;
  for (int t = 0; t < surface.n_triangles(); ++t) area += area_vector(surface, t).norm();
  const double size = (high_corner(surface) - low_corner(surface)).norm();
  if (!(volume(surface) > 1e-12 * area * size))
    throw InputError(fmt::format("{}: the surface encloses no volume (all of it lies in one plane)", subject));
  const Patches patches = find_patches(surface);
  const std::vector<char> hollow = cavities(surface, patches.triangles);
  for (std::size_t p = 0; p < patches.triangles.size(); ++p) {
    const Vec3& x = surface.corner(patches.triangles[p][0], 0);
    const bool negative = volume_of(surface, patches.triangles[p], x) < 0.0;
    if (negative == (hollow[p] != 0)) continue;
    throw InputError(fmt::format(
        "{}: the closed part of the surface with a corner at {} {}", subject, at(x),
        hollow[p]
            ? "lies inside of another one (unite the parts before the export, or turn the part to make it a cavity)"
            : "is inside out (turn it: its normals must point outwards)"));
  }
}

}  // namespace berm
