#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/batch.hpp>
#include <chasles/many/batch_difference.hpp>
#include <chasles/many/batch_folder.hpp>
#include <chasles/pipeline/shared_map.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/output_folder.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

// A setting that no recording can use is an error of the batch, not of each recording.
void check_settings(const SettingSources& sources) {
  try {
    inertial_run_settings_from(sources);
  } catch (const UsageError&) {
    try {
      velocity_run_settings_from(sources);
      return;
    } catch (const UsageError&) {
    }
    throw;
  }
}

Json seconds_json(const std::optional<double>& seconds) {
  return seconds ? Json(*seconds) : Json(nullptr);
}

// FNV-1a of 64 bits: it finds an accident, not an attack.
std::string digest(const std::string& bytes) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3u;
  }
  return fmt::format("{:016x}", hash);
}

Json plan_of(const BatchOptions& o) {
  const SessionOptions& s = o.run.session;
  return {{"version", CHASLES_VERSION},
          {"rules", kRulesOfVerdicts},
          {"estimator", name_of(s.settings.estimator)},
          {"config", s.settings.config.empty() ? "" : read_text(s.settings.config)},
          {"set", s.settings.sets},
          {"chart", s.settings.chart},
          {"mode", s.settings.mode},
          {"begin", s.begin},
          {"as_recorded", s.as_recorded},
          {"cameras", s.input.cameras},
          {"start", seconds_json(s.input.start)},
          {"stop", seconds_json(s.input.stop)},
          {"map", s.map.string()},
          {"map_digest", s.map.empty() ? "" : digest(read_file(s.map))},
          {"map_from", o.map_from ? o.items[*o.map_from].recording.string() : ""},
          {"check", o.run.check},
          {"limits",
           {{"coverage", o.run.limits.least_coverage},
            {"sigma", o.run.limits.most_sigma},
            {"drift", o.run.limits.most_drift},
            {"nis", o.run.limits.most_nis}}},
          {"bounds",
           {{"seconds_per_minute", o.bounds.seconds_per_minute},
            {"megabytes_per_minute", o.bounds.megabytes_per_minute}}}};
}

// Runs recordings in processes, and keeps their records.
class Batch {
 public:
  Batch(const BatchOptions& options, const BatchObserver& observer)
      : o_(options),
        observer_(observer),
        folder_(options.output, plan_of(options), options.shard, options.resume) {}

  BatchEnd run() {
    if (o_.collect) {
      for (const BatchItem& item : o_.items) list(item);
      finish();
      return end_;
    }
    std::vector<std::size_t> missing;
    for (std::size_t i = 0; i < o_.items.size(); ++i) {
      if (!o_.shard.has(i)) continue;
      ++end_.total;
      const auto record = folder_.record(o_.items[i]);
      if (record && !is_retried(*record)) {
        note(*record);
      } else {
        missing.push_back(i);
      }
    }
    observer_.begins(missing.size());
    AssessedRunOptions run = o_.run;
    if (o_.map_from) {
      if (!make_map(*o_.map_from, missing)) return interrupted();
      run.session.map = folder_.map();
    }
    if (!work(missing, run)) return interrupted();
    finish();
    return end_;
  }

 private:
  bool is_retried(const Json& record) const {
    return std::ranges::any_of(record.at("reasons"), [&](const Json& reason) {
      return std::ranges::count(o_.retry, reason.value("reason", "")) > 0;
    });
  }

  void list(const BatchItem& item) {
    ++end_.total;
    if (const auto record = folder_.record(item)) note(*record);
    Json record = folder_.record(item).value_or(
        Json{{"name", item.name}, {"recording", item.said_source()}, {"verdict", nullptr}});
    record.erase("sketch");
    observer_.listed(record);
  }

  void note(const Json& record) {
    ++end_.done;
    const std::string verdict = record.at("verdict");
    for (const Verdict one : {Verdict::kUse, Verdict::kCheck, Verdict::kNo}) {
      if (verdict == name_of(one)) end_.worst = std::max(end_.worst, one);
    }
  }

  BatchEnd interrupted() {
    end_.interrupted = true;
    return end_;
  }

  // Returns false where it was interrupted.
  bool work(const std::vector<std::size_t>& numbers, const AssessedRunOptions& run) {
    return run_in_bounded_processes(
        numbers, o_.jobs, o_.bounds,
        [&](std::size_t i, const std::function<void(double)>& minutes) {
          const BatchItem& item = o_.items[i];
          return json_text(assessed_run(run, item, folder_.run_of(item), minutes));
        },
        [&](std::size_t i, const EndedProcess& end) { keep(o_.items[i], end); }, observer_.stop);
  }

  static Json record_of(const BatchItem& item, const EndedProcess& end) {
    switch (end.how) {
      case EndedProcess::How::kDone:
        return Json::parse(end.result);
      case EndedProcess::How::kTime:
        return record_without_run(item, {"time", end.result});
      case EndedProcess::How::kMemory:
        return record_without_run(item, {"memory", end.result});
      case EndedProcess::How::kDied:
        break;
    }
    return record_without_run(item, {"died", end.result});
  }

  void keep(const BatchItem& item, const EndedProcess& end) {
    Json record = record_of(item, end);
    if (record.contains(kOutputError)) {
      throw UsageError(record.at(kOutputError).get<std::string>());
    }
    const auto rounded = [](double x) { return std::round(1000 * x) / 1000; };
    const Json timing{{"name", item.name},
                      {"attempts", end.attempts},
                      {"seconds_wall", rounded(end.wall_seconds)},
                      {"seconds_cpu", rounded(end.cpu_seconds)},
                      {"peak_mb", rounded(1e-6 * static_cast<double>(end.peak_bytes))}};
    folder_.add(item, record, timing);
    note(record);
    record.erase("sketch");
    observer_.ended(record, timing);
  }

  // Returns false where it was interrupted.
  bool make_map(std::size_t number, std::vector<std::size_t>& missing) {
    const BatchItem& item = o_.items[number];
    if (std::erase(missing, number) > 0) {
      AssessedRunOptions run = o_.run;
      run.session.save_map = folder_.map();
      if (!work({number}, run)) return false;
    }
    const Json record = *folder_.record(item);
    if (record.at("verdict") == name_of(Verdict::kNo)) {
      throw InputError(fmt::format(
          "--map-from: {} has the verdict no ({}); expected a recording whose map can be used",
          item.recording.string(), record.at("reasons").at(0).at("what").get<std::string>()));
    }
    return true;
  }

  void finish() {
    const bool complete = std::ranges::all_of(
        o_.items, [&](const BatchItem& item) { return folder_.record(item).has_value(); });
    if (!complete) return;
    if (!o_.against.empty()) {
      std::vector<Json> now;
      for (const BatchItem& item : o_.items) now.push_back(*folder_.record(item));
      end_.difference = batch_difference(read_verdicts(o_.against), now);
    }
    end_.summary = folder_.finish(o_.items, end_.difference);
  }

  const BatchOptions& o_;
  const BatchObserver& observer_;
  BatchFolder folder_;
  BatchEnd end_;
};

}  // namespace

BatchEnd run_batch(const BatchOptions& options, const BatchObserver& observer) {
  const SessionOptions& session = options.run.session;
  check_settings(session.settings);
  if (!session.map.empty()) SharedMap(session.map);  // an error of the batch, not of each recording
  for (const BatchItem& item : options.items) {
    if (item.source.empty()) reject_output_into(options.output, item.recording);
  }
  if (!options.against.empty()) read_verdicts(options.against);
  return Batch(options, observer).run();
}

}  // namespace chasles
