/// Expressions of a case must have a value whenever the run asks for it.
#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "case/doubts.hpp"

namespace berm {
namespace {

/// Looks at every stage in which something acts. What depends on the place is looked at in the run, where the places are known.
class Functions {
public:
  Functions(const Case& c, Problems& problems) : c_(c), problems_(problems) {}

  void look(const TimeFunction& f, const Stages& stages, const Place& place) const {
    constexpr int samples = 20;
    if (f.is_number() || f.depends_on_place()) return;
    try {
      for (const Stage& stage : c_.stages)
        if (acts_in(stages, stage.name))
          for (int k = 0; k <= samples; ++k) f.at(stage.begin + k * stage.steps.duration / samples);
    } catch (const RunError& error) {
      problems_.error(place, error.what());
    }
  }
  void look(const VectorFunction& f, const Stages& stages, const Place& place) const {
    for (const TimeFunction& component : f.component) look(component, stages, place);
  }

private:
  const Case& c_;
  Problems& problems_;
};

}  // namespace

void check_functions(const Case& c, const Node& root, Problems& problems) {
  const Functions functions(c, problems);
  functions.look(c.gravity, {}, place_in(root, "model", "", "gravity"));
  for (const Body& b : c.bodies) {
    functions.look(b.displacement, {}, place_in(root, "body", b.name, "displacement"));
    functions.look(b.acceleration, {}, place_in(root, "body", b.name, "acceleration"));
  }
  for (const NodeBoundary& b : c.boundaries) {
    for (int i = 0; i < 3; ++i)
      if (b.u[i]) functions.look(*b.u[i], b.stages, place_in(root, "boundary", b.name, std::string("u") + "xyz"[i]));
    functions.look(b.un, b.stages, place_in(root, "boundary", b.name, "un"));
  }
  for (const Pressure& p : c.pressures) {
    functions.look(p.value, p.stages, place_in(root, "pressure", p.name, "value"));
    if (p.traction) functions.look(*p.traction, p.stages, place_in(root, "pressure", p.name, "traction"));
  }
}

}  // namespace berm
