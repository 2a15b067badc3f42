#include "mesh/triangle_soup.hpp"

#include <algorithm>

namespace berm {

namespace {

/// Triangles with two equal corners add nothing, as chains too.
void add(const Vec3& a, const Vec3& b, const Vec3& c, bool cap, Soup& out) {
  if (a == b || b == c || c == a) return;
  out.push_back({a, b, c, cap});
}

/// Sutherland-Hodgman on every triangle. `depth` is the distance into the half-space (0 counts as inside) and must be
/// the same for the same vertex in all triangles; `snap` puts a cut point onto the plane.
template <class Depth, class Snap>
void cut_soup(const Soup& soup, const Depth& depth, const Snap& snap, Soup& out) {
  out.clear();
  bool first = true;
  Vec3 apex = Vec3::Zero();
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
      kept[n] = *corners[inner] + (*corners[outer] - *corners[inner]) * (d[inner] / (d[inner] - d[outer]));
      if (d[inner] > 0.0) snap(kept[n]);
      (in[i] ? leave : enter) = kept[n++];
    }
    add(kept[0], kept[1], kept[2], t.cap, out);
    if (n == 4) add(kept[0], kept[2], kept[3], t.cap, out);
    if (first) apex = leave;
    first = false;
    add(apex, enter, leave, true, out);
  }
}

class Bisection {
public:
  Bisection(const GridPlanes& planes, double sliver, const std::function<void(const BoxRange&)>& full,
            const std::function<void(const BoxRange&, const Soup&)>& part)
      : planes_(planes), sliver_(sliver), full_(full), part_(part) {}

  void run(const BoxRange& range, const Soup& soup) const {
    if (soup.empty()) return;
    const Vec3 low = range.low(planes_), high = range.high(planes_);
    const double whole = (high - low).prod();
    SolidMoments moments;
    moments.add(soup, 0.5 * (low + high));
    if (std::all_of(soup.begin(), soup.end(), [](const SoupTriangle& t) { return t.cap; })) {
      if (moments.volume > 0.5 * whole) full_(range);
      return;
    }
    if (sliver_ > 0.0 && moments.volume <= sliver_) return;
    if (sliver_ > 0.0 && moments.volume >= whole - sliver_) return full_(range);
    if (range.single()) return part_(range, soup);
    halve(range, soup);
  }

private:
  void halve(const BoxRange& range, const Soup& soup) const {
    int axis = 0;
    for (int d = 1; d < 3; ++d)
      if (range.last[d] - range.first[d] > range.last[axis] - range.first[axis]) axis = d;
    const int middle = (range.first[axis] + range.last[axis]) / 2;
    BoxRange lower = range, upper = range;
    lower.last[axis] = upper.first[axis] = middle;
    Soup half;
    half.reserve(soup.size());
    cut(soup, axis, planes_[axis][middle], 1.0, half);
    run(lower, half);
    cut(soup, axis, planes_[axis][middle], -1.0, half);
    run(upper, half);
  }

  const GridPlanes& planes_;
  double sliver_;
  const std::function<void(const BoxRange&)>& full_;
  const std::function<void(const BoxRange&, const Soup&)>& part_;
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
  cut_soup(
      soup, [&half](const Vec3& x) { return half.offset - half.normal.dot(x); }, [](Vec3&) {}, out);
}

void cut(const Soup& soup, int axis, double position, double sign, Soup& out) {
  cut_soup(
      soup, [=](const Vec3& x) { return sign * (position - x[axis]); }, [=](Vec3& x) { x[axis] = position; }, out);
}

void bisect(const Soup& soup, const GridPlanes& planes, double sliver, const std::function<void(const BoxRange&)>& full,
            const std::function<void(const BoxRange&, const Soup&)>& part) {
  if (soup.empty()) return;
  const BoxRange range = reached(soup, planes);
  for (int d = 0; d < 3; ++d)
    if (range.first[d] >= range.last[d]) return;
  Soup inside = soup, next;
  const Vec3 low = range.low(planes), high = range.high(planes);
  for (int d = 0; d < 3; ++d) {
    cut(inside, d, high[d], 1.0, next);
    cut(next, d, low[d], -1.0, inside);
  }
  Bisection(planes, sliver, full, part).run(range, inside);
}

}  // namespace berm
