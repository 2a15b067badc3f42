#pragma once
/// Looks after every step for what the equations do not notice: material inside rigid bodies, bodies inside each other,
/// reactions that jump, soil that swells without end.

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "mesh/region.hpp"
#include "sim/implicit_step.hpp"

namespace berm {

/// What it has seen so far: plain numbers that outlive the process.
struct Watched {
  double penetration = 0.0;  ///< deepest place of material inside a rigid body [m]
  double swelling = 1.0;     ///< largest volume of a body of soil over that at the start [-]
  double jump = 0.0;         ///< largest change of a reaction in a step of a smooth motion over the largest reaction [-]
  double jumps = 0.0;        ///< steps with one above a tenth
  double columns = 0.0;      ///< of cells side by side over which a crack is smeared in the mean [-]
  std::vector<double> row() const { return {penetration, swelling, jump, jumps, columns}; }
  void restore(const std::vector<double>& row);
};

class Watch {
public:
  using Say = std::function<void(const std::string&)>;
  /// `warn` gets each warning once.
  Watch(const World& world, Say warn);

  /// After a restart.
  void resume(const Watched& before, const Reactions& now);
  /// After every accepted step. Throws RunError if material is more than a cell deep inside a rigid body. Collective.
  void look(const ImplicitStep& step, int n_steps);
  /// At the end of a run. Collective.
  void look_last();
  bool has_told(const char* what) const { return told_.contains(what); }
  /// The part that looks at reactions, those at that time. Not collective.
  void look_for_jumps(const Reactions& now, double time);

  Watched seen;

private:
  /// A rigid body that material must not enter. In its own frame, boxes of a cell's size: unknown, far outside, near.
  struct Obstacle {
    int rigid, body;
    Stages stages;
    Region region;
    Vec3 low;
    double width;
    std::array<int, 3> n;
    std::vector<char> box;
    double depth(const Vec3& x);  ///< of a place inside, else 0
  };
  void look_for_penetration();
  void look_now_and_then();
  void look_for_overlap();
  void look_for_meetings();
  void look_for_lost_pressure();
  void look_for_swelling();
  void look_for_large_motion();
  void look_for_smeared_cracks();
  void look_for_lag();
  bool displacements_were_reset() const;
  void look_for_torn_ties();
  void look_for_idle_bodies() const;
  void tell_once(const char* what, const std::string& text);
  Vec3 place_now(const std::vector<Vec3>& X, const std::vector<Vec3>& x, const std::vector<Vec3>& u, int p) const;

  const World& world_;
  Say warn_;
  std::vector<Obstacle> obstacles_;
  std::set<std::string> told_;  ///< what has been warned of
  // of the last steps
  std::vector<Vec3> reaction_, change_, rate_;  ///< by case body
  std::vector<double> largest_;                 ///< reaction so far [N]
  double time_ = 0.0, span_ = 0.0;
  std::string worst_jump_;
};

}  // namespace berm
