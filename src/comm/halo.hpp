#pragma once
/// Nodes at the borders between processes: who owns them, their numbers in the whole, and the exchange of values.

#include <cstdint>
#include <functional>
#include <span>
#include <type_traits>
#include <vector>

#include "comm/comm.hpp"

namespace berm {

/// The nodes of this process: the owned ones, then ghosts, which others own. Every node has one owner, its home.
class Halo {
public:
  std::vector<std::int64_t> ids;     ///< owned nodes ascending, then ghosts ascending
  int n_owned = 0;                   ///< how many of them are owned
  std::int64_t first = 0;            ///< number of the first owned node: processes number theirs one after the other
  std::vector<std::int64_t> global;  ///< number of each local node in the whole
  std::int64_t n_global = 0;         ///< nodes of all processes, each counted once

  int size() const { return static_cast<int>(ids.size()); }
  /// Local index of a node, or -1.
  int find(std::int64_t id) const;

  /// Adds the values of ghosts to those of their owners, `stride` numbers a node, in the order of rank: the same sum
  /// in every run. char: or. The ghosts keep their values. Collective.
  template <class T>
  void add_to_owners(T* data, int stride) const {
    combine_at_owners(data, stride, [](T& sum, T value) { add(sum, value); });
  }
  /// The same with combine(T& owners, T other) in place of a sum.
  template <class T, class Combine>
  void combine_at_owners(T* data, int stride, Combine combine) const {
    static_assert(std::is_arithmetic_v<T>);
    T* out = pack(ghosts_, data, stride, send_);
    T* in = swap<T>(ghosts_, out, shared_, stride);
    for (const int node : shared_.nodes)
      for (int i = 0; i < stride; ++i) combine(data[std::size_t(node) * stride + i], *in++);
  }

  /// The owners' values to all ghosts. Collective.
  template <class T>
  void copy_to_ghosts(T* data, int stride) const {
    static_assert(std::is_trivially_copyable_v<T>);
    T* out = pack(shared_, data, stride, send_);
    T* in = swap<T>(shared_, out, ghosts_, stride);
    for (const int node : ghosts_.nodes)
      for (int i = 0; i < stride; ++i) data[std::size_t(node) * stride + i] = *in++;
  }

private:
  friend Halo build_halo(const Comm&, std::span<const std::int64_t>, const std::function<int(std::int64_t)>&);

  /// Local nodes in the order in which they are sent or received, grouped by neighbour in the order of rank.
  struct Side {
    std::vector<int> ranks;
    std::vector<std::size_t> begin{0};  ///< where each neighbour's nodes begin, and the end
    std::vector<int> nodes;

    void append(int rank, const std::vector<int>& more);
  };

  /// vector<double> for its alignment.
  using Buffer = std::vector<double>;
  template <class T>
  static T* room(Buffer& buffer, std::size_t n) {
    const std::size_t words = (n * sizeof(T) + sizeof(double) - 1) / sizeof(double);
    if (buffer.size() < words) buffer.resize(words);
    return reinterpret_cast<T*>(buffer.data());
  }

  template <class T>
  static T* pack(const Side& side, const T* data, int stride, Buffer& buffer) {
    T* out = room<T>(buffer, side.nodes.size() * stride);
    T* to = out;
    for (const int node : side.nodes)
      for (int i = 0; i < stride; ++i) *to++ = data[std::size_t(node) * stride + i];
    return out;
  }

  template <class T>
  T* swap(const Side& from, T* out, const Side& to, int stride) const {
    T* in = room<T>(receive_, to.nodes.size() * stride);
    swap_bytes(from, reinterpret_cast<std::byte*>(out), to, reinterpret_cast<std::byte*>(in), sizeof(T) * stride);
    return in;
  }

  void swap_bytes(const Side& from, std::byte* out, const Side& to, std::byte* in, std::size_t node_size) const;

  template <class T>
  static void add(T& sum, T value) {
    if constexpr (sizeof(T) == 1)
      sum = static_cast<T>(sum | value);
    else
      sum += value;
  }

  Comm comm_;
  Side ghosts_;                            ///< ghosts, by their owners
  Side shared_;                            ///< owned nodes that are ghosts elsewhere, by where
  mutable Buffer send_, receive_;          ///< kept from call to call
  mutable std::vector<Message> out_, in_;  ///< likewise
};

/// touched: the nodes that this process works with, ascending and without repetition. home: the rank that owns a node,
/// the same answer on every process; it owns the node even if it does not touch it. Collective.
Halo build_halo(const Comm& comm, std::span<const std::int64_t> touched, const std::function<int(std::int64_t)>& home);

}  // namespace berm
