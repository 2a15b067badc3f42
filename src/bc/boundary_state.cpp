/// What has to outlive the process for a run to go on.
#include <algorithm>

#include "bc/boundary.hpp"

namespace berm {
namespace {

void append_row(std::vector<double>& rows, int id, const Anchor& a, const Vec3& slip = Vec3::Zero()) {
  rows.push_back(id);
  for (const Vec3* v : {&a.x, &a.u}) rows.insert(rows.end(), v->data(), v->data() + 3);
  rows.insert(rows.end(), a.F.data(), a.F.data() + 9);
  rows.insert(rows.end(), slip.data(), slip.data() + 3);
}

void restore_anchor(Anchor& a, const double* row) {
  a.x = Vec3(row[1], row[2], row[3]);
  a.u = Vec3(row[4], row[5], row[6]);
  std::copy_n(row + 7, 9, a.F.data());
}

/// The point of that number, or null if another process has it. Ids ascend.
template <class Point>
Point* point_of(std::vector<Point>& points, int id) {
  const auto found =
      std::lower_bound(points.begin(), points.end(), id, [](const Point& p, int number) { return p.id < number; });
  return found == points.end() || found->id != id ? nullptr : &*found;
}

}  // namespace

std::vector<double> BoundaryConditions::rows(int kind) const {
  std::vector<double> rows;
  if (kind == 0)
    for (const ContactPoint& p : contacts_) append_row(rows, p.id, p.anchor, p.slip);
  if (kind == 1)
    for (const PressurePoint& p : pressures_) append_row(rows, p.id, p.anchor);
  if (kind == 2)
    for (const PinPoint& p : pins_) append_row(rows, p.id, p.anchor, p.start);
  if (kind == 3 && comm_.is_root())
    for (std::size_t g = 0; g < gauges_.size(); ++g) {
      append_row(rows, static_cast<int>(2 * g), gauges_[g].from);
      append_row(rows, static_cast<int>(2 * g + 1), gauges_[g].to);
    }
  if (kind == 4 && comm_.is_root())
    for (std::size_t k = 0; k < inclined_.size(); ++k)
      append_row(rows, static_cast<int>(k), Anchor{}, Vec3(inclined_[k].push, 0.0, 0.0));
  if (kind == 5)
    for (const DashpotPoint& p : dashpots_) append_row(rows, p.id, p.anchor);
  if (kind == 6)
    for (const HeldPoint& p : held_) append_row(rows, p.id, p.anchor, p.missing);
  if (kind == 7)
    for (const TiePoint& p : ties_.points()) {
      append_row(rows, 2 * p.id, p.ends.a, p.gap);
      append_row(rows, 2 * p.id + 1, p.ends.b, p.gap);
    }
  return rows;
}

void BoundaryConditions::restore(int kind, const std::vector<double>& rows) {
  for (std::size_t k = 0; k < rows.size(); k += row_width) {
    const double* row = rows.data() + k;
    const int id = static_cast<int>(row[0]);
    if (kind == 0)
      if (ContactPoint* p = point_of(contacts_, id)) {
        restore_anchor(p->anchor, row);
        p->slip = Vec3(row[16], row[17], row[18]);
      }
    if (kind == 1)
      if (PressurePoint* p = point_of(pressures_, id)) restore_anchor(p->anchor, row);
    if (kind == 2)
      if (PinPoint* p = point_of(pins_, id)) {
        restore_anchor(p->anchor, row);
        p->start = Vec3(row[16], row[17], row[18]);
      }
    if (kind == 3 && id < 2 * static_cast<int>(gauges_.size()))
      restore_anchor(id % 2 == 0 ? gauges_[id / 2].from : gauges_[id / 2].to, row);
    if (kind == 4 && id < static_cast<int>(inclined_.size())) inclined_[id].push = row[16];
    if (kind == 5)
      if (DashpotPoint* p = point_of(dashpots_, id)) restore_anchor(p->anchor, row);
    if (kind == 6)
      if (HeldPoint* p = point_of(held_, id)) {
        restore_anchor(p->anchor, row);
        p->missing = Vec3(row[16], row[17], row[18]);
      }
    if (kind == 7)
      if (TiePoint* p = point_of(ties_.points(), id / 2)) {
        restore_anchor(id % 2 == 0 ? p->ends.a : p->ends.b, row);
        p->gap = Vec3(row[16], row[17], row[18]);
      }
  }
}

}  // namespace berm
