#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/codec/utf8.hpp>
#include <chasles/live/live_text.hpp>
#include <chasles/report/page_data.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

const char* name(LiveStage stage) {
  switch (stage) {
    case LiveStage::kWaiting:
      return "waiting";
    case LiveStage::kRunning:
      return "running";
    case LiveStage::kSmoothing:
      return "smoothing";
    case LiveStage::kFinished:
      return "finished";
    case LiveStage::kInterrupted:
      return "interrupted";
    case LiveStage::kFailed:
      return "failed";
  }
  return "";
}

Json progress_json(const LiveProgress& p) {
  return {{"stage", name(p.stage)},        {"frames", p.frames},     {"of", p.of},
          {"seconds", p.recorded_seconds}, {"wall", p.wall_seconds}, {"message", p.message},
          {"stoppable", p.stoppable}};
}

/// The first state of the run, and those of the range.
std::vector<std::size_t> states_of(const LiveRows& rows) {
  std::vector<std::size_t> states;
  if (rows.from > 0) states.push_back(0);
  for (std::size_t i = rows.from; i < rows.to; ++i) states.push_back(i);
  return states;
}

/// The range as a run of its own. Truth: all of it, or one pose to create the columns of the
/// errors.
ReportRun piece(const Run& run, const std::vector<std::size_t>& states,
                const GrowingComparison& comparison, const LiveRows& rows) {
  ReportRun out;
  out.run.name = run.name;
  out.run.extra_names = run.extra_names;
  for (const std::size_t i : states) out.run.states.push_back(run.states[i]);
  if (rows.landmarks > 0) out.run.landmarks = run.landmarks;
  if (rows.landmarks > 0 || rows.prior_map) out.run.prior_map = run.prior_map;
  if (rows.from == 0) out.run.dead_reckoning = run.dead_reckoning;
  if (comparison.started()) {
    out.run.truth = rows.truth ? comparison.truth() : Trajectory{comparison.truth().front()};
  }
  return out;
}

}  // namespace

std::string rows_text(const Run& run, const LiveSummary& summary,
                      const GrowingComparison& comparison, const LiveRows& rows,
                      const LiveProgress& progress) {
  const std::vector<std::size_t> states = states_of(rows);
  const AgainstTruth errors = comparison.started() ? comparison.of(states) : AgainstTruth{};
  const Json known = rows.from == 0 ? Json::parse(summary.before) : Json::object();
  Json data = run_data(piece(run, states, comparison, rows), known, errors);
  if (rows.from > 0) data.erase("summary");
  if (rows.landmarks == 0 && rows.from > 0) data.erase("landmarks");
  if (!rows.truth) data.erase("truth");
  // Of a map that the viewer has, only what changes.
  if (data.contains("map") && !rows.prior_map) {
    data["map"] = {{"returned", data["map"]["marks"]["returned"]}};
  }
  Json json = {{"run", rows.id},  {"progress", progress_json(progress)}, {"from", rows.from},
               {"rows", rows.to}, {"skip", rows.from > 0 ? 1 : 0},       {"data", std::move(data)}};
  if (rows.landmarks > 0) {
    json["landmarks"] = rows.landmarks;
    json["known"] = Json::parse(summary.known);
  }
  if (rows.from == 0) json["bounds"] = page_bounds();
  return json_text(json);
}

std::string progress_text(std::string_view id, const LiveProgress& progress) {
  return json_text({{"run", id}, {"progress", progress_json(progress)}});
}

std::string page_text(std::string_view id, const std::vector<ReportRun>& runs,
                      const LiveProgress& progress) {
  return json_text({{"run", id}, {"progress", progress_json(progress)}, {"all", page_data(runs)}});
}

}  // namespace chasles
