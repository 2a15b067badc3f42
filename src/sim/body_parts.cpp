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
  for (const Vec3& x : places) boxes_.push_back(key_of(x));
  sort_unique(boxes_);
  Groups groups(boxes_.size());
  const auto index = [&](const Key& key) { return std::lower_bound(boxes_.begin(), boxes_.end(), key) - boxes_.begin(); };
  const int n = static_cast<int>(boxes_.size());
  for (int b = 0; b < n; ++b)
    around(boxes_[b], [&](const Key& beside) {
      if (!(beside < boxes_[b])) return;
      const auto other = index(beside);
      if (boxes_[other] == beside) groups.join(b, static_cast<int>(other));
    });
  std::map<int, int> number;
  for (int b = 0; b < n; ++b) part_.push_back(number.try_emplace(groups.of(b), static_cast<int>(number.size())).first->second);
  count_ = std::max<int>(1, static_cast<int>(number.size()));
  if (count_ == 1) boxes_.clear(), part_.clear();
}

int BodyParts::of(const Vec3& x) const {
  if (count_ == 1) return 0;
  double nearest = std::numeric_limits<double>::infinity();
  int part = 0;
  const auto look = [&](std::size_t box) {
    const Vec3 middle = width_ * (Vec3(boxes_[box][0], boxes_[box][1], boxes_[box][2]) + Vec3::Constant(0.5));
    if (const double distance = (x - middle).norm(); distance < nearest) nearest = distance, part = part_[box];
  };
  around(key_of(x), [&](const Key& key) {
    const auto found = std::lower_bound(boxes_.begin(), boxes_.end(), key);
    if (found != boxes_.end() && *found == key) look(found - boxes_.begin());
  });
  if (nearest < std::numeric_limits<double>::infinity()) return part;
  for (std::size_t box = 0; box < boxes_.size(); ++box) look(box);  // nodes of wide functions
  return part;
}

}  // namespace berm
