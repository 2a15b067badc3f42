#pragma once
/// The whole state of a run in one HDF5 file, for any number of processes to go on from.

#include <string>

#include "case/differences.hpp"
#include "sim/implicit_step.hpp"
#include "sim/recorder.hpp"
#include "sim/step_control.hpp"

namespace berm {

/// Writes the state at t_n; the file appears as a whole or not at all. Collective. Throws RunError.
void save_checkpoint(const std::string& path, const World& world, const ImplicitStep& step,
                     const Recorder& recorder, const StepControl& control);

/// Puts the state of the file into a world that has just been built from the same case, or from one that differs in loads,
/// numbers of materials, steps, solver or output; returns what differs. Collective. Throws InputError if
/// the file is no checkpoint, has changed since it was written, is of another version, or of another model.
std::vector<Difference> load_checkpoint(const std::string& path, World& world, ImplicitStep& step, Recorder& recorder,
                                         StepControl& control);

}  // namespace berm
