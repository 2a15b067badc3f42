#include "comm/halo.hpp"

#include <algorithm>

#include "base/sort_unique.hpp"

namespace berm {
namespace {

using Ids = std::vector<std::int64_t>;

/// Index of id in the ascending list, or -1.
int index_in(std::span<const std::int64_t> list, std::int64_t id) {
  const auto it = std::ranges::lower_bound(list, id);
  return it != list.end() && *it == id ? static_cast<int>(it - list.begin()) : -1;
}

/// The ids of all lists, ascending, each once.
Ids merge(const std::vector<Ids>& lists) {
  Ids all;
  for (const Ids& list : lists) all.insert(all.end(), list.begin(), list.end());
  sort_unique(all);
  return all;
}

std::vector<int> indices_in(std::span<const std::int64_t> list, const Ids& ids) {
  std::vector<int> out;
  for (const std::int64_t id : ids) out.push_back(index_in(list, id));
  return out;
}

}  // namespace

int Halo::find(std::int64_t id) const {
  const std::span all(ids);
  const int owned = index_in(all.first(n_owned), id);
  if (owned >= 0) return owned;
  const int ghost = index_in(all.subspan(n_owned), id);
  return ghost >= 0 ? n_owned + ghost : -1;
}

void Halo::Side::append(int rank, const std::vector<int>& more) {
  if (more.empty()) return;
  ranks.push_back(rank);
  nodes.insert(nodes.end(), more.begin(), more.end());
  begin.push_back(nodes.size());
}

void Halo::swap_bytes(const Side& from, std::byte* out, const Side& to, std::byte* in, std::size_t node_size) const {
  const auto messages = [&](const Side& side, std::byte* data, std::vector<Message>& list) {
    list.clear();
    for (std::size_t i = 0; i < side.ranks.size(); ++i)
      list.push_back(
          {side.ranks[i], data + side.begin[i] * node_size, (side.begin[i + 1] - side.begin[i]) * node_size});
  };
  messages(from, out, out_);
  messages(to, in, in_);
  comm_.transfer(out_, in_);
}

Halo build_halo(const Comm& comm, std::span<const std::int64_t> touched, const std::function<int(std::int64_t)>& home) {
  std::vector<Ids> by_home(comm.size());
  for (const std::int64_t id : touched) by_home[home(id)].push_back(id);
  const std::vector<Ids> wanted = comm.exchange(by_home);

  Halo halo;
  halo.comm_ = comm;
  halo.ids = merge(wanted);
  halo.n_owned = static_cast<int>(halo.ids.size());
  halo.first = comm.exclusive_sum(halo.n_owned);
  halo.n_global = comm.sum(static_cast<long>(halo.n_owned));
  const Ids owned = halo.ids;
  by_home[comm.rank()].clear();  // what is left are ghosts
  const Ids ghosts = merge(by_home);
  halo.ids.insert(halo.ids.end(), ghosts.begin(), ghosts.end());

  // The owners answer with their numbers, in the order in which they were asked.
  std::vector<Ids> answers(comm.size());
  for (int r = 0; r < comm.size(); ++r) {
    if (r == comm.rank()) continue;
    std::vector<int> nodes = indices_in(owned, wanted[r]);
    for (const int node : nodes) answers[r].push_back(halo.first + node);
    halo.shared_.append(r, nodes);
    nodes = indices_in(ghosts, by_home[r]);
    for (int& node : nodes) node += halo.n_owned;
    halo.ghosts_.append(r, nodes);
  }
  halo.global.resize(halo.ids.size());
  for (int i = 0; i < halo.n_owned; ++i) halo.global[i] = halo.first + i;
  const std::vector<Ids> numbers = comm.exchange(answers);
  auto node = halo.ghosts_.nodes.begin();
  for (const Ids& list : numbers)
    for (const std::int64_t number : list) halo.global[*node++] = number;
  return halo;
}

}  // namespace berm
