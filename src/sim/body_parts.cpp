#include "sim/body_parts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/groups.hpp"
#include "base/sort_unique.hpp"

namespace berm {
namespace {

/// Calls work with the key and all that touch it.
template <class Work>
void around(const std::array<int, 3>& key, const Work& work) {
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k) work(std::array<int, 3>{key[0] + i, key[1] + j, key[2] + k});
}

}  // namespace

BodyParts::Key BodyParts::key_of(const Vec3& x) const {
  Key key;
  for (int i = 0; i < 3; ++i) key[i] = static_cast<int>(std::floor(x[i] / width_));
  return key;
}

BodyParts::BodyParts(const std::vector<Vec3>& places, double width) : width_(width) {
  std::vector<Key> boxes;
  for (const Vec3& x : places) boxes.push_back(key_of(x));
  sort_unique(boxes);
  Groups groups(boxes.size());
  const int n = static_cast<int>(boxes.size());
  for (int b = 0; b < n; ++b)
    around(boxes[b], [&](const Key& beside) {
      if (!(beside < boxes[b])) return;
      const auto other = std::lower_bound(boxes.begin(), boxes.end(), beside);
      if (*other == beside) groups.join(b, static_cast<int>(other - boxes.begin()));
    });
  std::vector<Entry> entries;
  for (int b = 0; b < n; ++b)
    entries.push_back({boxes[b], width_ * (Vec3(boxes[b][0], boxes[b][1], boxes[b][2]) + Vec3::Constant(0.5)), groups.of(b)});
  keep(std::move(entries));
}

BodyParts::BodyParts(const std::vector<Vec3>& places, const std::vector<int>& group, double width) : width_(width) {
  std::vector<Entry> entries;
  for (std::size_t k = 0; k < places.size(); ++k) entries.push_back({key_of(places[k]), places[k], group[k]});
  keep(std::move(entries));
}

/// Numbers the parts in the order of their first boxes.
void BodyParts::keep(std::vector<Entry> entries) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.box < b.box; });
  std::map<int, int> number;
  for (Entry& e : entries) e.part = number.try_emplace(e.part, static_cast<int>(number.size())).first->second;
  count_ = std::max<int>(1, static_cast<int>(number.size()));
  if (count_ > 1) entries_ = std::move(entries);
}

int BodyParts::of(const Vec3& x) const {
  if (count_ == 1) return 0;
  double nearest = std::numeric_limits<double>::infinity();
  int part = 0;
  const auto look = [&](const Entry& e) {
    if (const double distance = (x - e.at).norm(); distance < nearest) nearest = distance, part = e.part;
  };
  around(key_of(x), [&](const Key& key) {
    auto e = std::lower_bound(entries_.begin(), entries_.end(), key, [](const Entry& entry, const Key& k) { return entry.box < k; });
    for (; e != entries_.end() && e->box == key; ++e) look(*e);
  });
  if (nearest < std::numeric_limits<double>::infinity()) return part;
  for (const Entry& e : entries_) look(e);  // nodes of wide functions
  return part;
}

}  // namespace berm
