#pragma once
#include <algorithm>
#include <unordered_map>

#include "base/cube.hpp"
#include "bc/surface.hpp"

namespace berm {

/// Pieces of the surface in cubes of space.
class PieceBins {
public:
  PieceBins(const std::vector<SurfacePoint>& surface, double size) : width_(size) {
    for (const SurfacePoint& s : surface) width_ = std::max(width_, 2.0 * s.size);
    for (std::size_t k = 0; k < surface.size(); ++k) bins_[cube_of(surface[k].X, width_)].push_back(static_cast<int>(k));
  }
  /// Calls work with the numbers of all pieces whose middle is within `size`, or two lengths of a piece, and of some more.
  template <class Work>
  void for_near(const Vec3& x, Work work) const {
    for (int i = -1; i <= 1; ++i)
      for (int j = -1; j <= 1; ++j)
        for (int k = -1; k <= 1; ++k)
          if (const auto found = bins_.find(cube_of(x + width_ * Vec3(i, j, k), width_)); found != bins_.end())
            for (const int piece : found->second) work(piece);
  }

private:
  struct Hash {
    std::size_t operator()(const Cube& k) const {
      return std::size_t(k[0]) * 73856093u ^ std::size_t(k[1]) * 19349663u ^ std::size_t(k[2]) * 83492791u;
    }
  };
  double width_;
  std::unordered_map<Cube, std::vector<int>, Hash> bins_;
};

}  // namespace berm
