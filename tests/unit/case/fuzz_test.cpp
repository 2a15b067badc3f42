/// Damaged case files: an error message or a case, never a crash.

#include <random>

#include "case_files.hpp"

namespace berm {
namespace {

constexpr int n_mutants = 2000;

/// Changes, drops, doubles or swaps a few bytes or a whole line.
std::string mutant(std::string text, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  static const std::string telling = "[]{}=.,\"'#\n\\ -+0129eE_ix\x00\x7f\xc3\xff";
  const std::size_t n_changes = 1 + below(4);
  for (std::size_t k = 0; k < n_changes && text.size() > 1; ++k) {
    const std::size_t at = below(text.size());
    const std::size_t length = std::min(1 + below(12), text.size() - at);
    switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text[at] = telling[below(telling.size())];
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(below(text.size()), length));
        break;
      case 4:
        std::swap(text[at], text[below(text.size())]);
        break;
      default: {
        const std::size_t end = text.find('\n', at);
        text.erase(at, end == std::string::npos ? end : end - at + 1);
      }
    }
  }
  return text;
}

class CaseFuzz : public CaseFiles {
protected:
  /// Counts the mutants that were still a case.
  int survivors(const std::string& seed_text, unsigned seed) {
    write("mesh/frame.msh", "");
    write("mesh/rock.stl", tetrahedron_stl);
    write("curve.csv", "nominal_strain [-],nominal_stress [Pa]\n0,0\n");
    std::mt19937 random(seed);
    int n = 0;
    for (int i = 0; i < n_mutants; ++i) {
      try {
        const Case c = read(mutant(seed_text, random));
        EXPECT_EQ(read_case(write("copy.toml", c.resolved)).resolved, c.resolved);
        ++n;
      } catch (const InputError& error) {
        EXPECT_STRNE(error.what(), "");
      }
    }
    return n;
  }
};

TEST_F(CaseFuzz, mutantsOfAFullCase) {
  const int n = survivors(full_case, 1);
  EXPECT_GT(n, 0);
  EXPECT_LT(n, n_mutants);
}

TEST_F(CaseFuzz, mutantsOfASmallCase) {
  const int n = survivors(small_case, 2);
  EXPECT_GT(n, 0);
  EXPECT_LT(n, n_mutants);
}

TEST_F(CaseFuzz, mutantsOfAFullSolidCase) {
  const int n = survivors(full_solid_case, 4);
  EXPECT_GT(n, 0);
  EXPECT_LT(n, n_mutants);
}

TEST_F(CaseFuzz, mutantsOfAnAxisymmetricCase) {
  const int n = survivors(axisymmetric_case, 5);
  EXPECT_GT(n, 0);
  EXPECT_LT(n, n_mutants);
}

TEST_F(CaseFuzz, mutantsOfOverrides) {
  std::mt19937 random(3);
  const std::string path = write("case.toml", small_case);
  for (int i = 0; i < n_mutants; ++i) {
    try {
      read_case(path, {mutant("solver.petsc=\"-a\"", random), mutant("grid.cells=[3, 4]", random)});
    } catch (const InputError& error) {
      EXPECT_STRNE(error.what(), "");
    }
  }
}

}  // namespace
}  // namespace berm
