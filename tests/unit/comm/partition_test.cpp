#include "comm/partition.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace berm {
namespace {

TEST(PartitionAlone, OwnsEverything) {
  Partition p;
  EXPECT_EQ(p.owner(Vec3(1, 2, 3)), 0);
  const std::vector<Vec3> places{Vec3(0, 0, 0), Vec3(1, 0, 0)};
  const std::vector<double> weights{1.0, 2.0};
  EXPECT_EQ(p.balance(Comm(), 3, places, weights), (std::vector<int>{0, 0}));
  EXPECT_EQ(p.owner(Vec3::Constant(std::numeric_limits<double>::infinity())), 0);
  EXPECT_EQ(p.balance(Comm(), 2, {}, {}), std::vector<int>{});
  EXPECT_THROW(p.balance(Comm(), 2, places, {}), std::logic_error);
  EXPECT_EQ(Partition::imbalance(Comm(), 5.0), 1.0);
  EXPECT_EQ(Partition::imbalance(Comm(), 0.0), 1.0);
}

TEST(PartitionAlone, ReadsItsNumbers) {
  // x <= 1: process 0; else y <= 2: process 1, else 2
  const std::vector<double> numbers{0, 0, 1.0, ~0, 1, 1, 2.0, ~1, ~2};
  const Partition p = Partition::from_numbers(numbers);
  EXPECT_EQ(p.owner(Vec3(1, 9, 0)), 0);
  EXPECT_EQ(p.owner(Vec3(1.1, 2, 0)), 1);
  EXPECT_EQ(p.owner(Vec3(1.1, 2.1, 0)), 2);
  EXPECT_EQ(p.numbers(), numbers);
  EXPECT_EQ(Partition().numbers(), std::vector<double>{~0});
  EXPECT_THROW(Partition::from_numbers({}), std::logic_error);
}

}  // namespace
}  // namespace berm
