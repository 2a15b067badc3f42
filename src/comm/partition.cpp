#include "comm/partition.hpp"

#include <zoltan.h>
#include <zoltan_partition_tree.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>

#include "base/error.hpp"
#include "comm/mpi.hpp"

namespace berm {
namespace {

void check(int code, const char* what) {
  if (code != ZOLTAN_OK && code != ZOLTAN_WARN) throw RunError(std::string("Zoltan: ") + what + " failed");
}

struct Destroy {
  void operator()(Zoltan_Struct* zoltan) const { Zoltan_Destroy(&zoltan); }
};
using Zoltan = std::unique_ptr<Zoltan_Struct, Destroy>;

/// What Zoltan's callbacks read.
struct Input {
  int rank;
  std::span<const Vec3> places;
  std::span<const double> weights;
  bool equal;  ///< all weights are zero: count places instead
  int dim;
};

const Input& input(void* data) { return *static_cast<const Input*>(data); }

int count(void* data, int* error) {
  *error = ZOLTAN_OK;
  return static_cast<int>(input(data).places.size());
}

void list(void* data, int, int, ZOLTAN_ID_PTR global, ZOLTAN_ID_PTR local, int, float* weights, int* error) {
  const Input& in = input(data);
  for (std::size_t i = 0; i < in.places.size(); ++i) {
    // Rank and index: a single id of 32 bits would end at 4e9 places.
    global[2 * i] = in.rank;
    global[2 * i + 1] = local[i] = static_cast<ZOLTAN_ID_TYPE>(i);
    weights[i] = in.equal ? 1.0f : static_cast<float>(in.weights[i]);
  }
  *error = ZOLTAN_OK;
}

int dimension(void* data, int* error) {
  *error = ZOLTAN_OK;
  return input(data).dim;
}

void coordinates(void* data, int, int, int n, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR local, int dim, double* x, int* error) {
  for (int i = 0; i < n; ++i)
    for (int d = 0; d < dim; ++d) x[i * dim + d] = input(data).places[local[i]][d];
  *error = ZOLTAN_OK;
}

Zoltan make_zoltan(const Comm& comm, Input& in) {
  float version;
  check(Zoltan_Initialize(0, nullptr, &version), "start");
  Zoltan zoltan(Zoltan_Create(mpi_comm(comm)));
  if (!zoltan) throw RunError("Zoltan: start failed");
  constexpr std::array<std::array<const char*, 2>, 14> parameters{{
      {"DEBUG_LEVEL", "0"},
      {"LB_METHOD", "RCB"},
      {"NUM_GID_ENTRIES", "2"},
      {"NUM_LID_ENTRIES", "1"},
      {"OBJ_WEIGHT_DIM", "1"},
      {"RETURN_LISTS", "PARTS"},
      {"IMBALANCE_TOL", "1.02"},
      {"REMAP", "0"},  // else the result would depend on who has the places now
      {"KEEP_CUTS", "1"},
      {"RCB_OUTPUT_LEVEL", "0"},
      {"CHECK_GEOM", "0"},
      {"RCB_RECTILINEAR_BLOCKS", "1"},  // places on a cut all go to one side, so that owner() is a function of x
      {"AVERAGE_CUTS", "1"},            // cuts between places, not through one: a rounding error does not move it
      {"RCB_REUSE", "0"},
  }};
  for (const auto& [key, value] : parameters) check(Zoltan_Set_Param(zoltan.get(), key, value), key);
  check(Zoltan_Set_Num_Obj_Fn(zoltan.get(), count, &in), "set-up");
  check(Zoltan_Set_Obj_List_Fn(zoltan.get(), list, &in), "set-up");
  check(Zoltan_Set_Num_Geom_Fn(zoltan.get(), dimension, &in), "set-up");
  check(Zoltan_Set_Geom_Multi_Fn(zoltan.get(), coordinates, &in), "set-up");
  return zoltan;
}

/// New part of every place of this process; nothing if Zoltan fails here.
std::optional<std::vector<int>> divide(Zoltan_Struct* zoltan, std::size_t n) {
  int changes, gid_size, lid_size, n_import, n_export;
  ZOLTAN_ID_PTR import_global, import_local, export_global, export_local;
  int *import_rank, *import_part, *export_rank, *export_part;
  const int code = Zoltan_LB_Partition(zoltan, &changes, &gid_size, &lid_size, &n_import, &import_global, &import_local,
                                       &import_rank, &import_part, &n_export, &export_global, &export_local,
                                       &export_rank, &export_part);
  if (code != ZOLTAN_OK && code != ZOLTAN_WARN) return std::nullopt;
  std::vector<int> part(n);
  for (int i = 0; i < n_export; ++i) part[export_local[i]] = export_part[i];
  Zoltan_LB_Free_Part(&import_global, &import_local, &import_rank, &import_part);
  Zoltan_LB_Free_Part(&export_global, &export_local, &export_rank, &export_part);
  return part;
}

struct Box {
  double low[3], high[3];
};

Box box(Zoltan_Struct* zoltan, int part) {
  int dim;
  Box b;
  check(Zoltan_RCB_Box(zoltan, part, &dim, &b.low[0], &b.low[1], &b.low[2], &b.high[0], &b.high[1], &b.high[2]),
        "reading its boxes");
  return b;
}

/// Zoltan's index of a child, a node (> 0) or a part (<= 0), as ours.
int child(int zoltan_index) { return zoltan_index > 0 ? zoltan_index - 1 : ~(-zoltan_index); }

}  // namespace

std::vector<int> Partition::balance(const Comm& comm, int dim, std::span<const Vec3> places,
                                    std::span<const double> weights) {
  if (places.size() != weights.size()) throw std::logic_error("a partition needs one weight a place");
  cuts_.clear();
  root_ = ~0;
  const long n_places = comm.sum(static_cast<long>(places.size()));
  const bool any_weight = comm.any(std::ranges::any_of(weights, [](double w) { return w > 0.0; }));
  if (comm.size() == 1 || n_places == 0) return std::vector<int>(places.size(), 0);
  Input in{comm.rank(), places, weights, !any_weight, dim};
  const Zoltan zoltan = make_zoltan(comm, in);
  std::optional<std::vector<int>> divided = divide(zoltan.get(), places.size());
  if (!comm.all(divided.has_value())) {
    // It fails on some of the processes where there are fewer places than processes: one process has room for those few.
    constexpr long few = 64;
    if (n_places > few * comm.size()) throw RunError("Zoltan: partition failed");
    return std::vector<int>(places.size(), 0);
  }

  // Zoltan walks this tree itself, but through a handle that threads cannot share and that lives on MPI. It does not
  // give its cuts; they follow from the boxes: node k cuts between the parts below k and the others, and neither is
  // part k - 1 cut from above nor part k from below after that. Two axes that both fit can only occur where the earlier
  // cuts have left no space between them; nothing leads there.
  int parent, below, above;
  check(Zoltan_RCB_Partition_Tree(zoltan.get(), 0, &parent, &below, &above), "reading its tree");
  root_ = child(above);
  for (int k = 1; k < comm.size(); ++k) {
    check(Zoltan_RCB_Partition_Tree(zoltan.get(), k, &parent, &below, &above), "reading its tree");
    const Box left = box(zoltan.get(), k - 1), right = box(zoltan.get(), k);
    int axis = 0;  // Zoltan cuts nothing along any axis, the third one in two dimensions included
    while (axis < 3 && left.high[axis] != right.low[axis]) ++axis;
    if (axis == 3) throw RunError("Zoltan: its boxes do not fit together");
    cuts_.push_back({axis, right.low[axis], child(below), child(above)});
  }
  return *divided;
}

int Partition::owner(const Vec3& x) const {
  int node = root_;
  while (node >= 0) node = x[cuts_[node].axis] <= cuts_[node].at ? cuts_[node].below : cuts_[node].above;
  return ~node;
}

double Partition::imbalance(const Comm& comm, double my_weight) {
  const double mean = comm.sum(my_weight) / comm.size(), most = comm.max(my_weight);
  return mean > 0.0 ? most / mean : 1.0;
}

std::vector<double> Partition::numbers() const {
  std::vector<double> out{static_cast<double>(root_)};
  for (const Cut& cut : cuts_)
    out.insert(out.end(),
               {static_cast<double>(cut.axis), cut.at, static_cast<double>(cut.below), static_cast<double>(cut.above)});
  return out;
}

Partition Partition::from_numbers(std::span<const double> numbers) {
  if (numbers.size() % 4 != 1) throw std::logic_error("not the numbers of a partition");
  Partition p;
  p.root_ = static_cast<int>(numbers[0]);
  for (std::size_t i = 1; i < numbers.size(); i += 4)
    p.cuts_.push_back({static_cast<int>(numbers[i]), numbers[i + 1], static_cast<int>(numbers[i + 2]),
                       static_cast<int>(numbers[i + 3])});
  const int n = static_cast<int>(p.cuts_.size());
  for (const Cut& cut : p.cuts_)
    if (cut.axis < 0 || cut.axis > 2 || cut.below >= n || cut.above >= n) throw std::logic_error("not the numbers of a partition");
  if (p.root_ >= n) throw std::logic_error("not the numbers of a partition");
  return p;
}

}  // namespace berm
