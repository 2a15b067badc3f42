#include "sim/recovery.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "fem/fem.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// Stiffness of the slopes and of the second derivatives against zero, as shares of the patch's volume. They decide
/// only where points do not: the variance of places in half a patch is 1/12 of a cell's edge squared.
constexpr double hold_slope = 1e-4, hold_curvature = 1e-2;

/// Squared distance of a node from the centre of its samples over their mean squared distance from it: 0 amid the body,
/// 1/2 (space: 1/3) on a straight boundary. Above this a patch is one-sided.
constexpr double one_sided = 0.15;

/// The sums over the points of a patch, and later its polynomials.
template <int size>
struct Patch {
  long node = 0;
  Eigen::Matrix<double, size, size> moments = Eigen::Matrix<double, size, size>::Zero();
  Eigen::Matrix<double, size, 6> stress = Eigen::Matrix<double, size, 6>::Zero();

  void operator+=(const Patch& other) {
    moments += other.moments;
    stress += other.stress;
  }
};

/// What the cells about a node make of its stress.
struct Vote {
  long node = 0;
  double weight = 0.0;
  Voigt stress = Voigt::Zero();

  void operator+=(const Vote& other) {
    weight += other.weight;
    stress += other.stress;
  }
};

}  // namespace

template <int size>
inline constexpr bool is_plain<Patch<size>> = true;
template <>
inline constexpr bool is_plain<Vote> = true;

namespace {

template <int dimension, int degree>
constexpr int n_terms = degree == 1 ? dimension + 1 : (dimension + 1) * (dimension + 2) / 2;

/// 1, x, y(, z), then the products of two, as a function of the place in units of the cell size.
template <int dimension, int degree>
auto terms(const Vec3& r) {
  Eigen::Matrix<double, n_terms<dimension, degree>, 1> p;
  p[0] = 1.0;
  p.template segment<dimension>(1) = r.head<dimension>();
  if constexpr (degree == 2) {
    int k = dimension + 1;
    for (int i = 0; i < dimension; ++i)
      for (int j = i; j < dimension; ++j) p[k++] = r[i] * r[j];
  }
  return p;
}

/// Adds up what the processes have to say about the same node.
template <class Value>
void sum_over_processes(const Comm& comm, std::unordered_map<long, Value>& of_node) {
  if (comm.size() == 1) return;
  std::vector<std::vector<Value>> mine(comm.size());
  for (const auto& [node, value] : of_node) mine[node % comm.size()].push_back(value);
  std::vector<std::vector<Value>> parts = comm.exchange(mine);
  std::unordered_map<long, Value> sums;
  for (const auto& from : parts)
    for (const Value& part : from) {
      const auto [at, is_first] = sums.try_emplace(part.node, part);
      if (!is_first) at->second += part;
    }
  for (auto& from : parts)
    for (Value& part : from) part = sums.at(part.node);
  for (const auto& from : comm.exchange(parts))
    for (const Value& sum : from) of_node[sum.node] = sum;
}

double squared_norm(const Voigt& s) { return s.head<3>().squaredNorm() + 2.0 * s.tail<3>().squaredNorm(); }

struct Sample {
  Vec3 x = Vec3::Zero();
  double volume = 0.0;
  Voigt stress = Voigt::Zero();
};

/// Where the stress is better than elsewhere (Zienkiewicz and Zhu 1992): the gradient of linear functions is constant
/// in some directions, and right amid the cell; that of quadratic ones is right at two points a direction, as the
/// points are.
std::vector<Sample> samples_in(const PatchCell& cell, const PointStress& points, int degree) {
  std::vector<Sample> all;
  Sample mean;
  for (const int p : cell.points) {
    all.push_back({points.x[p], points.volume[p], points.stress[p]});
    mean.x += points.volume[p] * points.x[p];
    mean.stress += points.volume[p] * points.stress[p];
    mean.volume += points.volume[p];
  }
  if (degree > 1 || mean.volume == 0.0) return all;
  mean.x /= mean.volume;
  mean.stress /= mean.volume;
  return {mean};
}

/// The polynomials of the patches, and which of them are to be trusted about the boundary.
template <int dimension, int degree>
class Recovery {
public:
  static constexpr int size = n_terms<dimension, degree>;

  Recovery(const Comm& comm, double h, const std::vector<PatchCell>& cells, const PointStress& points,
           const std::function<Vec3(long)>& place)
      : h_(h), place_(place) {
    for (const PatchCell& cell : cells) {
      const std::vector<Sample> samples = samples_in(cell, points, degree);
      for (const long node : cell.nodes) {
        Patch<size>& patch = patches_[node];
        patch.node = node;
        for (const Sample& sample : samples) {
          const auto t = terms<dimension, degree>((sample.x - place(node)) / h);
          patch.moments += sample.volume * t * t.transpose();
          patch.stress += sample.volume * t * sample.stress.transpose();
        }
      }
    }
    sum_over_processes(comm, patches_);
    for (auto& [node, patch] : patches_) solve(patch);
  }

  /// Mean of the polynomials of the cell's nodes, of the one-sided ones only if there are no others.  [formulation
  /// (64)]
  Voigt in_cell(const PatchCell& cell, const Vec3& x) const {
    Voigt sum[2] = {Voigt::Zero(), Voigt::Zero()};
    int n[2] = {0, 0};
    for (const long node : cell.nodes) {
      const Patch<size>& patch = patches_.at(node);
      if (patch.moments(0, 0) == 0.0) continue;  // no points about it
      const bool whole = whole_.contains(node);
      sum[whole] += patch.stress.transpose() * terms<dimension, degree>((x - place_(node)) / h_);
      ++n[whole];
    }
    return n[1] ? sum[1] / n[1] : sum[0] / std::max(1, n[0]);
  }

  /// The patch's own value, at the boundary the mean of what the cells say.
  std::unordered_map<long, Voigt> at_nodes(const Comm& comm, const std::vector<PatchCell>& cells) const {
    std::unordered_map<long, Vote> votes;
    for (const PatchCell& cell : cells)
      for (const long node : cell.nodes) {
        if (whole_.contains(node)) continue;
        Vote vote{node, 1.0, in_cell(cell, place_(node))};
        const auto [at, is_first] = votes.try_emplace(node, vote);
        if (!is_first) at->second += vote;
      }
    sum_over_processes(comm, votes);
    std::unordered_map<long, Voigt> out;
    for (const long node : whole_) out[node] = patches_.at(node).stress.row(0).transpose();
    for (const auto& [node, vote] : votes) out[node] = vote.stress / vote.weight;
    return out;
  }

private:
  /// [formulation (63)]
  void solve(Patch<size>& patch) {
    const double volume = patch.moments(0, 0);
    if (volume == 0.0) return;
    auto hold = patch.moments.diagonal();
    const double offset = patch.moments.row(0).template segment<dimension>(1).squaredNorm() / (volume * volume);
    const double spread = hold.template segment<dimension>(1).sum() / volume;
    if (offset < one_sided * spread) whole_.insert(patch.node);
    hold.template segment<dimension>(1).array() += hold_slope * volume;
    if constexpr (degree == 2) hold.template tail<size - dimension - 1>().array() += hold_curvature * volume;
    patch.stress = patch.moments.ldlt().solve(patch.stress).eval();
  }

  double h_;
  const std::function<Vec3(long)>& place_;
  std::unordered_map<long, Patch<size>> patches_;
  std::unordered_set<long> whole_;
};

template <int dimension, int degree>
RecoveredStress recover(const Comm& comm, double h, const std::vector<PatchCell>& cells, const PointStress& points,
                        const std::function<Vec3(long)>& place) {
  const Recovery<dimension, degree> recovery(comm, h, cells, points, place);
  RecoveredStress out;
  out.node = recovery.at_nodes(comm, cells);
  double difference = 0.0, whole = 0.0;
  for (const PatchCell& cell : cells) {  // [formulation (65)]
    double sum = 0.0, volume = 0.0;
    for (const int p : cell.points) {
      sum += points.volume[p] * squared_norm(points.stress[p] - recovery.in_cell(cell, points.x[p]));
      whole += points.volume[p] * squared_norm(points.stress[p]);
      volume += points.volume[p];
    }
    difference += sum;
    out.cell_error.push_back(volume > 0.0 ? std::sqrt(sum / volume) : 0.0);
  }
  difference = comm.sum(difference);
  whole = comm.sum(whole);
  out.relative_error = whole > 0.0 ? std::sqrt(difference / whole) : 0.0;
  return out;
}

}  // namespace

RecoveredStress recover_stress(const Comm& comm, int dimension, int degree, double cell_size,
                               const std::vector<PatchCell>& cells, const PointStress& points,
                               const std::function<Vec3(long node)>& place) {
  if (dimension == 3)
    return degree == 1 ? recover<3, 1>(comm, cell_size, cells, points, place)
                       : recover<3, 2>(comm, cell_size, cells, points, place);
  return degree == 1 ? recover<2, 1>(comm, cell_size, cells, points, place)
                     : recover<2, 2>(comm, cell_size, cells, points, place);
}

namespace {

/// Points of other processes in cells of this one: F-bar keeps boxes of one mean dilatation together, wherever their middles lie.
void add_points_of_others(const MpmDiscretisation& mpm, CellContents& out) {
  constexpr int width = 12;  // cell, place, volume, damage, stress
  std::unordered_map<int, std::size_t> active;
  for (std::size_t k = 0; k < mpm.active_cells().size(); ++k) active[mpm.active_cells()[k]] = k;
  std::vector<double> mine;
  const std::vector<int>& cell = mpm.cells_of_points();
  for (std::size_t p = 0; p < cell.size(); ++p) {
    if (active.contains(cell[p])) continue;
    mine.insert(mine.end(), {double(cell[p]), out.x[p].x(), out.x[p].y(), out.x[p].z(), out.volume[p], out.damage[p]});
    mine.insert(mine.end(), out.stress[p].data(), out.stress[p].data() + 6);
  }
  const std::vector<double> all = mpm.comm().all_gather(mine);
  for (std::size_t k = 0; k < all.size(); k += width) {
    const auto here = active.find(static_cast<int>(all[k]));
    if (here == active.end()) continue;
    out.cells[here->second].points.push_back(static_cast<int>(out.x.size()));
    out.x.emplace_back(all[k + 1], all[k + 2], all[k + 3]);
    out.volume.push_back(all[k + 4]), out.damage.push_back(all[k + 5]);
    out.stress.push_back(Eigen::Map<const Voigt>(all.data() + k + 6));
  }
}

}  // namespace

CellContents contents_of_cells(const Discretisation& d) {
  const Mesh& mesh = d.mesh();
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(&d);
  CellContents out{{}, mpm ? mpm->places_in_grid() : d.point_origins(), d.material.volume, d.material.damage, d.material.stress};
  const auto add = [&](int cell, int field, std::vector<int> points) {
    const std::span<const int> nodes = mesh.nodes_of_cell(cell);
    PatchCell& patch = out.cells.emplace_back(PatchCell{{nodes.begin(), nodes.end()}, std::move(points)});
    for (long& node : patch.nodes) node += long{field} * mesh.n_nodes();
  };
  if (mpm) {
    std::vector<std::vector<int>> points = mpm->points_by_cell();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const int cell = mpm->active_cells()[k];
      add(mpm->grid_cell(cell), cell / mesh.n_cells(), std::move(points[k]));
    }
    if (d.comm().size() > 1) add_points_of_others(*mpm, out);
    return out;
  }
  const auto& fem = dynamic_cast<const FemDiscretisation&>(d);
  for (std::size_t k = 0; k < fem.elements().size(); ++k) {
    std::vector<int> points(fem.first_point()[k + 1] - fem.first_point()[k]);
    std::iota(points.begin(), points.end(), fem.first_point()[k]);
    add(fem.elements()[k], 0, std::move(points));
  }
  return out;
}

RecoveredStress recover_stress(const Discretisation& d, const CellContents& contents) {
  const Mesh& mesh = d.mesh();
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(&d);
  const auto is_quadratic = [](CellKind k) { return nodes_of(k) > corners_of(k); };
  const bool quadratic = mpm ? mpm->degree() > 1 : std::any_of(mesh.kinds.begin(), mesh.kinds.end(), is_quadratic);
  return recover_stress(d.comm(), d.dimension(), quadratic ? 2 : 1, d.cell_size(), contents.cells,
                        {contents.x, contents.volume, contents.stress},
                        [&](long node) { return mesh.nodes[node % mesh.n_nodes()]; });
}

}  // namespace berm
