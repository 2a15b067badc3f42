#pragma once
/// Parts of one body that are not connected with each other.

#include <array>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

/// Two places belong to the same part if boxes of a given width between them are filled without an empty one; a part may thus
/// be found that is connected by less, never one too many.
class BodyParts {
public:
  BodyParts() = default;
  BodyParts(const std::vector<Vec3>& places, double width);

  int count() const { return count_; }
  /// Of a place in the body or next to it: the part of the nearest box.
  int of(const Vec3& x) const;

private:
  using Key = std::array<int, 3>;
  Key key_of(const Vec3& x) const;

  double width_ = 1.0;
  int count_ = 1;
  std::vector<Key> boxes_;  ///< ascending; empty if there is one part
  std::vector<int> part_;   ///< by box
};

}  // namespace berm
