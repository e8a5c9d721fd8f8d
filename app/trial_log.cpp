#include "trial_log.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>

#include "filter_options.hpp"
#include "lab_report.hpp"
#include "loops_options.hpp"
#include "output_folder.hpp"
#include "scene_options.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// The columns of a record, common to its averages and its seconds.
template <typename Figures, typename Visitor>
void for_each_column(Figures& figures, Visitor&& visit) {
  visit("position_error_m", figures.position_error, 1.0);
  visit("attitude_error_deg", figures.attitude_error, kDegrees);
  visit("nees_position", figures.nees_position, 1.0);
  visit("nees_attitude", figures.nees_attitude, 1.0);
  visit("nees_pose", figures.nees_pose, 1.0);
  visit("nees_state", figures.nees_state, 1.0);
}

template <typename Averages, typename Visitor>
void for_each_average(Averages& averages, Visitor&& visit) {
  for_each_column(averages, visit);
  visit("position_rms_m", averages.position_rms, 1.0);
  visit("ate_m", averages.ate, 1.0);
  visit("ate_posyaw_m", averages.ate_posyaw, 1.0);
  visit("attitude_posyaw_deg", averages.attitude_posyaw, kDegrees);
  visit("nis_per_dof", averages.nis_per_dof, 1.0);
  visit("innovation_correlation", averages.innovation_correlation, 1.0);
  visit("landmarks", averages.landmarks, 1.0);
}

Json seconds_json(std::span<const TrialRecord::Second> seconds) {
  Json columns = Json::object();
  const TrialRecord::Second none;
  for_each_column(none, [&](const char* name, double, double) { columns[name] = Json::array(); });
  for (const TrialRecord::Second& second : seconds) {
    for_each_column(second, [&](const char* name, double value, double unit) {
      columns[name].push_back(number_json(value * unit));
    });
  }
  return columns;
}

double number_of(const Json& json) { return json.is_null() ? std::nan("") : json.get<double>(); }

std::vector<TrialRecord::Second> seconds_of(const Json& columns) {
  std::vector<TrialRecord::Second> seconds(columns.at("position_error_m").size());
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    for_each_column(seconds[i], [&](const char* name, double& value, double unit) {
      value = number_of(columns.at(name).at(i)) / unit;
    });
  }
  return seconds;
}

// FNV-1a (Fowler, Noll, Vo) hash of 64 bits, to compare two lists of numbers.
class Digest {
 public:
  void add(std::int64_t number) { add_bytes(&number); }
  void add(const Eigen::Ref<const Eigen::VectorXd>& numbers) {
    for (const double number : numbers) add_bytes(&number);
  }
  std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  template <typename Number>
  void add_bytes(const Number* number) {
    std::array<unsigned char, sizeof *number> bytes;
    std::memcpy(bytes.data(), number, sizeof *number);
    for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 0x100000001b3u;
  }
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

Json digest_of(const Trajectory& path) {
  if (path.empty()) return nullptr;
  Digest digest;
  for (const StampedPose& pose : path) {
    digest.add(pose.time.count());
    digest.add(pose.pose.p);
    digest.add(pose.pose.R.reshaped());
  }
  return digest.text();
}

Json digest_of(const std::vector<ImuSample>& imu) {
  if (imu.empty()) return nullptr;
  Digest digest;
  for (const ImuSample& sample : imu) {
    digest.add(sample.time.count());
    digest.add(sample.specific_force_imu);
    digest.add(sample.angular_rate_imu);
  }
  return digest.text();
}

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

Json summary_of(const Json& plan, std::span<const FilterVariant> filters,
                std::span<const FilterSummary> summaries, std::size_t runs) {
  Json summary{{"name", plan.at("scene").at("name")},
               {"version", plan.at("version")},
               {"seed", plan.at("scene").at("seed")},
               {"runs", runs},
               {"filters", Json::array()},
               {"scene", plan.at("scene")}};
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    Json figures = figures_json(filters[i], summaries[i]);
    figures["settings"] = plan.at("filters").at(i).at("settings");
    summary["filters"].push_back(std::move(figures));
  }
  return summary;
}

// Throws unless the plan has all that is read from it later.
Json read_plan(const fs::path& folder) {
  const fs::path file = folder / "plan.json";
  Json plan = parse_json_object(read_file(file), file.string());
  try {
    filters_of(plan);
    summary_of(plan, {}, {}, 0);
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not the plan of a study: {}", file.string(), error.what()));
  }
  return plan;
}

// Path of the first difference, for a message.
std::string difference(const Json& a, const Json& b) {
  const Json patch = Json::diff(a, b);
  return patch.empty() ? "" : patch.front().at("path").get<std::string>();
}

void check_same(const Json& a, const Json& b, const std::string& who, const std::string& what) {
  if (a == b) return;
  throw UsageError(fmt::format("{} has another plan.json than {}: they differ at {}", who, what,
                               difference(a, b)));
}

// The runs with a line for every filter. The last line or the last run may be incomplete.
std::map<std::uint64_t, std::string> read_trials(const fs::path& file, const Json& plan) {
  std::map<std::uint64_t, std::map<std::string, std::string>> found;
  std::string text = read_file(file);
  text.resize(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::string line(take_line(rest));
    const TrialRecord record = from_line(line, fmt::format("{}:{}", file.string(), number));
    found[record.run][record.filter] = line + "\n";
  }
  const std::vector<FilterVariant> filters = filters_of(plan);
  std::map<std::uint64_t, std::string> complete;
  for (const auto& [run, lines] : found) {
    if (lines.size() != filters.size()) continue;
    for (const FilterVariant& filter : filters) complete[run] += lines.at(filter.name);
  }
  return complete;
}

std::map<std::uint64_t, std::string> lines_to_resume(const fs::path& folder, const Json& plan,
                                                     std::span<const std::uint64_t> runs,
                                                     bool resume) {
  if (!is_there(folder / "trials.jsonl")) return {};
  if (!resume) {
    throw UsageError(fmt::format(
        "{} holds a study: --resume continues it; expected a folder without one", folder.string()));
  }
  check_same(read_plan(folder), plan, folder.string(), "the requested study");
  std::map<std::uint64_t, std::string> lines = read_trials(folder / "trials.jsonl", plan);
  for (const auto& [run, text] : lines) {
    if (std::ranges::binary_search(runs, run)) continue;
    throw UsageError(
        fmt::format("{} holds run {}, which is not among the requested runs (--runs, "
                    "--first, --shard)",
                    folder.string(), run));
  }
  return lines;
}

fs::path plan_to_hold(const fs::path& folder) {
  make_folder(folder);
  return folder / "plan.json";
}

}  // namespace

Json plan_json(const InertialScene& scene, std::span<const FilterVariant> filters) {
  Json plan{{"version", CHASLES_VERSION},
            {"scene", settings_json(scene.settings)},
            {"path", digest_of(scene.path)},
            {"imu", digest_of(scene.imu)},
            {"filters", Json::array()}};
  for (const FilterVariant& filter : filters) {
    Json& own = plan["filters"].emplace_back();
    own = {{"filter", filter.name}, {"settings", settings_json(filter)}};
    if (filter.estimator.is_window()) own["window"] = filter.estimator.keyframes;
  }
  return plan;
}

Json plan_json(const LoopsSettings& scene, std::span<const FilterVariant> filters) {
  Json plan{
      {"version", CHASLES_VERSION}, {"scene", settings_json(scene)}, {"filters", Json::array()}};
  for (const FilterVariant& filter : filters) {
    plan["filters"].push_back(
        {{"filter", filter.name}, {"settings", loops_settings_json(filter.settings)}});
  }
  return plan;
}

std::vector<FilterVariant> filters_of(const Json& plan) {
  std::vector<FilterVariant> filters;
  for (const Json& filter : plan.at("filters")) {
    FilterVariant& variant = filters.emplace_back();
    variant.name = filter.at("filter").get<std::string>();
    variant.settings.chart = filter.at("settings").at("chart").get<std::string>();
    variant.estimator.keyframes = filter.value("window", 0);
    using Kind = EstimatorChoice::Kind;
    const bool smooths = filter.at("settings").contains("batch.loss");
    variant.estimator.kind = variant.estimator.keyframes > 0 ? Kind::kWindow
                             : smooths                       ? Kind::kBatch
                                                             : Kind::kFilter;
  }
  return filters;
}

std::string to_line(const TrialRecord& record) {
  Json line{{"run", record.run}, {"filter", record.filter}, {"diverged", record.diverged}};
  for_each_average(record.averages, [&](const char* name, double value, double unit) {
    line[name] = number_json(value * unit);
  });
  line["seconds"] = seconds_json(record.seconds);
  if (!record.smoothed.empty()) line["smoothed"] = seconds_json(record.smoothed);
  return json_text(line) + "\n";
}

TrialRecord from_line(const std::string& text, const std::string& where) {
  const Json line = parse_json_object(text, where);
  try {
    TrialRecord record{.filter = line.at("filter").get<std::string>(),
                       .run = line.at("run").get<std::uint64_t>(),
                       .diverged = line.at("diverged").get<bool>(),
                       .averages = {},
                       .seconds = {}};
    for_each_average(record.averages, [&](const char* name, double& value, double unit) {
      value = number_of(line.at(name)) / unit;
    });
    record.seconds = seconds_of(line.at("seconds"));
    if (line.contains("smoothed")) record.smoothed = seconds_of(line.at("smoothed"));
    return record;
  } catch (const Json::exception& error) {
    throw InputError(fmt::format("{}: not a trial: {}", where, error.what()));
  }
}

TrialLog::TrialLog(fs::path folder)
    : folder_(std::move(folder)), lock_(plan_to_hold(folder_), !is_there(trials())) {}

void TrialLog::begin(const Json& plan, Lines lines) {
  plan_ = plan;
  lines_ = std::move(lines);
  prepare_output(folder_);
  // Their presence marks a complete study.
  remove_file(folder_ / "summary.json");
  remove_file(folder_ / "curves.csv");
  write_file(folder_ / "plan.json", json_text(plan_, 2) + "\n");
  write_trials();
}

TrialLog::TrialLog(const fs::path& folder, const Json& plan, std::span<const std::uint64_t> runs,
                   bool resume)
    : TrialLog(folder) {
  begin(plan, lines_to_resume(folder, plan, runs, resume));
}

TrialLog::TrialLog(fs::path folder, const Json& plan, Lines lines) : TrialLog(std::move(folder)) {
  begin(plan, std::move(lines));
}

TrialLog TrialLog::merged(std::span<const fs::path> folders, fs::path folder) {
  const Json plan = read_plan(folders.front());
  Lines lines;
  for (const fs::path& part : folders) {
    check_same(read_plan(part), plan, part.string(), folders.front().string());
    if (!is_there(part / "summary.json")) {
      throw InputError(
          fmt::format("{}: the study is not complete; continue it with --resume", part.string()));
    }
    for (auto& [run, text] : read_trials(part / "trials.jsonl", plan)) {
      if (lines.emplace(run, text).second) continue;
      throw UsageError(
          fmt::format("{}: run {} is in another of the studies as well", part.string(), run));
    }
  }
  if (is_there(folder / "trials.jsonl")) {
    throw UsageError(
        fmt::format("{} holds a study: expected a folder without one", folder.string()));
  }
  return {std::move(folder), plan, std::move(lines)};
}

void TrialLog::add(std::uint64_t run, const std::string& lines) {
  lines_.emplace(run, lines);
  std::ofstream file(trials(), std::ios::binary | std::ios::app);
  file << lines << std::flush;
  if (!file) {
    throw UsageError(
        fmt::format("{}: cannot be written: {}", trials().string(), std::strerror(errno)));
  }
}

void TrialLog::write_trials() const {
  std::string text;
  for (const auto& [run, lines] : lines_) text += lines;
  replace_file(trials(), text);
}

std::vector<FilterSummary> TrialLog::finish() {
  write_trials();
  // From the content of the file, so that a resumed or merged study has the same bytes.
  std::vector<TrialRecord> records;
  for (const auto& [run, lines] : lines_) {
    std::string_view rest = lines;
    while (!rest.empty()) {
      records.push_back(from_line(std::string(take_line(rest)), trials().string()));
    }
  }
  const std::vector<FilterVariant> filters = filters_of(plan_);
  std::vector<FilterSummary> summaries = summarize(filters, records);
  summary_ = summary_of(plan_, filters, summaries, lines_.size());
  FileSet files(folder_, "summary.json");
  files.add("curves.csv", curves_csv(summaries));
  files.add("summary.json", json_text(summary_, 2) + "\n");
  files.commit();
  return summaries;
}

}  // namespace chasles::app
