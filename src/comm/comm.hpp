#pragma once
/// A group of processes that work on one run: sums, exchanges, and errors that end all of them alike.
///
/// Every function except rank(), size() and abort() is collective: all processes of the group call it, in the same
/// order. A process alone calls no MPI function at all, so that whatever is built on this needs no MPI to be tested.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace berm {

/// Whether T may travel as its bytes. Specialise it for structs of fixed-size Eigen matrices, which are as plain as the
/// matrices but which the compiler does not know for it.
template <class T>
inline constexpr bool is_plain = std::is_trivially_copyable_v<T>;
template <class S, int rows, int columns, int options>
requires(rows > 0 &&
         columns >
             0) inline constexpr bool is_plain<Eigen::Matrix<S, rows, columns, options, rows, columns>> = is_plain<S>;

template <class T>
concept Plain = is_plain<T> && std::is_trivially_destructible_v<T> && !std::is_pointer_v<T> && !std::is_same_v<T, bool>;

/// Bytes that go to, or come from, another process.
struct Message {
  int rank;
  std::byte* data;
  std::size_t size;
};

class Comm {
public:
  /// This process alone.
  Comm() = default;
  /// All processes if MPI runs with more than one, else this process alone.
  static Comm world();

  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }

  // Results are the same on all processes, to the last bit.
  double sum(double value) const;
  double max(double value) const;
  double min(double value) const;
  long sum(long value) const;
  long max(long value) const;
  /// Sums place by place, in place; as many values on every process.
  void sum(std::span<double> values) const;
  bool any(bool value) const;
  bool all(bool value) const;
  /// Sum over the processes of lower rank.
  long exclusive_sum(long value) const;

  void barrier() const;

  template <Plain T>
  T broadcast(T value, int root = 0) const {
    broadcast_bytes(reinterpret_cast<std::byte*>(&value), sizeof(T), root);
    return value;
  }

  /// The root's values; what the others give is ignored, its length too.
  template <Plain T>
  std::vector<T> broadcast(std::vector<T> values, int root = 0) const {
    values.resize(broadcast(values.size(), root));
    broadcast_bytes(bytes(values), values.size() * sizeof(T), root);
    return values;
  }

  std::string broadcast(std::string text, int root = 0) const;

  /// The values of all processes in the order of rank; counts: how many came from each. Meant for little data: throws
  /// RunError above 2 GiB.
  template <Plain T>
  std::vector<T> all_gather(const std::vector<T>& mine, std::vector<std::size_t>* counts = nullptr) const {
    std::vector<T> all;
    const auto sizes = all_gather_bytes(bytes(mine), mine.size() * sizeof(T), room(all));
    if (counts) *counts = in_units(sizes, sizeof(T));
    return all;
  }

  /// As all_gather, of any size, on the root only; the others get nothing.
  template <Plain T>
  std::vector<T> gather(const std::vector<T>& mine, int root = 0, std::vector<std::size_t>* counts = nullptr) const {
    std::vector<T> all;
    const auto sizes = gather_bytes(bytes(mine), mine.size() * sizeof(T), root, room(all));
    if (counts) *counts = in_units(sizes, sizeof(T));
    return all;
  }

  /// to[r] goes to process r; returns what came from each. Only those with something to say to each other talk.
  template <Plain T>
  std::vector<std::vector<T>> exchange(const std::vector<std::vector<T>>& to) const {
    std::vector<std::span<const std::byte>> out;
    for (const auto& values : to) out.emplace_back(bytes(values), values.size() * sizeof(T));
    std::vector<std::vector<T>> from(size_);
    exchange_bytes(out, [&](int rank, std::size_t size) { return room(from[rank])(size); });
    return from;
  }

  /// Sends and receives at once between neighbours who know of each other, sizes included. Not collective. Messages
  /// of no bytes are left out; one to oneself is not allowed.
  void transfer(std::span<const Message> send, std::span<const Message> receive) const;

  /// Runs work, which must not communicate. If it throws anywhere, every process throws the error of the lowest rank
  /// that failed: InputError and RunError as what they are, anything else as std::runtime_error with its text.
  void agree(const std::function<void()>& work) const;

  /// Ends all processes at once, for ends that nobody foresaw.
  [[noreturn]] void abort(int code) const;

  /// The MPI_Comm, for comm/mpi.hpp; null for a process alone.
  const void* handle() const { return size_ > 1 ? &handle_ : nullptr; }

private:
  /// Makes room for that many bytes and says where.
  using Room = std::function<std::byte*(std::size_t size)>;

  void broadcast_bytes(std::byte* data, std::size_t size, int root) const;
  std::vector<std::size_t> all_gather_bytes(const std::byte* mine, std::size_t size, const Room& room) const;
  std::vector<std::size_t> gather_bytes(const std::byte* mine, std::size_t size, int root, const Room& room) const;
  void exchange_bytes(const std::vector<std::span<const std::byte>>& to,
                      const std::function<std::byte*(int rank, std::size_t size)>& room) const;

  template <class T>
  static std::byte* bytes(std::vector<T>& values) {
    return reinterpret_cast<std::byte*>(values.data());
  }
  template <class T>
  static const std::byte* bytes(const std::vector<T>& values) {
    return reinterpret_cast<const std::byte*>(values.data());
  }
  template <class T>
  static Room room(std::vector<T>& values) {
    return [&values](std::size_t size) {
      values.resize(size / sizeof(T));
      return bytes(values);
    };
  }
  static std::vector<std::size_t> in_units(std::vector<std::size_t> sizes, std::size_t unit);

  int rank_ = 0;
  int size_ = 1;
  std::uintptr_t handle_ = 0;  ///< bytes of an MPI_Comm, which is a pointer or an int
};

}  // namespace berm
