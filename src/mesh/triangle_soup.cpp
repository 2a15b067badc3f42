#include "mesh/triangle_soup.hpp"

#include <algorithm>
#include <deque>

namespace berm {

namespace {

/// Triangles with two equal corners add nothing, as chains too.
void add(const Vec3& a, const Vec3& b, const Vec3& c, bool cap, Soup& out) {
  if (a == b || b == c || c == a) return;
  out.push_back({a, b, c, cap});
}

/// A point of the plane between two points at the depths d (inside) and e (outside). `snap` puts it exactly there.
template <class Snap>
Vec3 crossing(const Vec3& inner, const Vec3& outer, double d, double e, const Snap& snap) {
  if (d == 0.0) return inner;
  Vec3 x = inner + (outer - inner) * (d / (d - e));
  snap(x);
  return x;
}

/// Sutherland-Hodgman on every triangle. `depth` is the distance into the half-space (0 counts as inside) and must be
/// the same for the same vertex in all triangles. Calls open(from, to) for every segment in the plane that the cap has
/// as its boundary.
template <class Depth, class Snap, class Open>
void cut_soup(const Soup& soup, const Depth& depth, const Snap& snap, const Open& open, Soup& out) {
  out.clear();
  for (const SoupTriangle& t : soup) {
    const Vec3* corners[3] = {&t.a, &t.b, &t.c};
    const double d[3] = {depth(t.a), depth(t.b), depth(t.c)};
    const bool in[3] = {d[0] >= 0.0, d[1] >= 0.0, d[2] >= 0.0};
    if (in[0] && in[1] && in[2]) {
      out.push_back(t);
      continue;
    }
    if (!in[0] && !in[1] && !in[2]) continue;
    Vec3 kept[4], leave, enter;
    int n = 0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      if (in[i]) kept[n++] = *corners[i];
      if (in[i] == in[j]) continue;
      // Always from inside to outside: the neighbour finds the same point.
      const int inner = in[i] ? i : j, outer = in[i] ? j : i;
      kept[n] = crossing(*corners[inner], *corners[outer], d[inner], d[outer], snap);
      (in[i] ? leave : enter) = kept[n++];
    }
    add(kept[0], kept[1], kept[2], t.cap, out);
    if (n == 4) add(kept[0], kept[2], kept[3], t.cap, out);
    open(enter, leave);
  }
}

struct Segment {
  Vec3 a, b;
};
using Chain = std::vector<Segment>;

void add(const Vec3& a, const Vec3& b, Chain& chain) {
  if (a != b) chain.push_back({a, b});
}

/// The part of a body in a box. Of the caps in the sides of the box only the boundaries are kept, as closed chains:
/// caps as triangles would be cut again and again into ever more pieces.
struct BoxedSoup {
  Soup surface;
  std::array<Chain, 6> sides;  ///< low x, high x, low y, ...

  bool empty() const {
    return surface.empty() && std::all_of(sides.begin(), sides.end(), [](const Chain& c) { return c.empty(); });
  }

  /// Calls visit(a, b, c) for the triangles of the caps.
  template <class Visit>
  void for_each_cap(const Visit& visit) const {
    for (const Chain& chain : sides)
      for (const Segment& s : chain)
        if (s.a != chain[0].a && s.b != chain[0].a) visit(chain[0].a, s.a, s.b);
  }

  SolidMoments moments(const Vec3& origin) const {
    SolidMoments moments;
    moments.add(surface, origin);
    for_each_cap([&](const Vec3& a, const Vec3& b, const Vec3& c) { moments.add(a - origin, b - origin, c - origin); });
    return moments;
  }

  void closed(Soup& out) const {
    out = surface;
    for_each_cap([&](const Vec3& a, const Vec3& b, const Vec3& c) { out.push_back({a, b, c, true}); });
  }
};

/// The chain of a cap, cut: the points in which it passes the plane are joined along the plane through the first one.
/// The same joints, run the other way, belong to the new cap in the plane.
template <class Depth, class Snap>
void cut_chain(const Chain& chain, const Depth& depth, const Snap& snap, Chain& out, Chain& cap) {
  out.clear();
  bool first = true;
  Vec3 joint = Vec3::Zero();
  for (const Segment& s : chain) {
    const double da = depth(s.a), db = depth(s.b);
    if (da >= 0.0 && db >= 0.0) out.push_back(s);
    if ((da >= 0.0) == (db >= 0.0)) continue;
    const Vec3 x = da >= 0.0 ? crossing(s.a, s.b, da, db, snap) : crossing(s.b, s.a, db, da, snap);
    if (first) joint = x;
    first = false;
    if (da >= 0.0) {
      add(s.a, x, out);
      add(x, joint, out);
      add(joint, x, cap);
    } else {
      add(x, s.b, out);
      add(joint, x, out);
      add(x, joint, cap);
    }
  }
}

/// The part on the low (sign 1) or high (sign -1) side of a plane.
void cut(const BoxedSoup& soup, int axis, double position, double sign, BoxedSoup& out) {
  const auto depth = [=](const Vec3& x) { return sign * (position - x[axis]); };
  const auto snap = [=](Vec3& x) { x[axis] = position; };
  const int opposite = 2 * axis + (sign > 0.0 ? 0 : 1), own = 2 * axis + (sign > 0.0 ? 1 : 0);
  Chain& cap = out.sides[own];
  cap.clear();
  cut_soup(
      soup.surface, depth, snap, [&](const Vec3& a, const Vec3& b) { add(a, b, cap); }, out.surface);
  for (int side = 0; side < 6; ++side)
    if (side == opposite)
      out.sides[side] = soup.sides[side];
    else if (side != own)
      cut_chain(soup.sides[side], depth, snap, out.sides[side], cap);
}

class Bisection {
public:
  Bisection(const GridPlanes& planes, double sliver, const std::function<void(const BoxRange&)>& full,
            const std::function<void(const BoxRange&, const Soup&)>& part)
      : planes_(planes), sliver_(sliver), full_(full), part_(part) {}

  void run(const BoxRange& range, const BoxedSoup& soup, std::size_t level) {
    if (soup.empty()) return;
    const Vec3 low = range.low(planes_), high = range.high(planes_);
    const double whole = (high - low).prod(), inside = soup.moments(0.5 * (low + high)).volume;
    if (soup.surface.empty()) {
      if (inside > 0.5 * whole) full_(range);
      return;
    }
    if (sliver_ > 0.0 && inside <= sliver_) return;
    if (sliver_ > 0.0 && inside >= whole - sliver_) return full_(range);
    if (range.single()) {
      soup.closed(closed_);
      return part_(range, closed_);
    }
    halve(range, soup, level);
  }

private:
  void halve(const BoxRange& range, const BoxedSoup& soup, std::size_t level) {
    int axis = 0;
    for (int d = 1; d < 3; ++d)
      if (range.last[d] - range.first[d] > range.last[axis] - range.first[axis]) axis = d;
    const int middle = (range.first[axis] + range.last[axis]) / 2;
    BoxRange lower = range, upper = range;
    lower.last[axis] = upper.first[axis] = middle;
    if (level == levels_.size()) levels_.emplace_back();
    BoxedSoup& half = levels_[level];
    cut(soup, axis, planes_[axis][middle], 1.0, half);
    run(lower, half, level + 1);
    cut(soup, axis, planes_[axis][middle], -1.0, half);
    run(upper, half, level + 1);
  }

  const GridPlanes& planes_;
  double sliver_;
  const std::function<void(const BoxRange&)>& full_;
  const std::function<void(const BoxRange&, const Soup&)>& part_;
  std::deque<BoxedSoup> levels_;  ///< memory for the halves
  Soup closed_;
};

/// The boxes that the extent of the soup reaches.
BoxRange reached(const Soup& soup, const GridPlanes& planes) {
  Vec3 low = soup[0].a, high = low;
  for (const SoupTriangle& t : soup) {
    low = low.cwiseMin(t.a).cwiseMin(t.b).cwiseMin(t.c);
    high = high.cwiseMax(t.a).cwiseMax(t.b).cwiseMax(t.c);
  }
  BoxRange range;
  for (int d = 0; d < 3; ++d) {
    const std::vector<double>& x = planes[d];
    const int n = static_cast<int>(x.size()) - 1;
    range.first[d] = std::clamp(static_cast<int>(std::upper_bound(x.begin(), x.end(), low[d]) - x.begin()) - 1, 0, n);
    range.last[d] = std::clamp(static_cast<int>(std::lower_bound(x.begin(), x.end(), high[d]) - x.begin()), 0, n);
  }
  return range;
}

}  // namespace

Vec3 BoxRange::low(const GridPlanes& planes) const {
  return {planes[0][first[0]], planes[1][first[1]], planes[2][first[2]]};
}

Vec3 BoxRange::high(const GridPlanes& planes) const {
  return {planes[0][last[0]], planes[1][last[1]], planes[2][last[2]]};
}

void cut(const Soup& soup, const HalfSpace& half, Soup& out) {
  bool first = true;
  Vec3 apex = Vec3::Zero();
  Soup cap;
  const auto open = [&](const Vec3& a, const Vec3& b) {
    if (first) apex = a;
    first = false;
    add(apex, a, b, true, cap);
  };
  cut_soup(
      soup, [&half](const Vec3& x) { return half.offset - half.normal.dot(x); }, [](Vec3&) {}, open, out);
  out.insert(out.end(), cap.begin(), cap.end());
}

void bisect(const Soup& soup, const GridPlanes& planes, double sliver, const std::function<void(const BoxRange&)>& full,
            const std::function<void(const BoxRange&, const Soup&)>& part) {
  if (soup.empty()) return;
  const BoxRange range = reached(soup, planes);
  for (int d = 0; d < 3; ++d)
    if (range.first[d] >= range.last[d]) return;
  BoxedSoup inside, next;
  inside.surface = soup;
  const Vec3 low = range.low(planes), high = range.high(planes);
  for (int d = 0; d < 3; ++d) {
    cut(inside, d, high[d], 1.0, next);
    cut(next, d, low[d], -1.0, inside);
  }
  Bisection(planes, sliver, full, part).run(range, inside, 0);
}

}  // namespace berm
