// The same tests on every process of `mpiexec -n N`; any N works.

#include "comm/comm.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <mpi.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <set>
#include <stdexcept>

#include "base/error.hpp"
#include "comm/halo.hpp"
#include "comm/hdf5_file.hpp"
#include "comm/partition.hpp"
#include "comm/seal.hpp"

namespace berm {
namespace {

namespace fs = std::filesystem;

const Comm& world() {
  static const Comm comm = Comm::world();
  return comm;
}
int rank() { return world().rank(); }
int size() { return world().size(); }

/// Type and text of what f throws.
template <class F>
std::string error_of(F f) {
  try {
    f();
  } catch (const InputError& e) {
    return std::string("input: ") + e.what();
  } catch (const RunError& e) {
    return std::string("run: ") + e.what();
  } catch (const std::exception& e) {
    return std::string("other: ") + e.what();
  }
  return "none";
}

/// Whether all processes have the same bytes.
template <class T>
bool same_everywhere(const std::vector<T>& values) {
  return world().all(world().broadcast(values) == values);
}

// ---- Comm

TEST(Comm, SumsAndExtremes) {
  const int n = size();
  EXPECT_EQ(world().sum(rank() + 0.5), n * (n - 1) / 2 + 0.5 * n);
  EXPECT_EQ(world().max(rank() + 0.5), n - 0.5);
  EXPECT_EQ(world().min(rank() + 0.5), 0.5);
  EXPECT_EQ(world().sum((1L << 40) + rank()), (1L << 40) * n + n * (n - 1) / 2);
  EXPECT_EQ(world().max(long(rank())), n - 1);
  EXPECT_EQ(world().exclusive_sum(rank() + 1), long(rank()) * (rank() + 1) / 2);
  EXPECT_TRUE(world().any(rank() == n - 1));
  EXPECT_FALSE(world().any(false));
  EXPECT_TRUE(world().all(true));
  EXPECT_EQ(world().all(rank() != n - 1), false);
  world().barrier();
}

TEST(Comm, SumsAreTheSameBitsEverywhere) {
  std::mt19937 random(rank());
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> values(1001);
  for (double& v : values) v = uniform(random) * std::pow(10.0, 20.0 * uniform(random));
  const std::vector<double> single{world().sum(values[0])};
  world().sum(std::span<double>(values));
  EXPECT_TRUE(same_everywhere(values));
  EXPECT_TRUE(same_everywhere(single));
  world().sum(std::span<double>());
}

TEST(Comm, Broadcasts) {
  for (int root = 0; root < size(); ++root) {
    EXPECT_EQ(world().broadcast(rank() * 10, root), root * 10);
    EXPECT_EQ(world().broadcast(std::string(rank(), 'x'), root), std::string(root, 'x'));
    EXPECT_EQ(world().broadcast(std::vector<long>(rank(), rank()), root), std::vector<long>(root, root));
  }
}

TEST(Comm, Gathers) {
  const std::vector<int> mine(rank(), rank());
  std::vector<int> expected;
  std::vector<std::size_t> expected_counts, counts;
  for (int r = 0; r < size(); ++r) {
    expected.insert(expected.end(), r, r);
    expected_counts.push_back(r);
  }
  EXPECT_EQ(world().all_gather(mine, &counts), expected);
  EXPECT_EQ(counts, expected_counts);
  for (int root = 0; root < size(); ++root) {
    const auto all = world().gather(mine, root, &counts);
    EXPECT_EQ(all, rank() == root ? expected : std::vector<int>{});
    EXPECT_EQ(counts, rank() == root ? expected_counts : std::vector<std::size_t>{});
  }
  EXPECT_TRUE(world().all_gather(std::vector<double>{}).empty());
}

TEST(Comm, ExchangesSparsely) {
  // Each process writes to itself and to the next one; the length tells who did.
  std::vector<std::vector<double>> to(size());
  const int next = (rank() + 1) % size();
  to[rank()] = {rank() + 0.25};
  to[next].insert(to[next].end(), 1000 + rank(), rank() + 0.5);
  const auto from = world().exchange(to);
  ASSERT_EQ(from.size(), to.size());
  const int previous = (rank() + size() - 1) % size();
  for (int r = 0; r < size(); ++r) {
    std::vector<double> expected;
    if (r == rank()) expected.push_back(r + 0.25);
    if (r == previous) expected.insert(expected.end(), 1000 + r, r + 0.5);
    EXPECT_EQ(from[r], expected) << r;
  }
}

TEST(Comm, ExchangesAtRandomAndNothing) {
  std::mt19937 random(1);
  for (int round = 0; round < 20; ++round) {
    // Everybody draws the whole table of lengths.
    std::vector<std::vector<int>> length(size(), std::vector<int>(size()));
    for (auto& row : length)
      for (int& n : row) n = round == 0 || random() % 3 ? 0 : int(random() % 100);
    std::vector<std::vector<Vec3>> to(size());
    for (int r = 0; r < size(); ++r) to[r].assign(length[rank()][r], Vec3(rank(), r, round));
    const auto from = world().exchange(to);
    for (int r = 0; r < size(); ++r) EXPECT_EQ(from[r], std::vector<Vec3>(length[r][rank()], Vec3(r, rank(), round)));
  }
}

TEST(Comm, AgreesOnErrors) {
  const int last = size() - 1;
  EXPECT_EQ(error_of([] { world().agree([] {}); }), "none");
  EXPECT_EQ(error_of([&] {
              world().agree([&] {
                if (rank() == last) throw InputError("line 3");
              });
            }),
            "input: line 3");
  EXPECT_EQ(error_of([&] {
              world().agree([&] {
                if (rank() == last) throw RunError("no disk");
              });
            }),
            "run: no disk");
  EXPECT_EQ(error_of([&] {
              world().agree([&] {
                if (rank() == last) throw std::range_error("far");
              });
            }),
            "other: far");
  EXPECT_EQ(error_of([&] {
              world().agree([&] {
                if (rank() == last) throw RunError("");
              });
            }),
            "run: ");
  // Several fail, each in its way: the lowest speaks.
  EXPECT_EQ(error_of([&] {
              world().agree([&] {
                if (rank() == size() / 2) throw RunError("lowest");
                if (rank() > size() / 2) throw InputError("rank " + std::to_string(rank()));
              });
            }),
            "run: lowest");
}

// ---- Partition

struct Cloud {
  std::vector<Vec3> places;
  std::vector<double> weights;
};

/// Denser towards the origin; weights from 1 to 20.
Cloud cloud(int dim, int n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Cloud c;
  for (int i = 0; i < n; ++i) {
    Vec3 x = Vec3::Zero();
    for (int d = 0; d < dim; ++d) x[d] = (d + 1) * std::pow(uniform(random), 1 + d);
    c.places.push_back(x);
    c.weights.push_back(1 + int(random() % 20));
  }
  return c;
}

/// Weight of this process's part after the partition.
double new_weight(const Partition& p, const Cloud& c) {
  std::vector<double> weight(size(), 0.0);
  for (std::size_t i = 0; i < c.places.size(); ++i) weight[p.owner(c.places[i])] += c.weights[i];
  world().sum(std::span<double>(weight));
  return weight[rank()];
}

void expect_one_answer(const Partition& p) {
  EXPECT_TRUE(same_everywhere(p.numbers()));
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.5, 1.0);
  std::vector<int> owners;
  for (int i = 0; i < 100000; ++i) {
    owners.push_back(p.owner(Vec3(normal(random), normal(random), normal(random))));
    ASSERT_TRUE(owners.back() >= 0 && owners.back() < size());
  }
  EXPECT_TRUE(same_everywhere(owners));
  const Partition copy = Partition::from_numbers(p.numbers());
  std::mt19937 again(5);
  normal.reset();
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(copy.owner(Vec3(normal(again), normal(again), normal(again))), owners[i]);
}

TEST(Partition, BalancesClouds) {
  for (const int dim : {2, 3}) {
    const Cloud mine = cloud(dim, 20000, 100 * dim + rank());
    Partition p;
    const auto part = p.balance(world(), dim, mine.places, mine.weights);
    ASSERT_EQ(part.size(), mine.places.size());
    for (std::size_t i = 0; i < part.size(); ++i) ASSERT_EQ(p.owner(mine.places[i]), part[i]);
    EXPECT_LT(Partition::imbalance(world(), new_weight(p, mine)), 1.05);
    expect_one_answer(p);
    Partition again;
    again.balance(world(), dim, mine.places, mine.weights);
    EXPECT_EQ(again.numbers(), p.numbers());
  }
}

TEST(Partition, DependsOnPlacesNotOnWhoHasThem) {
  // All places on one process, and dealt out.
  const Cloud all = cloud(3, 5000, 7);
  Cloud dealt;
  for (std::size_t i = rank(); i < all.places.size(); i += size()) {
    dealt.places.push_back(all.places[i]);
    dealt.weights.push_back(all.weights[i]);
  }
  const Cloud lonely = rank() == size() - 1 ? all : Cloud();
  Partition a, b;
  a.balance(world(), 3, dealt.places, dealt.weights);
  b.balance(world(), 3, lonely.places, lonely.weights);
  for (const Vec3& x : all.places) ASSERT_EQ(a.owner(x), b.owner(x));
  EXPECT_LT(Partition::imbalance(world(), new_weight(b, lonely)), 1.05);
}

TEST(Partition, BalancesCellsOfAGrid) {
  // Columns of cells with the same coordinate, and a moving body: what the program does.
  for (int step = 0; step < 5; ++step) {
    Cloud mine;
    for (int i = 0; i < 100; ++i)
      for (int j = 0; j < 60; ++j)
        if ((i * 60 + j) % size() == rank() && std::hypot(i - 30 - 5 * step, j - 30) < 25) {
          mine.places.emplace_back(0.1 * (i + 0.5), 0.1 * (j + 0.5), 0.0);
          mine.weights.push_back(4.0);
        }
    Partition p;
    const auto part = p.balance(world(), 2, mine.places, mine.weights);
    for (std::size_t i = 0; i < part.size(); ++i) {
      EXPECT_EQ(p.owner(mine.places[i]), part[i]);
      EXPECT_EQ(p.owner(mine.places[i] + Vec3(1e-9, -1e-9, 0)), part[i]);  // no cut through a column
    }
    EXPECT_LT(Partition::imbalance(world(), new_weight(p, mine)), 1.1);
  }
}

TEST(Partition, WorksWithFewPlacesAndOnLines) {
  const auto owners = [](const Cloud& mine, int dim) {
    Partition p;
    const auto part = p.balance(world(), dim, mine.places, mine.weights);
    for (std::size_t i = 0; i < part.size(); ++i) EXPECT_EQ(p.owner(mine.places[i]), part[i]);
    expect_one_answer(p);
    const auto all = world().all_gather(part);
    return std::set<int>(all.begin(), all.end()).size();
  };
  for (const int dim : {2, 3}) {
    EXPECT_EQ(owners({}, dim), 0u);
    const Cloud one{{Vec3(3, 4, 5)}, {1.0}};
    EXPECT_EQ(owners(rank() == size() - 1 ? one : Cloud(), dim), 1u);
    EXPECT_EQ(owners(one, dim), 1u);  // all at the same place
    const Cloud two{{Vec3(0, 0, 0), Vec3(0, 1, 0)}, {1.0, 1.0}};
    EXPECT_EQ(owners(rank() == 0 ? two : Cloud(), dim), std::size_t(std::min(2, size())));
    Cloud line, plane;
    for (int i = 0; i < 40; ++i) {
      line.places.emplace_back(2.0, 0.5 + i + 40 * rank(), 7.0);
      line.weights.push_back(1.0);
      plane.places.emplace_back(0.1 * i, 1.0, dim == 3 ? rank() : 0);
      plane.weights.push_back(1.0);
    }
    EXPECT_EQ(owners(line, dim), std::size_t(size()));
    EXPECT_EQ(owners(plane, dim), std::size_t(size()));
    for (double& w : line.weights) w = 0.0;
    EXPECT_EQ(owners(line, dim), std::size_t(size()));  // no weight at all: as if equal
  }
}

TEST(Partition, MeasuresImbalance) {
  EXPECT_DOUBLE_EQ(Partition::imbalance(world(), rank() == 0 ? 2.0 : 1.0), 2.0 * size() / (size() + 1));
}

// ---- Halo

struct Nodes {
  std::vector<std::vector<std::int64_t>> touched;  ///< of all processes
  std::function<int(std::int64_t)> home;
};

/// Random sets; homes at random as well, so that some do not touch what they own, and some nodes nobody touches.
Nodes random_nodes(unsigned seed, int n) {
  std::mt19937 random(seed);
  Nodes nodes;
  nodes.touched.resize(size());
  for (auto& list : nodes.touched)
    for (int i = 0; i < n; ++i)
      if (random() % 3 == 0) list.push_back((1LL << 35) + 7 * i);
  nodes.home = [seed](std::int64_t id) { return int((std::uint64_t(id) * 2654435761u + seed) / 64 % size()); };
  return nodes;
}

TEST(Halo, NumbersEveryNodeOnce) {
  for (const int n : {0, 1, 5, 2000}) {
    const Nodes nodes = random_nodes(n, n);
    const auto& mine = nodes.touched[rank()];
    const Halo halo = build_halo(world(), mine, nodes.home);

    std::set<std::int64_t> owned, ghosts, everything;
    for (const auto& list : nodes.touched)
      for (const auto id : list) {
        everything.insert(id);
        if (nodes.home(id) == rank()) owned.insert(id);
      }
    for (const auto id : mine)
      if (!owned.count(id)) ghosts.insert(id);
    std::vector<std::int64_t> expected(owned.begin(), owned.end());
    expected.insert(expected.end(), ghosts.begin(), ghosts.end());
    EXPECT_EQ(halo.ids, expected);
    EXPECT_EQ(halo.n_owned, int(owned.size()));
    EXPECT_EQ(halo.n_global, std::int64_t(everything.size()));
    EXPECT_EQ(halo.first, world().exclusive_sum(halo.n_owned));
    for (int i = 0; i < halo.size(); ++i) EXPECT_EQ(halo.find(halo.ids[i]), i);

    // Every number belongs to one id, whoever says it.
    ASSERT_EQ(halo.global.size(), halo.ids.size());
    const auto ids = world().all_gather(halo.ids), numbers = world().all_gather(halo.global);
    std::map<std::int64_t, std::int64_t> number_of, id_of;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      EXPECT_EQ(number_of.emplace(ids[i], numbers[i]).first->second, numbers[i]);
      EXPECT_EQ(id_of.emplace(numbers[i], ids[i]).first->second, ids[i]);
    }
    EXPECT_EQ(number_of.size(), everything.size());
    EXPECT_EQ(id_of.empty() ? -1 : id_of.rbegin()->first, halo.n_global - 1);
  }
}

/// Value of process r at a node.
template <class T>
T value(int r, std::int64_t id, int component) {
  if constexpr (std::is_same_v<T, char>)
    return (id / 7 + r + component) % 4 == 0 ? 1 : 0;
  else
    return static_cast<T>(std::sin(double(id % 1000) + 3.0 * r + component) * 1000);
}

/// Sums over the processes, or "or", as a single process would find them.
template <class T>
void compare_with_serial(const Nodes& nodes, int stride) {
  const Halo halo = build_halo(world(), nodes.touched[rank()], nodes.home);
  const auto touches = [&](int r, std::int64_t id) { return std::ranges::binary_search(nodes.touched[r], id); };
  for (int repeat = 0; repeat < 2; ++repeat) {  // the buffers are used again
    std::vector<T> data(std::size_t(halo.size()) * stride, T(0));
    for (int i = 0; i < halo.size(); ++i)
      for (int k = 0; k < stride; ++k)
        if (touches(rank(), halo.ids[i])) data[i * stride + k] = value<T>(rank(), halo.ids[i], k);
    halo.add_to_owners(data.data(), stride);
    halo.copy_to_ghosts(data.data(), stride);
    for (int i = 0; i < halo.size(); ++i)
      for (int k = 0; k < stride; ++k) {
        T sum = 0;
        for (int r = 0; r < size(); ++r)
          if (touches(r, halo.ids[i])) {
            const T v = value<T>(r, halo.ids[i], k);
            sum = std::is_same_v<T, char> ? std::max(sum, v) : static_cast<T>(sum + v);
          }
        if constexpr (std::is_floating_point_v<T>)
          EXPECT_NEAR(data[i * stride + k], sum, 1e-9);
        else
          EXPECT_EQ(data[i * stride + k], sum);
      }
  }
}

TEST(Halo, SumsLikeOneProcess) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Nodes nodes = random_nodes(seed, 40 * int(seed));
    compare_with_serial<double>(nodes, 3);
    compare_with_serial<int>(nodes, 1);
    compare_with_serial<std::int64_t>(nodes, 2);
    compare_with_serial<char>(nodes, 5);
  }
}

TEST(Halo, OwnsWhatItDoesNotTouch) {
  // Process 0 owns everything and touches nothing, if there are others.
  std::vector<std::int64_t> touched{10, 20, 30};
  if (size() > 1 && rank() == 0) touched.clear();
  const Halo halo = build_halo(world(), touched, [](std::int64_t) { return 0; });
  EXPECT_EQ(halo.size(), 3);
  EXPECT_EQ(halo.n_owned, rank() == 0 ? 3 : 0);
  EXPECT_EQ(halo.global, (std::vector<std::int64_t>{0, 1, 2}));
  std::vector<double> x(3, rank() == 0 && size() > 1 ? 0.0 : 1.0);
  halo.add_to_owners(x.data(), 1);
  halo.copy_to_ghosts(x.data(), 1);
  EXPECT_EQ(x, std::vector<double>(3, std::max(1, size() - 1)));
}

TEST(Halo, AddsInTheOrderOfRank) {
  // A sum that depends on the order: the owner's own value first, then the others' ascending.
  const std::vector<std::int64_t> touched{1};
  const Halo halo = build_halo(world(), touched, [](std::int64_t) { return size() - 1; });
  const auto term = [](int r) { return r % 2 ? 1e16 : 1.0 / (r + 1); };
  double expected = term(size() - 1);
  for (int r = 0; r < size() - 1; ++r) expected += term(r);
  for (int repeat = 0; repeat < 50; ++repeat) {
    double x = term(rank());
    halo.add_to_owners(&x, 1);
    halo.copy_to_ghosts(&x, 1);
    EXPECT_EQ(x, expected);
  }
}

// ---- Checkpoints

class Checkpoint : public testing::Test {
protected:
  Checkpoint() {
    folder_ = world().broadcast((fs::temp_directory_path() / ("berm_parallel_" + std::to_string(getpid()))).string());
    if (rank() == 0) fs::create_directories(folder_);
    file = folder_ + "/run.h5";
    world().barrier();
  }
  ~Checkpoint() override {
    world().barrier();
    if (rank() == 0) fs::remove_all(folder_);
  }

  static void write(const Comm& comm, const std::string& path, int n, double value) {
    auto out = CheckpointFile::create(comm, path);
    std::vector<double> x;
    std::vector<std::int64_t> id;
    for (int i = 0; i < n; ++i)
      if (i * comm.size() / n == comm.rank()) {
        x.insert(x.end(), {value + i, value - i});
        id.push_back(i);
      }
    out.write("points/x", x, 2);
    out.write("points/id", id);
    out.write("flag", std::vector<std::uint8_t>(comm.rank(), std::uint8_t(comm.rank())));
    out.write("cell", comm.is_root() ? std::vector<std::int32_t>{} : std::vector<std::int32_t>{comm.rank()});
    out.write("none", std::vector<double>{}, 3);
    out.write_text("case", "title = 1\n" + std::string(100000, 'x'));
    out.write_number("time", value);
    out.commit();
  }

  std::string file;

private:
  std::string folder_;
};

TEST_F(Checkpoint, ReturnsWhatWasWritten) {
  constexpr int n = 10007;
  write(world(), file, n, 0.5);
  EXPECT_FALSE(fs::exists(file + ".part"));
  const auto in = CheckpointFile::open(world(), file);
  ASSERT_EQ(in.rows("points/x"), n);
  EXPECT_EQ(in.rows("none"), 0);
  EXPECT_EQ(in.rows("flag"), size() * (size() - 1) / 2);
  EXPECT_EQ(in.rows("cell"), size() - 1);
  EXPECT_EQ(in.read_number("time"), 0.5);
  EXPECT_EQ(in.read_text("case").size(), 100010u);
  // Slices that are not those of the writers, and all.
  const std::int64_t first = std::int64_t(n) * rank() / (size() + 1), rows = n / 2;
  for (const auto& [begin, count] : {std::pair{first, rows}, std::pair{std::int64_t(0), std::int64_t(n)}}) {
    const auto x = in.read_rows<double>("points/x", begin, std::min(count, n - begin), 2);
    const auto id = in.read_rows<std::int64_t>("points/id", begin, std::min(count, n - begin));
    for (std::size_t i = 0; i < id.size(); ++i) {
      ASSERT_EQ(id[i], begin + std::int64_t(i));
      ASSERT_EQ(x[2 * i], 0.5 + id[i]);
      ASSERT_EQ(x[2 * i + 1], 0.5 - id[i]);
    }
  }
}

TEST_F(Checkpoint, HasTheSameContentFromAnyNumberOfProcesses) {
  write(world(), file, 1000, 2.0);
  if (rank() == 0) write(Comm(), file + ".alone", 1000, 2.0);
  world().barrier();
  // One process reads what all wrote, all read what one wrote.
  const auto together = CheckpointFile::open(world(), file), alone = CheckpointFile::open(world(), file + ".alone");
  for (const auto* in : {&together, &alone}) {
    const auto x = in->read_rows<double>("points/x", 0, 1000, 2);
    EXPECT_EQ(x[2 * 999], 1001.0);
    EXPECT_TRUE(same_everywhere(x));
  }
  EXPECT_EQ(together.read_rows<double>("points/x", 0, 1000, 2), alone.read_rows<double>("points/x", 0, 1000, 2));
  EXPECT_EQ(together.read_text("case"), alone.read_text("case"));
  if (rank() == 0) {
    const auto in = CheckpointFile::open(Comm(), file);
    EXPECT_EQ(in.read_rows<std::int64_t>("points/id", 999, 1)[0], 999);
  }
}

TEST_F(Checkpoint, IgnoresAndReplacesALeftOver) {
  write(world(), file, 100, 1.0);
  if (rank() == 0) std::ofstream(file + ".part") << std::string(1000000, '?');
  world().barrier();
  EXPECT_EQ(CheckpointFile::open(world(), file).read_number("time"), 1.0);
  {
    auto abandoned = CheckpointFile::create(world(), file);
    abandoned.write("points/x", std::vector<double>(10, 2.0));
  }
  world().barrier();
  EXPECT_FALSE(fs::exists(file + ".part"));
  EXPECT_EQ(CheckpointFile::open(world(), file).read_number("time"), 1.0);
  write(world(), file, 100, 3.0);
  EXPECT_EQ(CheckpointFile::open(world(), file).read_number("time"), 3.0);
}

TEST_F(Checkpoint, RefusesOtherFilesAlike) {
  const auto refusal = [&] { return error_of([&] { CheckpointFile::open(world(), file); }); };
  const auto change = [&](const std::function<void()>& f) {
    if (rank() == 0) f();
    world().barrier();
  };
  EXPECT_EQ(refusal(), "input: cannot read " + file + ": No such file or directory");
  change([&] { std::ofstream(file) << "no HDF5"; });
  EXPECT_EQ(refusal(), "input: " + file + " is not a checkpoint of berm: it is no HDF5 file");

  write(world(), file, 1000, 1.0);
  change([&] { fs::resize_file(file, fs::file_size(file) / 2); });
  const std::string words = "input: " + file + " is not a checkpoint of berm: its checksum does not fit";
  EXPECT_EQ(refusal().substr(0, words.size()), words);

  change([&] { H5Fclose(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)); });
  const std::string none = "input: " + file + " is not a checkpoint of berm: it has no checksum";
  EXPECT_EQ(refusal().substr(0, none.size()), none);

  change([&] {
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(creation, seal_size);
    H5Fclose(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT));
    H5Pclose(creation);
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary) << seal_of(file);
  });
  EXPECT_EQ(refusal(),
            "input: " + file + " is not a checkpoint of berm: the HDF5 file lacks the mark \"berm checkpoint\"");

  write(world(), file, 1000, 1.0);
  change([&] {
    const hid_t h5 = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t attribute = H5Aopen(h5, "version", H5P_DEFAULT);
    const int version = checkpoint_version + 1;
    H5Awrite(attribute, H5T_NATIVE_INT, &version);
    H5Aclose(attribute);
    H5Fclose(h5);
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary) << seal_of(file);
  });
  EXPECT_EQ(refusal(), "input: " + file + " is a checkpoint in version " + std::to_string(checkpoint_version + 1) +
                           " of the format, from a later berm; this one reads version " + std::to_string(checkpoint_version));
}

TEST_F(Checkpoint, FailsAlike) {
  const std::string nowhere = file + "/absent/run.h5";
  EXPECT_EQ(error_of([&] { CheckpointFile::create(world(), nowhere); }),
            "run: cannot write " + nowhere + ": No such file or directory");
  // The same name twice.
  auto out = CheckpointFile::create(world(), file);
  out.write_number("time", 1.0);
  const std::string error = error_of([&] { out.write_number("time", 1.0); });
  const std::string words = "run: cannot write " + file + ": ";
  EXPECT_EQ(error.substr(0, words.size()), words);
}

TEST_F(Checkpoint, ReportsAFullDiskAlike) {
  // A limit on the size of files stands for the disk.
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{100000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string error = error_of([&] {
    auto out = CheckpointFile::create(world(), file);
    out.write("points/x", std::vector<double>(100000, 1.0), 2);
    out.commit();
  });
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(error, "run: cannot write " + file + ": File too large (for this file system or the limit of the shell: see ulimit -f)");
  EXPECT_TRUE(same_everywhere(std::vector<char>(error.begin(), error.end())));
  world().barrier();
  EXPECT_FALSE(fs::exists(file) || fs::exists(file + ".part"));
}

// ---- Report

/// Failures of the processes that do not print the usual report.
class FailurePrinter : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override {
    test_ = std::string(test.test_suite_name()) + "." + test.name();
  }
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.failed())
      std::fprintf(stderr, "process %d, %s: %s:%d: %s\n", rank(), test_.c_str(),
                   result.file_name() ? result.file_name() : "", result.line_number(), result.message());
  }
  std::string test_;
};

}  // namespace
}  // namespace berm

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  testing::InitGoogleTest(&argc, argv);
  auto& listeners = testing::UnitTest::GetInstance()->listeners();
  if (berm::rank() > 0) {
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new berm::FailurePrinter);
  }
  const bool good = berm::world().all(RUN_ALL_TESTS() == 0);
  MPI_Finalize();
  return good ? 0 : 1;
}
