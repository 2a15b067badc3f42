#pragma once
/// Which process owns a place in space: recursive bisection along the axes.

#include <span>
#include <vector>

#include "base/tensor.hpp"
#include "comm/comm.hpp"

namespace berm {

class Partition {
public:
  /// Process 0 owns everything.
  Partition() = default;

  /// Cuts space so that all processes of comm get about the same weight of places. Collective; every process gives the
  /// places that it has now, possibly none, in `dim` dimensions. Places with the same coordinate along a cut stay
  /// together, so that places in a few columns, or fewer places than processes, cannot be balanced well: some processes
  /// then own no place. Without any place process 0 owns everything. The cuts depend on places and weights, not on who
  /// gave them, up to rounding. Returns the new owner of every place given here.
  std::vector<int> balance(const Comm& comm, int dim, std::span<const Vec3> places, std::span<const double> weights);

  /// The rank that owns x: the same answer on every process, also far away from all places.
  int owner(const Vec3& x) const;

  /// Greatest weight of a process over the mean: 1 is perfect. Collective.
  static double imbalance(const Comm& comm, double my_weight);

  /// The cuts as numbers (for logs and tests), and back.
  std::vector<double> numbers() const;
  static Partition from_numbers(std::span<const double> numbers);

private:
  /// x[axis] <= at leads to `below`, else to `above`: an index of cuts_, or ~rank.
  struct Cut {
    int axis;
    double at;
    int below, above;
  };
  std::vector<Cut> cuts_;
  int root_ = ~0;
};

}  // namespace berm
