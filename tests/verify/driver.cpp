#include "driver.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace berm::verify {

std::string scratch_file(const std::string& name) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("berm_verify_{}", getpid());
  std::filesystem::create_directories(folder);
  return (folder / name).string();
}

Case case_of(const std::string& text, const std::vector<std::string>& overrides) {
  std::vector<std::string> all;
  const auto plain = [&](const std::string& table, const std::string& key, const std::string& value) {
    const bool has_table = text.find("[" + table + "]") != std::string::npos || text.find(table + " =") != std::string::npos;
    if (text.find(key) == std::string::npos && (has_table || table == "model")) all.push_back(table + "." + key + "=\"" + value + "\"");
  };
  plain("model", "formulation", "updated_lagrangian");
  plain("model", "volumetric", "standard");
  plain("grid", "shape_functions", "linear");
  all.insert(all.end(), overrides.begin(), overrides.end());
  return case_by_default(text, all);
}

Case case_by_default(const std::string& text, const std::vector<std::string>& overrides) {
  const std::string path = scratch_file("case.toml");
  std::ofstream(path) << text;
  return read_case(path, overrides);
}

StepResult Model::advance(double dt) {
  const StepResult result = step.attempt(dt, world->present_stage().solver.integration);
  EXPECT_TRUE(result.converged) << "at time " << world->time << ": " << result.reason;
  if (result.converged) step.accept();
  return result;
}

bool Model::run(const std::function<void(const StepResult&)>& after) {
  for (;; ++world->stage, step.begin_stage()) {
    if (!run_stage(after)) return false;
    if (world->stage + 1 == world->spec.stages.size()) return true;
  }
}

bool Model::run_stage(const std::function<void(const StepResult&)>& after) {
  StepControl control(world->present_stage());
  const Integration integration = world->present_stage().solver.integration;
  while (!control.finished(world->time)) {
    const StepResult result = step.attempt(control.next(world->time), integration);
    if (!result.converged) {
      if (!control.can_cut()) return false;
      control.cut();
      continue;
    }
    if (integration == Integration::impl_ex && control.reject_impl_ex(result.extrapolation_error)) {
      control.cut_impl_ex(result.extrapolation_error);
      continue;
    }
    if (integration == Integration::implicit && control.reject_time_error(result.time_error)) {
      control.cut();
      continue;
    }
    step.accept();
    if (after) after(result);
    if (integration == Integration::implicit)
      control.after_implicit(result.iterations, result.time_error);
    else
      control.after_impl_ex(result.extrapolation_error);
  }
  return true;
}

namespace {

/// Order p of r_(k+1) = c r_k^p from three residuals.
double order(double a, double b, double c) { return std::log(c / b) / std::log(b / a); }

}  // namespace

std::vector<double> newton_orders(Model& model, int steps) {
  constexpr double rounding = 1e-11, quadratic_range = 5e-2;
  std::vector<double> found;
  for (int k = 0; k < steps; ++k) {
    const double before = model.material().dissipated_energy();
    const StepResult result = model.advance(1.0 / steps);
    if (!(model.material().dissipated_energy() > before)) continue;
    const std::vector<double>& r = result.residuals;
    for (std::size_t i = r.size(); i-- > 2;)
      if (r[i] > rounding && r[i - 2] < quadratic_range) {
        found.push_back(order(r[i - 2], r[i - 1], r[i]));
        fmt::print("  step {}: {:.2e} {:.2e} {:.2e}, order {:.2f}\n", k + 1, r[i - 2], r[i - 1], r[i], found.back());
        break;
      }
  }
  return found;
}

FieldErrors field_errors(const Model& model, const std::function<Vec3(const Vec3& X)>& displacement,
                         const std::function<Voigt(const Vec3& X)>& stress) {
  const std::vector<Vec3> X = model.world->discretisation->point_origins(),
                          u = model.world->discretisation->point_displacements();
  const MaterialState& m = model.material();
  double error_u = 0.0, size_u = 0.0, error_s = 0.0, size_s = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const Vec3 exact_u = displacement(X[p]);
    const Voigt exact_s = stress(X[p]);
    error_u += m.volume[p] * (u[p] - exact_u).squaredNorm();
    size_u += m.volume[p] * exact_u.squaredNorm();
    error_s += m.volume[p] * (m.stress[p] - exact_s).squaredNorm();
    size_s += m.volume[p] * exact_s.squaredNorm();
  }
  return {std::sqrt(error_u / size_u), std::sqrt(error_s / size_s)};
}

void record(const Row& row) {
  ::testing::Test::RecordProperty(fmt::format("{}: {}", row.group, row.quantity), fmt::format("{:.6g}", row.reached));
  fmt::print("  {} | {} | {:.6g} | {} | {}\n", row.group, row.quantity, row.reached, row.reference, row.tolerance);
  const char* path = std::getenv("BERM_VERIFICATION_RECORD");
  if (!path) return;
  std::ofstream(path, std::ios::app) << fmt::format("{}\t{}\t{:.6g}\t{}\t{}\t{}\n", row.group, row.quantity,
                                                    row.reached, row.reference, row.tolerance, row.source);
}

}  // namespace berm::verify

namespace {
/// Removes the scratch files of this process.
struct Cleaner : ::testing::Environment {
  void TearDown() override {
    std::filesystem::remove_all(std::filesystem::path(berm::verify::scratch_file("x")).parent_path());
  }
};
}  // namespace

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ::testing::AddGlobalTestEnvironment(new Cleaner);
  berm::start_petsc();
  return RUN_ALL_TESTS();
}
