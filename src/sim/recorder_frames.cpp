/// VTK frames: the state at the points and on the cells, and when it is written.
#include <fmt/format.h>

#include <algorithm>

#include "fem/fem.hpp"
#include "sim/recorder.hpp"
#include "sim/recovery.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

unsigned char vtk_type(CellKind kind) {
  constexpr unsigned char types[] = {vtk_triangle, vtk_quad,       vtk_quadratic_triangle, vtk_quadratic_quad,
                                     vtk_tetra,    vtk_hexahedron, vtk_quadratic_tetra,    vtk_quadratic_hexahedron};
  return types[static_cast<int>(kind)];
}

}  // namespace

/// Keeps the state at the peak load (within 1 %) and writes it once the load has fallen by 3 %.
void Recorder::follow_peak() {
  if (row_load_ > 1.01 * highest_) {
    highest_ = row_load_;
    peak_ = take_frame();
  } else if (peak_ && row_load_ < 0.97 * highest_) {
    write_frame(*peak_);
    peak_.reset();
  }
}

void Recorder::before_checkpoint() {
  if (!peak_ || peak_->time == world_.time) return;
  write_frame(*peak_);
  peak_.reset();
}

Recorder::Frame Recorder::take_frame() const { return {world_.time, points_data(), mesh_data()}; }

/// One file, or one a process and the list of them; returns the name of what a .pvd should name.
std::string Recorder::write_pieces(const std::string& kind, const VtuData& data) const {
  const Comm& comm = world_.comm;
  const std::string name = fmt::format("{}_{:04d}", kind, frame_);
  if (comm.size() == 1) {
    write_vtu((folder_ / (name + ".vtu")).string(), data);
    return name + ".vtu";
  }
  comm.agree([&] {
    write_vtu((folder_ / fmt::format("{}_{}.vtu", name, comm.rank())).string(), data);
    if (!comm.is_root()) return;
    std::vector<std::string> pieces;
    for (int r = 0; r < comm.size(); ++r) pieces.push_back(fmt::format("{}_{}.vtu", name, r));
    write_pvtu((folder_ / (name + ".pvtu")).string(), data, pieces);
  });
  return name + ".pvtu";
}

void Recorder::write_frame(const Frame& frame) {
  const std::string points = write_pieces("points", frame.points), mesh = write_pieces("mesh", frame.mesh);
  world_.comm.agree([&] {
    if (!world_.comm.is_root()) return;
    points_pvd_.add(frame.time, points);
    mesh_pvd_.add(frame.time, mesh);
  });
  ++frame_;
  if (frame.time < world_.time) return;
  last_frame_step_ = steps_;
  const double end = world_.spec.duration(), spacing = end / std::max(1, world_.spec.output.frames);
  while (next_frame_ <= world_.time + 1e-12 * end) next_frame_ += spacing;
}

VtuData Recorder::points_data() const {
  const Discretisation& d = *world_.discretisation;
  const MaterialState& m = d.material;
  const std::vector<Vec3> u = d.point_displacements();
  const int n = m.size();
  std::vector<Vec3> places = d.point_positions();
  for (Vec3& x : places) x += world_.spec.origin;
  VtuData data = vertices(std::move(places));
  std::vector<double> displacement, stress, strain, current_volume;
  std::vector<int> body(n, 0);
  for (const Slice& slice : m.slices) std::fill(body.begin() + slice.begin, body.begin() + slice.end, slice.body);
  for (int p = 0; p < n; ++p) {
    displacement.insert(displacement.end(), u[p].data(), u[p].data() + 3);
    const bool finite = world_.spec.kinematics == Kinematics::finite;
    current_volume.push_back(finite ? m.volume[p] * m.F[p].determinant() * std::exp(m.strain_zz[p]) : m.volume[p]);
    for (int c = 0; c < 6; ++c) {
      stress.push_back(m.stress[p][c]);
      strain.push_back(c < 3 ? m.strain[p][c] : 0.5 * m.strain[p][c]);
    }
  }
  data.point_fields = {{"displacement", 3, displacement},
                       {"stress", 6, stress},
                       {"strain", 6, strain},
                       {"damage", 1, m.damage},
                       {"volume", 1, m.volume},
                       {"current_volume", 1, current_volume},
                       {"body", 1, body},
                       {"crack_opening", 1, m.crack_opening()},
                       {"released_energy_fraction", 1, m.released_energy_fraction()},
                       {"id", 1, d.point_ids()}};
  if (world_.spec.is_dynamic()) {
    std::vector<double> velocity;
    for (const Vec3& v : d.point_velocities()) velocity.insert(velocity.end(), v.data(), v.data() + 3);
    data.point_fields.push_back({"velocity", 3, velocity});
  }
  if (m.has_plasticity()) data.point_fields.push_back({"plastic_strain", 1, m.plastic_strain});
  return data;
}

VtuData Recorder::mesh_data() const {
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(world_.discretisation.get());
  const auto* fem = dynamic_cast<const FemDiscretisation*>(world_.discretisation.get());
  const Mesh& mesh = world_.discretisation->mesh();
  const CellContents contents = contents_of_cells(*world_.discretisation);
  const std::vector<PatchCell>& cells = contents.cells;
  const RecoveredStress recovered = recover_stress(*world_.discretisation, contents);
  VtuData data;
  std::vector<double> displacement, nodal, fill, stress, damage;
  std::vector<int> body;
  std::unordered_map<long, int> number;  // of corners; where fields of a grid meet each has its own
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const int cell = mpm ? mpm->active_cells()[k] : fem->elements()[k];
    for (std::size_t i = 0; i < cells[k].nodes.size(); ++i) {
      const long node = cells[k].nodes[i];
      const auto [at, added] = number.try_emplace(node, static_cast<int>(data.points.size()));
      data.connectivity.push_back(at->second);
      if (!added) continue;
      const Vec3 u = fem ? fem->displacement()[fem->blocks[static_cast<int>(k)][i]] : Vec3::Zero();
      data.points.push_back(mesh.nodes[node % mesh.n_nodes()] + u + world_.spec.origin);
      displacement.insert(displacement.end(), u.data(), u.data() + 3);
      const Voigt& s = recovered.node.at(node);
      nodal.insert(nodal.end(), s.data(), s.data() + 6);
    }
    data.offsets.push_back(static_cast<int>(data.connectivity.size()));
    data.types.push_back(vtk_type(mesh.kinds[mpm ? mpm->grid_cell(cell) : cell]));
    double volume = 0.0, sum = 0.0;
    Voigt s = Voigt::Zero();
    for (const int p : cells[k].points) {
      volume += contents.volume[p];
      sum += contents.volume[p] * contents.damage[p];
      s += contents.volume[p] * contents.stress[p];
    }
    if (volume > 0.0) {
      sum /= volume;
      s /= volume;
    }
    damage.push_back(sum);
    stress.insert(stress.end(), s.data(), s.data() + 6);
    if (mpm)
      fill.push_back(mpm->fill(static_cast<int>(k)));
    else
      body.push_back(fem->body_of_element(cell));
  }
  data.point_fields = {{"recovered_stress", 6, nodal}};
  data.cell_fields = {{"stress", 6, stress}, {"stress_error", 1, recovered.cell_error}, {"damage", 1, damage}};
  if (mpm)
    data.cell_fields.push_back({"fill", 1, fill});
  else {
    data.cell_fields.push_back({"body", 1, body});
    data.point_fields.push_back({"displacement", 3, displacement});
  }
  if (world_.comm.size() > 1)
    data.cell_fields.push_back({"rank", 1, std::vector<int>(cells.size(), world_.comm.rank())});
  return data;
}

/// Frames that are not in this folder, since the run goes on in another one, are left out.
void Recorder::restore_frames(std::vector<std::pair<double, std::string>> frames) {
  std::erase_if(frames, [&](const auto& frame) { return !std::filesystem::exists(folder_ / frame.second); });
  if (!frames.empty() && frames.back().first >= world_.time) last_frame_step_ = steps_;
  last_frame_step_ = world_.comm.broadcast(last_frame_step_);
  points_pvd_.restore(frames);
  for (auto& [time, file] : frames) file.replace(0, std::string("points").size(), "mesh");
  mesh_pvd_.restore(frames);
}

}  // namespace berm
