#include "comm/halo.hpp"

#include <gtest/gtest.h>

namespace berm {
namespace {

TEST(HaloAlone, OwnsWhatItTouches) {
  const std::vector<std::int64_t> touched{3, 5, 1000000000000};
  const Halo halo = build_halo(Comm(), touched, [](std::int64_t) { return 0; });
  EXPECT_EQ(halo.ids, touched);
  EXPECT_EQ(halo.n_owned, 3);
  EXPECT_EQ(halo.n_global, 3);
  EXPECT_EQ(halo.first, 0);
  EXPECT_EQ(halo.global, (std::vector<std::int64_t>{0, 1, 2}));
  EXPECT_EQ(halo.find(5), 1);
  EXPECT_EQ(halo.find(4), -1);
  EXPECT_EQ(halo.find(1000000000001), -1);

  std::vector<double> x{1, 2, 3, 4, 5, 6};
  const std::vector<double> before = x;
  halo.add_to_owners(x.data(), 2);
  halo.copy_to_ghosts(x.data(), 2);
  EXPECT_EQ(x, before);
}

TEST(HaloAlone, MayBeEmpty) {
  for (const Halo& halo : {Halo(), build_halo(Comm(), {}, [](std::int64_t) { return 0; })}) {
    EXPECT_EQ(halo.size(), 0);
    EXPECT_EQ(halo.find(1), -1);
    halo.add_to_owners(static_cast<double*>(nullptr), 3);
    halo.copy_to_ghosts(static_cast<char*>(nullptr), 1);
  }
}

}  // namespace
}  // namespace berm
