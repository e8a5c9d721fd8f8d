#include <matio.h>
#include <utility>
#include <vector>

#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

#include "kinds.hpp"
#include "parts.hpp"

namespace chasles::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kTracks = 6;

Recording small_drive() { return test::drive({.frames = 8, .tracks = kTracks}); }

std::string npz_seed(const fs::path& scratch) {
  test::write_npz(scratch / "seed.npz", test::npz_fields(small_drive(), kTracks));
  return test::slurp(scratch / "seed.npz");
}

void read_npz(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.npz", std::string(bytes));
  read_npz_recording(scratch / "input.npz");
}

std::string npy_seed(const fs::path&) {
  Parts parts;
  for (const auto& [name, field] : test::npz_fields(small_drive(), kTracks)) {
    parts.emplace_back(name + ".npy", test::npy_bytes(field));
  }
  return pack(parts);
}

void read_npy(const fs::path& scratch, std::string_view bytes) {
  test::write_zip(scratch / "input.npz", unpack(bytes));
  read_npz_recording(scratch / "input.npz");
}

void write_variable(mat_t* mat, const char* name, std::vector<std::size_t> shape,
                    std::vector<double> values) {
  matvar_t* variable =
      Mat_VarCreate(name, MAT_C_DOUBLE, MAT_T_DOUBLE, static_cast<int>(shape.size()), shape.data(),
                    values.data(), 0);
  // Not compressed: a mutation then meets the structure, not a check sum.
  Mat_VarWrite(mat, variable, MAT_COMPRESSION_NONE);
  Mat_VarFree(variable);
}

std::string mat_seed(const fs::path& scratch) {
  const Recording r = small_drive();
  const std::size_t T = r.frames.size();
  std::vector<double> t, v, w, y(4 * T * kTracks, -1);
  for (std::size_t k = 0; k < T; ++k) {
    t.push_back(to_seconds(r.frames[k].time));
    v.insert(v.end(), r.velocities[k].linear_imu.begin(), r.velocities[k].linear_imu.end());
    w.insert(w.end(), r.velocities[k].angular_imu.begin(), r.velocities[k].angular_imu.end());
    for (const StereoObservation& o : r.frames[k].observations) {
      const std::size_t at = 4 * (k + T * static_cast<std::size_t>(o.landmark));
      for (int row = 0; row < 4; ++row) y[at + static_cast<std::size_t>(row)] = o.pixels[row];
    }
  }
  mat_t* mat = Mat_CreateVer((scratch / "seed.mat").c_str(), nullptr, MAT_FT_MAT5);
  write_variable(mat, "fu", {1, 1}, {r.rig.fx});
  write_variable(mat, "fv", {1, 1}, {r.rig.fy});
  write_variable(mat, "cu", {1, 1}, {r.rig.cx});
  write_variable(mat, "cv", {1, 1}, {r.rig.cy});
  write_variable(mat, "b", {1, 1}, {r.rig.baseline});
  write_variable(mat, "C_c_v", {3, 3}, {0, 0, 1, -1, 0, 0, 0, -1, 0});
  write_variable(mat, "rho_v_c_v", {3, 1}, {1.1, -0.3, 0.7});
  write_variable(mat, "t", {1, T}, t);
  write_variable(mat, "v_vk_vk_i", {3, T}, v);
  write_variable(mat, "w_vk_vk_i", {3, T}, w);
  write_variable(mat, "y_k_j", {4, T, kTracks}, y);
  Mat_Close(mat);
  return test::slurp(scratch / "seed.mat");
}

void read_mat(const fs::path& scratch, std::string_view bytes) {
  test::spill(scratch / "input.mat", std::string(bytes));
  read_mat_recording(scratch / "input.mat");
}

std::string folder_seed(const fs::path& scratch) {
  write_folder_recording(small_drive(), scratch / "seed");
  return pack(parts_of(scratch / "seed"));
}

void read_folder(const fs::path& scratch, std::string_view bytes) {
  lay_out(scratch / "input", bytes);
  read_folder_recording(scratch / "input");
}

}  // namespace

std::vector<Kind> velocity_kinds() {
  return {{"npz", npz_seed, read_npz},
          {"npy", npy_seed, read_npy},
          {"mat", mat_seed, read_mat},
          {"folder", folder_seed, read_folder}};
}

}  // namespace chasles::fuzz
