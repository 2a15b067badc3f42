/// Expressions of a case must have a value whenever the run asks for it, and change no faster than its steps see.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/reach.hpp"
#include "bc/case_lookup.hpp"
#include "case/doubts.hpp"

namespace berm {
namespace {

/// How far a function goes beyond its values at both ends of a step, at most, and its range over the stage.
struct Unseen {
  double beyond = 0.0, time = 0.0, low = infinity, high = -infinity;
  double share() const { return high > low ? beyond / (high - low) : 0.0; }
  double size() const { return std::max(std::abs(low), std::abs(high)); }
};

Unseen unseen_between(const TimeFunction& f, const Stage& stage, double count) {
  constexpr double most_looked_at = 5000.0;
  const double step = stage.steps.duration / count, looks = std::min(count, most_looked_at);
  Unseen found;
  for (double k = 0.0; k < looks; k += 1.0) {
    const double t = stage.begin + step * std::floor(k * count / looks), from = f.at(t), to = f.at(t + step);
    found.low = std::min({found.low, from, to}), found.high = std::max({found.high, from, to});
    for (const double part : {0.21, 0.5, 0.83}) {
      const double value = f.at(t + part * step), beyond = std::max(value - std::max(from, to), std::min(from, to) - value);
      found.low = std::min(found.low, value), found.high = std::max(found.high, value);
      if (beyond > found.beyond) found.beyond = beyond, found.time = t + part * step;
    }
  }
  return found;
}

/// Looks at every stage in which something acts. What depends on the place is looked at in the run, where the places are known.
class Functions {
public:
  Functions(const Case& c, Problems& problems) : c_(c), problems_(problems) {}

  void look(const TimeFunction& f, const Stages& stages, const Place& place) const {
    if (f.is_number() || f.depends_on_place()) return;
    try {
      largest_of(f, stages);
    } catch (const RunError& error) {
      return problems_.error(place, error.what());
    }
    tell_unseen(f, stages, place);
  }
  void look(const VectorFunction& f, const Stages& stages, const Place& place) const {
    for (const TimeFunction& component : f.component) look(component, stages, place);
  }

  /// The same, and nothing may be moved out of reach. `what`: boundary.top
  void look_at_motion(const TimeFunction& f, const Stages& stages, const Place& place, const std::string& what) const {
    look(f, stages, place);
    if (f.depends_on_place()) return;
    try {
      if (const double far = largest_of(f, stages); far > farthest_place)
        problems_.error(place, fmt::format("[{}] moves by {:.3g} m: places must lie within {:g} m of the origin", what, far, farthest_place));
    } catch (const RunError&) {
      return;  // told by look()
    }
  }

  /// Steps take the changes of a motion: what it is already where it begins to act in a later stage never comes. Not told where it goes on with what another
  /// boundary has moved until then.
  template <class Component>
  void look_at_beginnings(const NodeBoundary& b, const Component& component, const Place& place) const {
    const TimeFunction* f = component(b);
    if (!f || f->is_number() || f->depends_on_place()) return;
    try {
      for (std::size_t k = 1; k < c_.stages.size(); ++k) {
        const std::string &before = c_.stages[k - 1].name, &now = c_.stages[k].name;
        if (!acts_in(b.stages, now) || acts_in(b.stages, before)) continue;
        const double t = c_.stages[k].begin, start = f->at(t);
        const bool goes_on = std::any_of(c_.boundaries.begin(), c_.boundaries.end(), [&](const NodeBoundary& other) {
          const TimeFunction* g = component(other);
          return g && acts_in(other.stages, before) && !g->depends_on_place() && std::abs(g->at(t) - start) <= 1e-9 * std::abs(start);
        });
        if (std::abs(start) > no_jump && !goes_on)
          problems_.warn(place, fmt::format("\"{0}\" is {1:.4g} m at t = {2:.6g} s, when [stage.{3}] begins in which it first acts, and only what it changes by from there on moves "
                                            "the body: take \"{0} - ({1:.12g})\"",
                                            f->text(), start, t, now));
      }
    } catch (const RunError&) {
      return;  // told by look()
    }
  }

private:
  /// Its size, in the stages in which it acts.
  double largest_of(const TimeFunction& f, const Stages& stages) const {
    constexpr int samples = 20;
    double size = 0.0;
    for (const Stage& stage : c_.stages)
      for (int k = 0; k <= samples && acts_in(stages, stage.name); ++k) size = std::max(size, std::abs(f.at(stage.begin + k * stage.steps.duration / samples)));
    return size;
  }

  void tell_unseen(const TimeFunction& f, const Stages& stages, const Place& place) const {
    constexpr double told = 0.2, seen = 0.05, little = 1e-3, most = 1e7;  // of the range in a stage; of the largest value in all
    try {
      std::vector<std::pair<const Stage*, Unseen>> found;
      double size = 0.0;
      for (const Stage& stage : c_.stages) {
        if (!acts_in(stages, stage.name)) continue;
        found.emplace_back(&stage, unseen_between(f, stage, stage.steps.count));
        size = std::max(size, found.back().second.size());
      }
      for (const auto& [stage, unseen] : found) {
        if (unseen.share() <= told || unseen.beyond <= little * size) continue;
        double enough = 2.0 * stage->steps.count;
        while (enough < most && unseen_between(f, *stage, enough).share() > seen) enough *= 2.0;
        const std::string remedy = enough < most ? fmt::format("take {} count = {:.0f} or more", stage->name.empty() ? "[steps]" : "[stage." + stage->name + "]", enough)
                                                 : "no number of steps does";
        problems_.warn(place, fmt::format("\"{}\" goes from {:.4g} to {:.4g}, and the steps of {:.3g} s do not see {:.0f} % of it, as at t = {:.6g} s: {}", f.text(), unseen.low,
                                          unseen.high, stage->steps.duration / stage->steps.count, 100.0 * unseen.share(), unseen.time, remedy));
      }
    } catch (const RunError&) {
      return;  // between the steps it needs no value
    }
  }

  const Case& c_;
  Problems& problems_;
};

/// The gauge finds the factor on a load as it is at the end of the run: what it is before then would be overheard.
void refuse_change_under_gauge(const Case& c, const Pressure& p, const Place& place, Problems& problems) {
  constexpr int samples = 20;
  const TimeFunction& f = p.value;
  if (f.is_number() || f.depends_on_place()) return;
  try {
    const double end = f.at(c.duration());
    for (int k = 0; k <= samples; ++k)
      if (std::abs(f.at(k * c.duration() / samples) - end) > 1e-9 * std::abs(end))
        return problems.error(place, fmt::format("\"{}\" changes with the time, and [control] kind = \"gauge\" scales what it is at the end, {:.4g} Pa: write a number", f.text(), end));
  } catch (const RunError&) {
    return;  // told by look()
  }
}

}  // namespace

void check_functions(const Case& c, const Node& root, Problems& problems) {
  const Functions functions(c, problems);
  functions.look(c.gravity, {}, place_in(root, "model", "", "gravity"));
  for (const Body& b : c.bodies) {
    for (const TimeFunction& u : b.displacement.component) functions.look_at_motion(u, {}, place_in(root, "body", b.name, "displacement"), "body." + b.name);
    functions.look(b.acceleration, {}, place_in(root, "body", b.name, "acceleration"));
  }
  for (const NodeBoundary& b : c.boundaries) {
    for (int i = 0; i < 3; ++i) {
      const Place place = place_in(root, "boundary", b.name, std::string("u") + "xyz"[i]);
      if (b.u[i]) functions.look_at_motion(*b.u[i], b.stages, place, "boundary." + b.name);
      functions.look_at_beginnings(b, [i](const NodeBoundary& n) { return n.u[i] ? &*n.u[i] : nullptr; }, place);
    }
    const Place place = place_in(root, "boundary", b.name, "un");
    functions.look_at_motion(b.un, b.stages, place, "boundary." + b.name);
    functions.look_at_beginnings(b, [](const NodeBoundary& n) { return &n.un; }, place);
  }
  if (c.control.kind == Control::Kind::gauge)
    for (const Pressure& p : c.pressures) refuse_change_under_gauge(c, p, place_in(root, "pressure", p.name, "value"), problems);
  for (const Pressure& p : c.pressures) {
    functions.look(p.value, p.stages, place_in(root, "pressure", p.name, "value"));
    if (p.traction) functions.look(*p.traction, p.stages, place_in(root, "pressure", p.name, "traction"));
  }
}

}  // namespace berm
