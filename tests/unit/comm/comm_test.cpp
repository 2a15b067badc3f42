#include "comm/comm.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "base/error.hpp"
#include "base/tensor.hpp"
#include "comm/mpi.hpp"

namespace berm {
namespace {

TEST(CommAlone, IsRootOfOne) {
  for (const Comm& comm : {Comm(), Comm::world()}) {
    EXPECT_EQ(comm.rank(), 0);
    EXPECT_EQ(comm.size(), 1);
    EXPECT_TRUE(comm.is_root());
    EXPECT_EQ(comm.handle(), nullptr);
  }
}

TEST(CommAlone, SumsToItself) {
  const Comm comm;
  EXPECT_EQ(comm.sum(2.5), 2.5);
  EXPECT_EQ(comm.max(2.5), 2.5);
  EXPECT_EQ(comm.min(2.5), 2.5);
  EXPECT_EQ(comm.sum(3L), 3L);
  EXPECT_EQ(comm.max(3L), 3L);
  EXPECT_EQ(comm.exclusive_sum(3), 0);
  EXPECT_TRUE(comm.any(true));
  EXPECT_FALSE(comm.all(false));
  std::vector<double> values{1.0, 2.0};
  comm.sum(std::span<double>(values));
  EXPECT_EQ(values, (std::vector<double>{1.0, 2.0}));
  comm.barrier();
}

TEST(CommAlone, TalksToItself) {
  const Comm comm;
  EXPECT_EQ(comm.broadcast(7), 7);
  EXPECT_EQ(comm.broadcast(std::string("words")), "words");
  const std::vector<int> list{1, 2, 3}, nothing;
  EXPECT_EQ(comm.broadcast(list), list);
  std::vector<std::size_t> counts;
  EXPECT_EQ(comm.all_gather(list, &counts), list);
  EXPECT_EQ(counts, std::vector<std::size_t>{3});
  EXPECT_EQ(comm.all_gather(nothing), nothing);
  EXPECT_EQ(comm.gather(list), list);
  EXPECT_EQ(comm.gather(nothing, 0, &counts), nothing);
  EXPECT_EQ(counts, std::vector<std::size_t>{0});
  EXPECT_EQ(comm.exchange<int>({list})[0], list);
  EXPECT_EQ(comm.exchange<int>({nothing})[0], nothing);
  EXPECT_THROW(comm.exchange<int>({}), std::logic_error);
}

TEST(CommAlone, TakesTensors) {
  const std::vector<Vec3> x{Vec3(1, 2, 3), Vec3(4, 5, 6)};
  EXPECT_EQ(Comm().exchange<Vec3>({x})[0], x);
  static_assert(Plain<Voigt> && Plain<Mat3> && Plain<int>);
  static_assert(!Plain<std::string> && !Plain<Eigen::VectorXd> && !Plain<int*> && !Plain<bool>);
}

TEST(CommAlone, AgreesWithItself) {
  const Comm comm;
  int calls = 0;
  comm.agree([&] { ++calls; });
  EXPECT_EQ(calls, 1);
  EXPECT_THROW(comm.agree([] { throw InputError("input"); }), InputError);
  EXPECT_THROW(comm.agree([] { throw RunError("run"); }), RunError);
  EXPECT_THROW(comm.agree([] { throw std::out_of_range("other"); }), std::out_of_range);
}

TEST(CommAlone, EndsWithTheCode) { EXPECT_EXIT(Comm().abort(3), testing::ExitedWithCode(3), ""); }

TEST(CommAlone, StartsNoMpi) {
  int running = 1;
  MPI_Initialized(&running);
  EXPECT_FALSE(running);
}

}  // namespace
}  // namespace berm
