#pragma once
/// Parts of one body that are not connected with each other.

#include <array>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

class BodyParts {
public:
  BodyParts() = default;
  /// Two places belong to the same part if boxes of a given width between them are filled without an empty one; a part may thus
  /// be found that is connected by less, never one too many.
  BodyParts(const std::vector<Vec3>& places, double width);
  /// Parts that are known: groups of places, by any numbers. `width`: about how far places are from each other.
  BodyParts(const std::vector<Vec3>& places, const std::vector<int>& group, double width);

  int count() const { return count_; }
  /// Of a place in the body or next to it: the part of the nearest of those places, or boxes.
  int of(const Vec3& x) const;

private:
  using Key = std::array<int, 3>;
  struct Entry {
    Key box;
    Vec3 at;
    int part;
  };
  Key key_of(const Vec3& x) const;
  void keep(std::vector<Entry> entries);

  double width_ = 1.0;
  int count_ = 1;
  std::vector<Entry> entries_;  ///< by ascending boxes; empty if there is one part
};

}  // namespace berm
