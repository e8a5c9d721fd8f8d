#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/text_file.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/report/study_testing.hpp>

namespace chasles::test {
namespace {

using Json = nlohmann::ordered_json;

// Uniform in 0 ... 1, the same on every machine.
double noise(int a, int b) {
  const double x = std::sin(12.9898 * a + 78.233 * b) * 43758.5453;
  return x - std::floor(x);
}

Eigen::Vector3d place(double t) {
  const double angle = 2 * std::numbers::pi * t;
  return {100 + 20 * std::cos(angle), 50 + 8 * std::sin(angle), 1.2};
}

std::vector<TrueLandmark> landmarks_of(const StudyOptions& o) {
  std::vector<TrueLandmark> landmarks;
  for (int i = 0; i < o.frames && o.runs == 0; ++i) {
    const Eigen::Vector3d aside(3 * noise(i, 1), 3 * noise(i, 2), 0);
    landmarks.push_back({i, place(static_cast<double>(i) / o.frames) + aside});
  }
  return landmarks;
}

StudyCurves curves_of(const StudyOptions& o, int k) {
  StudyCurves curves;
  curves.filter = fmt::format("{}-{}", o.filter_name, k);
  for (int i = 0; i < o.frames; ++i) {
    const double t = static_cast<double>(i) / o.frames, factor = 1 + 6 * k;
    const double error = 0.2 * t * (1 + k) * (0.6 + noise(k, i));
    curves.seconds.push_back(o.runs > 0 ? i : 0.1 * i);
    curves.position_error.push_back(error);
    curves.attitude_error.push_back(0.5 * error);
    curves.nees_position.push_back(i == 0 ? std::nan("") : 6 * factor * noise(k, i + 1));
    curves.nees_attitude.push_back(6 * factor * noise(k, i + 2));
    curves.nees_pose.push_back(12 * factor * noise(k, i + 3));
    curves.nees_state.push_back(std::nan(""));
    if (o.runs > 0) continue;
    StampedPose pose{.time = std::chrono::milliseconds(100 * i), .pose = {}};
    pose.pose.p = place(t) + Eigen::Vector3d(error, -error, 0);
    curves.estimate.push_back(pose);
  }
  for (const TrueLandmark& mark : landmarks_of(o)) {
    const auto i = static_cast<int>(mark.id);
    curves.landmarks.push_back(
        {mark.id, mark.p_world + 0.3 * (1 + k) * Eigen::Vector3d(noise(k, i), noise(i, k), 0)});
  }
  return curves;
}

Json figures_of(const StudyOptions& o, int k, const StudyCurves& curves) {
  const int diverged = o.runs > 0 && k == o.filters - 1 ? 1 : 0;
  const double factor = 1 + 6 * k;
  return {{"filter", curves.filter},
          {"chart", "standard"},
          {"runs", std::max(1, o.runs)},
          {"diverged", diverged},
          {"position_error_m", 0.1 * (1 + k)},
          {"position_rms_m", 0.12 * (1 + k)},
          {"attitude_error_deg", 0.05 * (1 + k)},
          {"ate_posyaw_m", nullptr},
          {"nees_position", 3 * factor},
          {"nees_attitude", 3 * factor},
          {"nees_pose", 6 * factor},
          {"nees_state", nullptr},
          {"nees_pose_per_dof", factor},
          {"nis_per_dof", 1.01},
          {"landmarks", 40},
          {"median", {{"position_error_m", 0.09}, {"nees_pose", 6.0}}},
          {"band", {0.9, 1.1}},
          {"seconds_inside_band", 0.94},
          {"frames", o.frames},
          {"settings", {{"chart", "standard"}, {"gate", 0.99 - 0.1 * k}}}};
}

std::vector<StudyTrial> trials_of(const StudyOptions& o) {
  std::vector<StudyTrial> trials;
  for (int run = 0; run < o.runs; ++run) {
    for (int k = 0; k < o.filters; ++k) {
      // Run 3 is an outlier of every filter.
      const double size = (0.5 + noise(run, k)) * (1 + k) * (run == 3 ? 12 : 1);
      trials.push_back({.filter = static_cast<std::size_t>(k),
                        .run = static_cast<std::uint64_t>(run),
                        .diverged = run == 0 && k == o.filters - 1,
                        .position_error = 0.1 * size,
                        .attitude_error = 0.05 * size,
                        .nees_position = 3 * size,
                        .nees_attitude = 3 * size,
                        .nees_pose = 6 * size});
    }
  }
  return trials;
}

std::string curves_text(const StudyCurves& c, const std::string& before) {
  std::string text;
  for (std::size_t i = 0; i < c.seconds.size(); ++i) {
    text += fmt::format("{}{},{},{},{},{},{},{}\n", before, c.seconds[i], c.position_error[i],
                        c.attitude_error[i], c.nees_position[i], c.nees_attitude[i], c.nees_pose[i],
                        c.nees_state[i]);
  }
  return text;
}

constexpr const char* kCurveColumns =
    "position_error_m,attitude_error_deg,nees_position,nees_attitude,nees_pose,nees_state\n";

void write_landmarks(const std::vector<TrueLandmark>& landmarks,
                     const std::filesystem::path& file) {
  std::string rows = "landmark,x,y,z\n";
  for (const TrueLandmark& m : landmarks) {
    rows += fmt::format("{},{},{},{}\n", m.id, m.p_world.x(), m.p_world.y(), m.p_world.z());
  }
  write_file(file, rows);
}

void write_one_run(const Study& study, const std::filesystem::path& folder) {
  for (const StudyCurves& curves : study.filters) {
    write_file(folder / (curves.filter + ".csv"),
               std::string("seconds,") + kCurveColumns + curves_text(curves, ""));
    write_tum(curves.estimate, folder / (curves.filter + ".tum"));
    write_landmarks(curves.landmarks, folder / (curves.filter + "_landmarks.csv"));
  }
  write_tum(study.truth, folder / "truth.tum");
  write_landmarks(study.landmarks, folder / "landmarks_truth.csv");
}

void write_runs(const Study& study, const std::filesystem::path& folder) {
  std::string curves = std::string("filter,second,") + kCurveColumns, trials;
  for (const StudyCurves& c : study.filters) curves += curves_text(c, c.filter + ",");
  for (const StudyTrial& t : study.trials) {
    trials += Json{{"run", t.run},
                   {"filter", study.filters[t.filter].filter},
                   {"diverged", t.diverged},
                   {"position_error_m", t.position_error},
                   {"attitude_error_deg", t.attitude_error},
                   {"nees_position", t.nees_position},
                   {"nees_attitude", t.nees_attitude},
                   {"nees_pose", t.nees_pose}}
                  .dump() +
              "\n";
  }
  write_file(folder / "plan.json", "{}\n");
  write_file(folder / "curves.csv", curves);
  write_file(folder / "trials.jsonl", trials);
}

}  // namespace

Study synthetic_study(const StudyOptions& o) {
  Study study{.folder = "out/synthetic", .summary = {}, .single_run = o.runs == 0};
  Json summary{{"name", o.name}, {"version", "0.1.0"}, {"seed", 1}};
  summary[o.runs == 0 ? "run" : "runs"] = o.runs;
  summary["filters"] = Json::array();
  for (int k = 0; k < o.filters; ++k) {
    study.filters.push_back(curves_of(o, k));
    summary["filters"].push_back(figures_of(o, k, study.filters.back()));
  }
  summary["scene"] = {{"name", o.name}, {"seed", 1}, {"pixel_sigma", 1.5}};
  study.summary = summary.dump(2) + "\n";
  study.trials = trials_of(o);
  for (int i = 0; i < o.frames && o.runs == 0; ++i) {
    StampedPose pose{.time = std::chrono::milliseconds(100 * i), .pose = {}};
    pose.pose.p = place(static_cast<double>(i) / o.frames);
    study.truth.push_back(pose);
  }
  study.landmarks = landmarks_of(o);
  return study;
}

void write_study(const Study& study, const std::filesystem::path& folder) {
  make_folder(folder);
  write_file(folder / "summary.json", study.summary);
  study.single_run ? write_one_run(study, folder) : write_runs(study, folder);
}

}  // namespace chasles::test
