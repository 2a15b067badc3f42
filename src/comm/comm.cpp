#include "comm/comm.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <stdexcept>

#include "base/error.hpp"
#include "comm/mpi.hpp"

namespace berm {
namespace {

// MPI counts in int; longer messages travel in pieces.
constexpr std::size_t piece = std::size_t(1) << 30;
constexpr int tag = 4711;

/// Calls f(data, count) for the pieces of a message.
template <class F>
void in_pieces(std::byte* data, std::size_t size, const F& f) {
  for (std::size_t begin = 0; begin < size; begin += piece)
    f(data + begin, static_cast<int>(std::min(piece, size - begin)));
}

template <class T>
T reduce(const Comm& comm, T value, MPI_Datatype type, MPI_Op op) {
  if (comm.size() > 1) MPI_Allreduce(MPI_IN_PLACE, &value, 1, type, op, mpi_comm(comm));
  return value;
}

enum class Failure { none, input, run, other };

[[noreturn]] void fail(Failure failure, const std::string& text) {
  if (failure == Failure::input) throw InputError(text);
  if (failure == Failure::run) throw RunError(text);
  throw std::runtime_error(text);
}

}  // namespace

// MPI ends all processes on errors of its own (MPI_ERRORS_ARE_FATAL), so no return code is looked at here.

Comm Comm::world() {
  static_assert(sizeof(MPI_Comm) <= sizeof(handle_));
  int started = 0, ended = 0;
  MPI_Initialized(&started);
  MPI_Finalized(&ended);
  Comm comm;
  if (!started || ended) return comm;
  const MPI_Comm world = MPI_COMM_WORLD;
  MPI_Comm_rank(world, &comm.rank_);
  MPI_Comm_size(world, &comm.size_);
  std::memcpy(&comm.handle_, &world, sizeof(world));
  return comm;
}

double Comm::sum(double value) const { return reduce(*this, value, MPI_DOUBLE, MPI_SUM); }
double Comm::max(double value) const { return reduce(*this, value, MPI_DOUBLE, MPI_MAX); }
double Comm::min(double value) const { return reduce(*this, value, MPI_DOUBLE, MPI_MIN); }
long Comm::sum(long value) const { return reduce(*this, value, MPI_LONG, MPI_SUM); }
long Comm::max(long value) const { return reduce(*this, value, MPI_LONG, MPI_MAX); }
bool Comm::any(bool value) const { return reduce(*this, int(value), MPI_INT, MPI_MAX) != 0; }
bool Comm::all(bool value) const { return reduce(*this, int(value), MPI_INT, MPI_MIN) != 0; }

void Comm::sum(std::span<double> values) const {
  if (size_ == 1) return;
  const std::size_t most = piece / sizeof(double);
  for (std::size_t begin = 0; begin < values.size(); begin += most)
    MPI_Allreduce(MPI_IN_PLACE, values.data() + begin, static_cast<int>(std::min(most, values.size() - begin)),
                  MPI_DOUBLE, MPI_SUM, mpi_comm(*this));
}

long Comm::exclusive_sum(long value) const {
  long before = 0;
  if (size_ > 1) MPI_Exscan(&value, &before, 1, MPI_LONG, MPI_SUM, mpi_comm(*this));
  return rank_ == 0 ? 0 : before;  // MPI leaves the first one undefined
}

void Comm::barrier() const {
  if (size_ > 1) MPI_Barrier(mpi_comm(*this));
}

void Comm::broadcast_bytes(std::byte* data, std::size_t size, int root) const {
  if (size_ == 1) return;
  in_pieces(data, size, [&](std::byte* at, int count) { MPI_Bcast(at, count, MPI_BYTE, root, mpi_comm(*this)); });
}

std::string Comm::broadcast(std::string text, int root) const {
  text.resize(broadcast(text.size(), root));
  broadcast_bytes(reinterpret_cast<std::byte*>(text.data()), text.size(), root);
  return text;
}

std::vector<std::size_t> Comm::all_gather_bytes(const std::byte* mine, std::size_t size, const Room& room) const {
  std::vector<std::size_t> sizes(size_, size);
  if (size_ > 1) MPI_Allgather(&size, sizeof(size), MPI_BYTE, sizes.data(), sizeof(size), MPI_BYTE, mpi_comm(*this));
  const std::size_t total = std::accumulate(sizes.begin(), sizes.end(), std::size_t(0));
  if (size_ > 1 && total > INT_MAX)
    throw RunError(fmt::format("{} bytes are too many to be gathered on every process", total));
  std::byte* all = room(total);
  if (size_ == 1) {
    if (size > 0) std::memcpy(all, mine, size);
    return sizes;
  }
  const std::vector<int> counts(sizes.begin(), sizes.end());
  std::vector<int> begin(size_, 0);
  std::exclusive_scan(counts.begin(), counts.end(), begin.begin(), 0);
  MPI_Allgatherv(mine, static_cast<int>(size), MPI_BYTE, all, counts.data(), begin.data(), MPI_BYTE, mpi_comm(*this));
  return sizes;
}

std::vector<std::size_t> Comm::gather_bytes(const std::byte* mine, std::size_t size, int root, const Room& room) const {
  std::vector<std::size_t> sizes(rank_ == root ? size_ : 0, size);
  if (size_ > 1) MPI_Gather(&size, sizeof(size), MPI_BYTE, sizes.data(), sizeof(size), MPI_BYTE, root, mpi_comm(*this));
  if (rank_ != root) {
    transfer(std::vector<Message>{{root, const_cast<std::byte*>(mine), size}}, {});
    return sizes;
  }
  std::byte* all = room(std::accumulate(sizes.begin(), sizes.end(), std::size_t(0)));
  std::vector<Message> receive;
  for (int r = 0; r < size_; ++r) {
    if (r != root)
      receive.push_back({r, all, sizes[r]});
    else if (size > 0)
      std::memcpy(all, mine, size);
    if (sizes[r] > 0) all += sizes[r];
  }
  transfer({}, receive);
  return sizes;
}

void Comm::exchange_bytes(const std::vector<std::span<const std::byte>>& to,
                          const std::function<std::byte*(int rank, std::size_t size)>& room) const {
  if (to.size() != std::size_t(size_))
    throw std::logic_error(fmt::format("an exchange among {} processes with {} lists", size_, to.size()));
  std::vector<std::size_t> out(size_), in(size_);
  for (int r = 0; r < size_; ++r) out[r] = to[r].size();
  if (size_ == 1)
    in = out;
  else
    MPI_Alltoall(out.data(), sizeof(out[0]), MPI_BYTE, in.data(), sizeof(in[0]), MPI_BYTE, mpi_comm(*this));
  std::vector<Message> send, receive;
  for (int r = 0; r < size_; ++r) {
    std::byte* place = room(r, in[r]);
    if (r != rank_) {
      send.push_back({r, const_cast<std::byte*>(to[r].data()), out[r]});
      receive.push_back({r, place, in[r]});
    } else if (out[r] > 0) {
      std::memcpy(place, to[r].data(), out[r]);
    }
  }
  transfer(send, receive);
}

void Comm::transfer(std::span<const Message> send, std::span<const Message> receive) const {
  if (size_ == 1) return;
  const MPI_Comm comm = mpi_comm(*this);
  std::vector<MPI_Request> requests;
  for (const Message& m : receive)
    in_pieces(m.data, m.size, [&](std::byte* at, int count) {
      MPI_Irecv(at, count, MPI_BYTE, m.rank, tag, comm, &requests.emplace_back());
    });
  for (const Message& m : send)
    in_pieces(m.data, m.size, [&](std::byte* at, int count) {
      MPI_Isend(at, count, MPI_BYTE, m.rank, tag, comm, &requests.emplace_back());
    });
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

void Comm::agree(const std::function<void()>& work) const {
  if (size_ == 1) return work();
  Failure failure = Failure::none;
  std::string text;
  try {
    work();
  } catch (const InputError& e) {
    failure = Failure::input;
    text = e.what();
  } catch (const RunError& e) {
    failure = Failure::run;
    text = e.what();
  } catch (const std::exception& e) {
    failure = Failure::other;
    text = e.what();
  } catch (...) {
    failure = Failure::other;
    text = "unknown error";
  }
  const int first = reduce(*this, failure == Failure::none ? size_ : rank_, MPI_INT, MPI_MIN);
  if (first == size_) return;
  failure = broadcast(failure, first);
  fail(failure, broadcast(text, first));
}

void Comm::abort(int code) const {
  std::fflush(nullptr);
  if (size_ > 1) MPI_Abort(mpi_comm(*this), code);
  std::_Exit(code);
}

std::vector<std::size_t> Comm::in_units(std::vector<std::size_t> sizes, std::size_t unit) {
  for (auto& size : sizes) size /= unit;
  return sizes;
}

}  // namespace berm
