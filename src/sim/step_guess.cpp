/// What a step knows of the one before it, in a run that goes on as in one that goes on from a checkpoint.
#include "base/hash.hpp"
#include "sim/implicit_step.hpp"

namespace berm {

std::int64_t pattern_of(const Discretisation& d) {
  Hash hash;
  hash.add(d.halo.n_owned);
  for (const std::int64_t id : d.halo.ids) hash.add(static_cast<std::uint64_t>(id));
  for (int block = 0; block < d.blocks.size(); ++block) {
    hash.add(~std::uint64_t(block));
    for (const int node : d.blocks[block]) hash.add(static_cast<std::uint64_t>(node));
  }
  return static_cast<std::int64_t>(hash.value());
}

ImplicitStep::Guess ImplicitStep::guess() const {
  Guess g{world_.comm.all(last_dt_ > 0.0) ? last_dt_ : 0.0, {}};
  if (g.dt == 0.0) return g;
  for (int node = 0; node < world_.discretisation->halo.n_owned; ++node)
    g.increment.insert(g.increment.end(), last_du_[node].data(), last_du_[node].data() + 3);
  return g;
}

/// The last step is of use for a guess if this one has its nodes; they may have been numbered anew and be the same. Collective.
void ImplicitStep::keep_guess() {
  const Discretisation& d = *world_.discretisation;
  if (guess_connectivity_ == d.connectivity) return;
  const std::int64_t pattern = pattern_of(d);
  if (!world_.comm.all(pattern == guess_pattern_)) last_dt_ = 0.0;
  guess_connectivity_ = d.connectivity;
  guess_pattern_ = pattern;
}

void ImplicitStep::restore(const Guess& guess) {
  last_du_ = no_motion();
  for (std::size_t k = 0; k < guess.increment.size(); ++k) last_du_[k / 3][k % 3] = guess.increment[k];
  last_dt_ = guess.dt;
  guess_connectivity_ = world_.discretisation->connectivity;
  guess_pattern_ = pattern_of(*world_.discretisation);
}

void ImplicitStep::renew_solver() { connectivity_ = -1; }

}  // namespace berm
