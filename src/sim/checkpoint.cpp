#include "sim/checkpoint.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "case/differences.hpp"
#include "comm/hdf5_file.hpp"

namespace berm {
namespace {

std::string points_name(std::size_t slice) { return fmt::format("points/{}", slice); }

std::vector<double> flat(const std::vector<Vec3>& list) {
  std::vector<double> out;
  for (const Vec3& v : list) out.insert(out.end(), v.data(), v.data() + 3);
  return out;
}

std::vector<Vec3> vectors(const std::vector<double>& values) {
  std::vector<Vec3> out;
  for (std::size_t k = 0; k + 2 < values.size(); k += 3) out.emplace_back(values[k], values[k + 1], values[k + 2]);
  return out;
}

/// What is the same on every process is written by the first.
std::span<const double> from_root(const Comm& comm, const std::vector<double>& values) {
  return comm.is_root() ? std::span<const double>(values) : std::span<const double>();
}

std::vector<double> read_all(const CheckpointFile& file, const std::string& name, int columns = 1) {
  return file.read_rows<double>(name, 0, file.rows(name), columns);
}

/// The share of the rows that a process reads before they travel.
template <class T>
std::vector<T> read_share(const CheckpointFile& file, const Comm& comm, const std::string& name, int columns) {
  const std::int64_t n = file.rows(name), first = n * comm.rank() / comm.size(),
                     end = n * (comm.rank() + 1) / comm.size();
  return file.read_rows<T>(name, first, end - first, columns);
}

void save_recorder(CheckpointFile& file, const Comm& comm, const RecorderState& s) {
  file.write("recorder/rows", from_root(comm, s.rows));
  file.write("recorder/watched", from_root(comm, s.watched));
  file.write("recorder/quality", from_root(comm, s.quality));
  std::vector<double> times;
  std::string names;
  for (const auto& [time, name] : s.frames) {
    times.push_back(time);
    names += name + "\n";
  }
  file.write("recorder/frame_times", from_root(comm, times));
  file.write_text("recorder/frame_names", comm.broadcast(names));
  file.write_number("recorder/columns", s.columns);
  file.write_number("recorder/steps", s.steps);
  file.write_number("recorder/cut_steps", s.cut_steps);
  file.write_number("recorder/frame", s.frame);
  file.write_number("recorder/newton_iterations", static_cast<double>(s.newton_iterations));
  file.write_number("recorder/next_frame", s.next_frame);
  file.write_number("recorder/highest", s.highest);
  file.write_number("recorder/gap_scatter", s.gap_scatter);
  file.write_number("recorder/peak_pending", s.peak_pending ? 1.0 : 0.0);
}

RecorderState load_recorder(const CheckpointFile& file) {
  RecorderState s;
  s.rows = read_all(file, "recorder/rows");
  s.watched = read_all(file, "recorder/watched");
  s.quality = read_all(file, "recorder/quality");
  const std::vector<double> times = read_all(file, "recorder/frame_times");
  const std::string names = file.read_text("recorder/frame_names");
  std::size_t begin = 0;
  for (double time : times) {
    const std::size_t end = names.find('\n', begin);
    if (end == std::string::npos) break;
    s.frames.emplace_back(time, names.substr(begin, end - begin));
    begin = end + 1;
  }
  const auto whole = [&](const char* name) { return static_cast<int>(file.read_number(std::string("recorder/") + name)); };
  s.columns = whole("columns");
  s.steps = whole("steps");
  s.cut_steps = whole("cut_steps");
  s.frame = whole("frame");
  s.newton_iterations = static_cast<long>(file.read_number("recorder/newton_iterations"));
  s.next_frame = file.read_number("recorder/next_frame");
  s.highest = file.read_number("recorder/highest");
  s.gap_scatter = file.read_number("recorder/gap_scatter");
  s.peak_pending = file.read_number("recorder/peak_pending") != 0.0;
  return s;
}

std::string files_text(const World& world) { return "of the case:\n" + world.file_contents; }

/// The key of the first file in which two such texts differ.
std::string first_other_key(const std::string& a, const std::string& b) {
  const auto other = std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
  const std::size_t begin = a.rfind('\n', static_cast<std::size_t>(other)) + 1;
  return a.substr(begin, a.find(' ', begin) - begin);
}

/// The numbers that a checkpoint of this case must have.
void check_case(const CheckpointFile& file, const World& world, const std::string& path, const std::vector<Difference>& changed) {
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format("{}: written by another case: {} (go on with the case file that began the run)", path, what));
  };
  const auto expect = [&](const char* what, double there, double here) {
    if (there != here) refuse(fmt::format("{} {} there, {} here", what, there, here));
  };
  const Case& c = world.spec;
  for (const Difference& d : changed)
    if (d.of_the_model()) refuse(d.text());
  if (const std::string there = file.read_text("files"), here = files_text(world); there != here)
    throw InputError(fmt::format("{}: the file of {} has changed since the checkpoint was written: go on with the one that was", path, first_other_key(there, here)));
  expect("kind of model", file.read_number("space"), static_cast<int>(c.space));
  expect("bodies:", file.read_number("bodies"), static_cast<double>(c.bodies.size()));
  expect("boundaries:", file.read_number("boundaries"), static_cast<double>(c.boundaries.size()));
  const Discretisation& d = *world.discretisation;
  expect("deformable bodies:", file.read_number("slices"), static_cast<double>(d.material.slices.size()));
  for (std::size_t s = 0; s < d.material.slices.size(); ++s) {
    const Slice& slice = d.material.slices[s];
    const long here = world.comm.sum(long(slice.end - slice.begin));
    const std::string body = "points of body \"" + c.bodies[slice.body].name + "\":";
    const long there = static_cast<long>(file.rows(points_name(s)));
    if (there > here && has_domains(c.shape_functions)) continue;  // split since the start
    expect(body.c_str(), static_cast<double>(there), static_cast<double>(here));
  }
}

/// Each process takes the rows that it wrote, unless points have come to other cells since: then there is nothing to guess from,
/// as there was not in the run that went on. Collective.
void restore_guess(const CheckpointFile& file, const World& world, ImplicitStep& step) {
  const Comm& comm = world.comm;
  const double dt = file.read_number("guess_step");
  const std::int64_t pattern = file.read_rows<std::int64_t>("guess/pattern", comm.rank(), 1, 1)[0];
  if (!comm.all(dt > 0.0 && pattern == pattern_of(*world.discretisation))) return;
  const long mine = world.discretisation->halo.n_owned, first = comm.exclusive_sum(mine);
  std::vector<double> increment;
  comm.agree([&] { increment = file.read_rows<double>("guess/increment", first, mine, 3); });
  step.restore(ImplicitStep::Guess{dt, increment});
}

}  // namespace

void save_checkpoint(const std::string& path, const World& world, const ImplicitStep& step,
                     const Recorder& recorder, const StepControl& control) {
  const Discretisation& d = *world.discretisation;
  const Comm& comm = world.comm;
  CheckpointFile file = CheckpointFile::create(comm, path);
  file.write_text("case", world.spec.resolved);
  file.write_text("files", files_text(world));
  file.write_number("space", static_cast<int>(world.spec.space));
  file.write_number("bodies", static_cast<double>(world.spec.bodies.size()));
  file.write_number("boundaries", static_cast<double>(world.spec.boundaries.size()));
  file.write_number("slices", static_cast<double>(d.material.slices.size()));

  file.write_number("time", world.time);
  file.write_number("stage", static_cast<double>(world.stage));
  file.write_number("load_factor", world.load_factor);
  file.write_number("step_size", control.size());
  file.write_number("bridge", control.bridge);
  const Balance& balance = step.balance();
  file.write_number("external_work", balance.external_work);
  file.write_number("in_equilibrium", step.in_equilibrium() ? 1.0 : 0.0);
  file.write_number("damped", balance.damped);
  file.write_number("transferred", balance.transferred);
  file.write_number("kinetic", balance.kinetic);
  file.write_number("kinetic_at_start", balance.kinetic_at_start);
  file.write_number("contact_work", balance.contact_work);
  file.write_number("friction_work", balance.friction_work);
  file.write("forces/rigid", from_root(comm, flat(balance.reactions.rigid)), 3);
  file.write("forces/boundary", from_root(comm, flat(balance.reactions.boundary)), 3);
  file.write("forces/node", from_root(comm, balance.reactions.node));
  file.write("forces/pressure", from_root(comm, flat(balance.pressure_force)), 3);

  for (std::size_t s = 0; s < d.material.slices.size(); ++s)
    file.write(points_name(s), std::span<const double>(d.point_rows(static_cast<int>(s))), d.row_width(static_cast<int>(s)));
  const std::vector<double> at_nodes = d.node_state();
  file.write("nodes/id", std::span<const std::int64_t>(d.halo.ids.data(), at_nodes.size() / Discretisation::node_width));
  file.write("nodes/state", std::span<const double>(at_nodes), Discretisation::node_width);
  for (int kind = 0; kind < BoundaryConditions::n_kinds; ++kind) {
    const std::vector<double> rows = world.boundary->rows(kind);
    file.write(fmt::format("anchors/{}", kind), std::span<const double>(rows), BoundaryConditions::row_width);
  }
  const std::vector<double> between_bodies = world.boundary->grid_contact().rows();
  file.write("contact/grid", from_root(comm, between_bodies), 5);
  file.write("cuts", from_root(comm, d.cuts()));
  const std::int64_t pattern = pattern_of(d);
  file.write("guess/pattern", std::span<const std::int64_t>(&pattern, 1));
  const ImplicitStep::Guess guess = step.guess();
  file.write_number("guess_step", guess.dt);
  file.write("guess/increment", std::span<const double>(guess.increment), 3);
  save_recorder(file, comm, recorder.state());
  file.commit();
}

std::vector<Difference> load_checkpoint(const std::string& path, World& world, ImplicitStep& step, Recorder& recorder,
                                         StepControl& control) {
  Discretisation& d = *world.discretisation;
  const Comm& comm = world.comm;
  const CheckpointFile file = CheckpointFile::open(comm, path);
  const std::vector<Difference> changed = differences(file.read_text("case"), world.spec.resolved);
  check_case(file, world, path, changed);

  world.time = file.read_number("time");
  world.stage = static_cast<std::size_t>(file.read_number("stage"));
  if (world.stage >= world.spec.stages.size())
    throw InputError(fmt::format("{}: was written in stage {} of a run; this case has {}", path, world.stage + 1,
                                 world.spec.stages.size()));
  if (const Stage& stage = world.present_stage(); world.time > stage.end() * (1.0 + 1e-12))
    throw InputError(fmt::format("{}: was written at time {:.6g}, and its stage ends at {:.6g} now: let it end later ({}.duration)", path,
                                 world.time, stage.end(), stage.name.empty() ? "steps" : "stage." + stage.name));
  if (const Stage& stage = world.present_stage(); world.time < stage.begin * (1.0 - 1e-12))
    throw InputError(fmt::format("{}: was written at time {:.6g} in stage {}, which begins at {:.6g} now: the stages before it cannot last longer after the fact",
                                 path, world.time, stage.name, stage.begin));
  step.set_up_stage();
  control = StepControl(world.present_stage());
  world.load_factor = file.read_number("load_factor");
  control.restore(file.read_number("step_size"));
  control.bridge = static_cast<int>(file.read_number("bridge"));
  Balance balance;
  balance.external_work = file.read_number("external_work");
  balance.damped = file.read_number("damped");
  balance.transferred = file.read_number("transferred");
  balance.kinetic = file.read_number("kinetic");
  balance.kinetic_at_start = file.read_number("kinetic_at_start");
  balance.contact_work = file.read_number("contact_work");
  balance.friction_work = file.read_number("friction_work");
  balance.reactions.rigid = vectors(read_all(file, "forces/rigid", 3));
  balance.reactions.boundary = vectors(read_all(file, "forces/boundary", 3));
  balance.reactions.node = read_all(file, "forces/node");
  balance.pressure_force = vectors(read_all(file, "forces/pressure", 3));
  // A state at the very beginning of a stage was reached in the one before.
  const bool begins = world.stage > 0 && world.time <= world.present_stage().begin * (1.0 + 1e-12);
  step.restore(balance, file.read_number("in_equilibrium") != 0.0, world.spec.stages[world.stage - (begins ? 1 : 0)].name);

  std::vector<std::vector<double>> rows;
  for (std::size_t s = 0; s < d.material.slices.size(); ++s)
    rows.push_back(read_share<double>(file, comm, points_name(s), d.row_width(static_cast<int>(s))));
  const auto with_name = [&](const auto& restore) {
    try {
      restore();
    } catch (const InputError& error) {
      throw InputError(path + ": " + error.what());
    }
  };
  with_name([&] { d.restore_points(rows); });
  // On as many processes as it was written by, places belong to the same one as then.
  const bool as_many = file.rows("guess/pattern") == comm.size();
  if (as_many && file.rows("cuts") > 0) d.restore_cuts(read_all(file, "cuts"));
  const auto ids = read_share<std::int64_t>(file, comm, "nodes/id", 1);
  const auto states = read_share<double>(file, comm, "nodes/state", Discretisation::node_width);
  with_name([&] { d.restore_nodes(ids, states); });
  for (int kind = 0; kind < BoundaryConditions::n_kinds; ++kind)
    world.boundary->restore(kind, read_all(file, fmt::format("anchors/{}", kind), BoundaryConditions::row_width));
  world.boundary->grid_contact().restore(read_all(file, "contact/grid", 5));
  world.boundary->restore_rigid(world.time);
  world.begin_step();
  if (as_many) restore_guess(file, world, step);
  recorder.resume(load_recorder(file));
  return changed;
}

}  // namespace berm
