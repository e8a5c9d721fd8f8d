#include "recognition_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/numbers.hpp>

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

double since_start(Time time, const Run& run) {
  return run.states.empty() ? 0 : to_seconds(time - run.states.front().time);
}

Json closures_json(const std::vector<Closure>& closures, const Run& run) {
  Json list = Json::array();
  for (const Closure& c : closures) {
    list.push_back({{"time_ns", c.time.count()},
                    {"seconds", since_start(c.time, run)},
                    {"landmarks", c.landmarks},
                    {"moved_m", c.moved},
                    {"turned_rad", c.turned},
                    {"chi2", c.square},
                    {"chi2_dof", c.dof},
                    {"undone", c.undone}});
  }
  return list;
}

Json pose_json(const SE3& pose) {
  const Eigen::Vector4d q = unit_quaternion(pose.R);
  return {{"position_m", {pose.p.x(), pose.p.y(), pose.p.z()}},
          {"quaternion_xyzw", {q[0], q[1], q[2], q[3]}}};
}

Json sessions_json(const MapSketch& map) {
  Json list = Json::array();
  for (const SketchSession& session : map.sessions) {
    list.push_back({{"name", session.name},
                    {"begin_ns", session.begin.count()},
                    {"end_ns", session.end.count()},
                    {"cameras", session.cameras}});
  }
  return list;
}

Json place_json(const PlaceCounts& places, const Run& run) {
  Json json = {{"searches", places.searches}, {"proposed", places.proposed},
               {"refused", places.rejected},  {"placed_ns", nullptr},
               {"placed_seconds", nullptr},   {"world_T_map", nullptr},
               {"sessions", Json::array()}};
  if (places.placed) {
    json["placed_ns"] = places.placed->count();
    json["placed_seconds"] = since_start(*places.placed, run);
  }
  if (run.prior_map) {
    json["world_T_map"] = pose_json(run.prior_map->world_T_map);
    json["sessions"] = sessions_json(*run.prior_map);
  }
  return json;
}

std::string line(const char* label, const std::string& value, const std::string& more) {
  return fmt::format("  {:<26} {:>10}{}\n", label, value, more);
}

std::string closures_text(const Json& closures) {
  double moved = 0, square = 0, dof = 0;
  int undone = 0;
  for (const Json& closure : closures) {
    undone += closure.at("undone").get<bool>() ? 1 : 0;
    moved = std::max(moved, closure.at("moved_m").get<double>());
    square += closure.at("chi2").get<double>();
    dof += closure.at("chi2_dof").get<double>();
  }
  std::string more;
  if (dof > 0) {
    more = fmt::format(" (largest jump {:.3f} m, chi2 {:.2f} per degree of freedom{})", moved,
                       square / dof, undone > 0 ? fmt::format("; {} undone", undone) : "");
  }
  return line("loop closures", std::to_string(closures.size()), more);
}

std::string place_text(const Json& place) {
  const bool own = place.at("of_this_run").get<bool>();
  const char* label = own ? "place after the loss" : "place in the map";
  const Json& seconds = place.at("placed_seconds");
  const std::string attempts =
      fmt::format("searches {}, proposed {}, rejected {}", place.at("searches").get<int>(),
                  place.at("proposed").get<int>(), place.at("refused").get<int>());
  if (seconds.is_null()) return line(label, "not found", " (" + attempts + ")");
  return line(label, "found", fmt::format(" after {:.1f} s ({})", seconds.get<double>(), attempts));
}

}  // namespace

Json recognition_json(const EstimatorReport& report, const Run& run, bool has_prior_map) {
  Json json = {{"closures", closures_json(report.closures, run)},
               {"recognised_ns", Json::array()},
               {"recognised_tracks", Json::array()}};
  for (const Time time : report.recognised) json["recognised_ns"].push_back(time.count());
  for (const auto& [track, landmark] : report.known_as) {
    json["recognised_tracks"].push_back({track, landmark});
  }
  // Without a prior map, a run that was lost looks in what it saw before.
  if (has_prior_map || report.places.searches > 0) {
    json["place_in_map"] = place_json(report.places, run);
    json["place_in_map"]["of_this_run"] = !has_prior_map;
  }
  return json;
}

std::string recognition_text(const Json& summary) {
  std::string text;
  if (const auto found = summary.find("closures"); found != summary.end()) {
    text += closures_text(*found);
  }
  if (const auto found = summary.find("place_in_map"); found != summary.end()) {
    text += place_text(*found);
  }
  return text;
}

}  // namespace chasles::app
