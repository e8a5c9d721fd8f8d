#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/report/study.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

double number_of(const Json& json) { return json.is_null() ? std::nan("") : json.get<double>(); }

// A table of numbers, accessed by the names of its columns; with a name in the first column if
// `named`.
class Columns {
 public:
  Columns(const fs::path& file, std::initializer_list<const char*> names) : csv_(file) {
    for (const char* name : names) {
      const auto found = std::ranges::find(csv_.columns(), name);
      if (found == csv_.columns().end()) {
        throw InputError(
            fmt::format("{}: has no column '{}', which a study's table has", file.string(), name));
      }
      index_[name] = static_cast<std::size_t>(found - csv_.columns().begin());
    }
  }
  bool next() { return csv_.next(); }
  double operator[](const char* name) const { return csv_.number(index_.at(name)); }
  std::string text(const char* name) const { return std::string(csv_.text(index_.at(name))); }
  std::string where() const { return csv_.where(); }

 private:
  CsvReader csv_;
  std::map<std::string, std::size_t, std::less<>> index_;
};

void add_row(const Columns& row, const char* seconds, StudyCurves& curves) {
  curves.seconds.push_back(row[seconds]);
  curves.position_error.push_back(row["position_error_m"]);
  curves.attitude_error.push_back(row["attitude_error_deg"]);
  curves.nees_position.push_back(row["nees_position"]);
  curves.nees_attitude.push_back(row["nees_attitude"]);
  curves.nees_pose.push_back(row["nees_pose"]);
  curves.nees_state.push_back(row["nees_state"]);
}

#define CHASLES_CURVE_COLUMNS                                                              \
  "position_error_m", "attitude_error_deg", "nees_position", "nees_attitude", "nees_pose", \
      "nees_state"

// Empty where there is no such file.
std::vector<TrueLandmark> read_landmarks(const fs::path& file) {
  std::vector<TrueLandmark> landmarks;
  if (!is_there(file)) return landmarks;
  Columns row(file, {"landmark", "x", "y", "z"});
  while (row.next()) {
    landmarks.push_back(
        {static_cast<LandmarkId>(landmarks.size()), {row["x"], row["y"], row["z"]}});
  }
  return landmarks;
}

// One run: NAME.csv and NAME.tum, one row and one pose per frame, and NAME_landmarks.csv.
void read_filter_of_one_run(const fs::path& folder, StudyCurves& curves) {
  const fs::path file = folder / (curves.filter + ".csv");
  Columns row(file, {"seconds", CHASLES_CURVE_COLUMNS});
  while (row.next()) add_row(row, "seconds", curves);
  const fs::path poses = folder / (curves.filter + ".tum");
  curves.estimate = read_tum(poses);
  curves.landmarks = read_landmarks(folder / (curves.filter + kLandmarksFile + ".csv"));
  if (curves.estimate.size() == curves.seconds.size()) return;
  throw InputError(fmt::format(
      "{}: found {} poses, expected {}, as {} has rows; is a file truncated?", poses.string(),
      curves.estimate.size(), curves.seconds.size(), file.filename().string()));
}

void read_one_run(const fs::path& folder, const Json& summary, Study& study) {
  for (std::size_t i = 0; i < study.filters.size(); ++i) {
    read_filter_of_one_run(folder, study.filters[i]);
    const std::size_t expected = summary.at("filters").at(i).at("frames").get<std::size_t>();
    const std::size_t found = study.filters[i].seconds.size();
    if (found == expected) continue;
    throw InputError(fmt::format("{}: found {} rows, expected {}, the `frames` of summary.json",
                                 (folder / (study.filters[i].filter + ".csv")).string(), found,
                                 expected));
  }
  study.truth = read_tum(folder / "truth.tum");
  study.landmarks = read_landmarks(folder / "landmarks_truth.csv");
}

std::size_t filter_called(const std::string& name, const Study& study, const std::string& where) {
  const auto found = std::ranges::find(study.filters, name, &StudyCurves::filter);
  if (found != study.filters.end()) {
    return static_cast<std::size_t>(found - study.filters.begin());
  }
  throw InputError(
      fmt::format("{}: found the filter '{}', which summary.json does not have", where, name));
}

void read_curves(const fs::path& file, Study& study) {
  Columns row(file, {"filter", "second", CHASLES_CURVE_COLUMNS});
  while (row.next()) {
    const std::size_t filter = filter_called(row.text("filter"), study, row.where());
    add_row(row, "second", study.filters[filter]);
  }
}

StudyTrial trial_from(std::string_view text, const Study& study, const std::string& where) {
  const Json line = parse_json(text, where);
  try {
    StudyTrial trial;
    trial.filter = filter_called(line.at("filter").get<std::string>(), study, where);
    trial.run = line.at("run").get<std::uint64_t>();
    trial.diverged = line.at("diverged").get<bool>();
    trial.position_error = number_of(line.at("position_error_m"));
    trial.attitude_error = number_of(line.at("attitude_error_deg"));
    trial.nees_position = number_of(line.at("nees_position"));
    trial.nees_attitude = number_of(line.at("nees_attitude"));
    trial.nees_pose = number_of(line.at("nees_pose"));
    return trial;
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not a trial: {}", where, error.what()));
  }
}

void read_trials(const fs::path& file, const Json& summary, Study& study) {
  const std::string text = read_file(file);
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string where = fmt::format("{}:{}", file.string(), number);
    study.trials.push_back(trial_from(take_line(rest), study, where));
  }
  const std::size_t expected = summary.at("runs").get<std::size_t>() * study.filters.size();
  if (study.trials.size() == expected) return;
  throw InputError(
      fmt::format("{}: found {} trials, expected {}: a line for each of the runs and filters of "
                  "summary.json; is the file truncated?",
                  file.string(), study.trials.size(), expected));
}

// Names must be file names within this folder.
void check_name(const std::string& name, const fs::path& file) {
  if (!name.empty() && name.find_first_of("/\\") == std::string::npos &&
      name.find('\0') == std::string::npos) {
    return;
  }
  throw InputError(fmt::format("{}: found a filter called '{}', expected the name of a file",
                               file.string(), name));
}

Json read_study_summary(const fs::path& folder, Study& study) {
  const fs::path file = folder / "summary.json";
  if (!is_there(file) && is_there(folder / "trials.jsonl")) {
    throw InputError(
        fmt::format("{}: the study is not complete; go on with it by `chasles montecarlo --resume`",
                    folder.string()));
  }
  study.summary = read_file(file);
  Json summary = parse_json_object(study.summary, file.string());
  for (const Json& filter : summary.at("filters")) {
    study.filters.emplace_back().filter = filter.at("filter").get<std::string>();
    check_name(study.filters.back().filter, file);
  }
  if (study.filters.empty()) {
    throw InputError(fmt::format("{}: `filters` is empty, expected one or more", file.string()));
  }
  return summary;
}

}  // namespace

bool is_study(const fs::path& folder) {
  if (is_there(folder / "states.csv")) return false;
  if (is_there(folder / "plan.json") || is_there(folder / "trials.jsonl")) return true;
  const fs::path file = folder / "summary.json";
  if (!is_there(file)) return false;
  const Json summary = parse_json(read_file(file), file.string());
  return summary.is_object() && summary.contains("filters");
}

Study read_study(const fs::path& folder) {
  Study study{.folder = folder.string(), .summary = {}};
  study.single_run = !is_there(folder / "plan.json") && !is_there(folder / "trials.jsonl");
  try {
    const Json summary = read_study_summary(folder, study);
    if (study.single_run) {
      read_one_run(folder, summary, study);
    } else {
      read_curves(folder / "curves.csv", study);
      read_trials(folder / "trials.jsonl", summary, study);
    }
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not the summary of a study: {}",
                                 (folder / "summary.json").string(), error.what()));
  }
  return study;
}

}  // namespace chasles
