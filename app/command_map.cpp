#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/base/median.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/loop/merge_maps.hpp>
#include <chasles/pipeline/map_file.hpp>
#include <chasles/pipeline/map_sketch.hpp>
#include <chasles/report/report.hpp>
#include <chasles/viewers/ply.hpp>

#include "map_output.hpp"
#include "options.hpp"
#include "print.hpp"
#include "subcommands.hpp"

namespace chasles::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct MapOptions {
  fs::path map;
  std::vector<fs::path> merged;
  fs::path output;
  fs::path drawing;  ///< of the map
  bool json = false;
};

Json description(const LandmarkMap& map, std::size_t parts, std::uintmax_t bytes) {
  Json sessions = Json::array();
  for (std::size_t i = 0; i < map.sessions.size(); ++i) {
    const MapSession& session = map.sessions[i];
    const auto initialised =
        std::ranges::count(map.points, static_cast<int>(i), &MapPoint::session);
    sessions.push_back({{"name", session.name},
                        {"begin_ns", session.begin.count()},
                        {"end_ns", session.end.count()},
                        {"cameras", session.cameras.size()},
                        {"landmarks", initialised}});
  }
  Eigen::Vector3d least = Eigen::Vector3d::Zero(), most = least;
  std::vector<double> sigmas;
  std::size_t views = 0;
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const Eigen::Vector3d& p = map.points[i].p_map;
    least = i == 0 ? p : Eigen::Vector3d(least.cwiseMin(p));
    most = i == 0 ? p : Eigen::Vector3d(most.cwiseMax(p));
    sigmas.push_back(std::sqrt(map.covariance.of(static_cast<int>(i)).trace()));
    views += map.points[i].appearance.views().size();
  }
  Json json = {{"landmarks", map.points.size()},
               {"bytes", bytes},
               {"sessions", sessions},
               {"parts", parts},
               {"least_m", {least.x(), least.y(), least.z()}},
               {"most_m", {most.x(), most.y(), most.z()}},
               {"views", views},
               {"shared_errors", map.covariance.rank()}};
  json["frame"] = map.sessions.empty() ? Json() : Json(map.sessions.front().name);
  json["median_sigma_m"] = sigmas.empty() ? Json() : Json(median(sigmas));
  json["largest_sigma_m"] = sigmas.empty() ? Json() : Json(*std::ranges::max_element(sigmas));
  return json;
}

std::string text_of(const fs::path& file, const Json& json) {
  const auto number = [&](const char* key) { return json.at(key).get<double>(); };
  std::string text = fmt::format("{}: {} landmarks, {:.1f} kB\n\n", file.string(),
                                 json.at("landmarks").get<long>(), 1e-3 * number("bytes"));
  const auto line = [&](const char* what, const std::string& value) {
    text += fmt::format("  {:<22} {}\n", what, value);
  };
  const auto along = [&](int axis) {
    const auto i = static_cast<std::size_t>(axis);
    return json.at("most_m")[i].get<double>() - json.at("least_m")[i].get<double>();
  };
  line("extent", fmt::format("{:.1f} x {:.1f} x {:.1f} m", along(0), along(1), along(2)));
  if (!json.at("median_sigma_m").is_null()) {
    line("sigma of a landmark", fmt::format("{:.3f} m (median), {:.3f} m (largest)",
                                            number("median_sigma_m"), number("largest_sigma_m")));
  }
  line("views", fmt::format("{}", json.at("views").get<long>()));
  line("shared errors", fmt::format("{}", json.at("shared_errors").get<long>()));
  if (const auto parts = json.at("parts").get<long>(); parts > 1) {
    line("maps merged in it", fmt::format("{}", parts));
  }
  if (!json.at("frame").is_null()) line("frame", "of " + json.at("frame").get<std::string>());
  for (const Json& session : json.at("sessions")) {
    const double seconds = 1e-9 * static_cast<double>(session.at("end_ns").get<std::int64_t>() -
                                                      session.at("begin_ns").get<std::int64_t>());
    line("session",
         fmt::format("{}: {} landmarks, {:.1f} s, {} camera{}",
                     session.at("name").get<std::string>(), session.at("landmarks").get<long>(),
                     seconds, session.at("cameras").get<long>(),
                     session.at("cameras").get<long>() == 1 ? "" : "s"));
  }
  for (const Json& joined : json.value("joined", Json::array())) {
    line("joined",
         fmt::format("{}: {} landmarks that both have, NIS {:.2f} per degree of freedom",
                     joined.at("name").get<std::string>(), joined.at("matches").get<long>(),
                     joined.at("nis_per_dof").get<double>()));
  }
  return text;
}

void print(const MapOptions& o, const fs::path& file, const Json& json) {
  app::print("{}", o.json ? json_text(json, 2) + "\n" : text_of(file, json));
}

std::string page_of(const MapOptions& o, const LandmarkMap& map, Json summary) {
  summary["version"] = CHASLES_VERSION;
  ReportRun page{.run = {}, .summary = json_text(summary)};
  page.run.name = valid_utf8(o.map.filename().string());
  page.run.prior_map = map_sketch(map);
  return map_page(page);
}

int show(const MapOptions& o) {
  const std::string ending = o.drawing.extension().string();
  if (!o.drawing.empty() && ending != ".html" && ending != ".ply") {
    throw UsageError(
        fmt::format("-o: found '{}', expected a file name that ends with .html or "
                    ".ply",
                    o.drawing.string()));
  }
  const LandmarkMap map = read_map(o.map);
  const Json json = description(map, read_map_parts(o.map).size(), fs::file_size(o.map));
  if (!o.drawing.empty()) {
    if (o.drawing.has_parent_path()) make_folder(o.drawing.parent_path());
    replace_file(o.drawing, ending == ".ply" ? map_ply(map_sketch(map)) : page_of(o, map, json));
  }
  if (o.json || o.drawing.empty()) {
    print(o, o.map, json);
  } else {
    app::print("{}: {}\n", ending == ".ply" ? "ply" : "page", o.drawing.string());
  }
  return 0;
}

// While a map is merged into one of those of which it is made, no run extends that.
std::optional<FolderLock> lock_of_output(const MapOptions& o) {
  const auto is_output = [&](const fs::path& file) { return is_same_file(file, o.output); };
  if (std::ranges::none_of(o.merged, is_output)) return std::nullopt;
  const fs::path file = followed(o.output);
  return std::optional<FolderLock>(std::in_place,
                                   file.has_parent_path() ? file.parent_path() : ".");
}

int merge(const MapOptions& o) {
  check_map_output(o.output);
  const std::optional<FolderLock> lock = lock_of_output(o);
  std::vector<MapPart> parts;
  int number = 0;
  for (const fs::path& file : o.merged) {
    std::vector<LandmarkMap> of_file = read_map_parts(file);
    const bool one = of_file.size() == 1;
    for (LandmarkMap& map : of_file) {
      std::string name = file.string();
      if (!one) name += fmt::format(" ({})", map.sessions.back().name);
      parts.push_back({.name = std::move(name), .map = std::move(map), .file = number});
    }
    ++number;
  }
  const MergedMaps merged = merge_maps(std::move(parts));
  const std::size_t bytes = write_map(merged.map, o.output, merged.parts);
  Json json = description(merged.map, std::max<std::size_t>(merged.parts.size(), 1), bytes);
  json["joined"] = Json::array();
  for (const MergedMaps::Joined& joined : merged.joined) {
    json["joined"].push_back({{"name", joined.sessions.back().name},
                              {"matches", joined.matches},
                              {"nis_per_dof", joined.nis / (3 * joined.matches)}});
  }
  print(o, o.output, json);
  return 0;
}

}  // namespace

Action declare_map(CLI::App& parser) {
  const auto o = std::make_shared<MapOptions>();
  parser.add_option("MAP", o->map, "Map, as `chasles run --save-map` writes it")->type_name("");
  parser
      .add_option("-o,--output", o->drawing,
                  "Write the map's landmarks, in the colours of its sessions: .html: a page; .ply: "
                  "for CloudCompare, MeshLab, Blender")
      ->check(require_path)
      ->type_name("FILE");
  parser.add_flag("--json", o->json, "Print as JSON");
  CLI::App* merging = parser.add_subcommand(
      "merge",
      "Merge maps at the places that they saw. Their order does not matter: the frame is that of "
      "the map whose first recording began first. A map that is in two of them counts once");
  merging->add_option("MAPS", o->merged, "Two or more maps, merged ones too")
      ->required()
      ->expected(2, -1)
      ->type_name("");
  merging->add_option("-o,--output", o->output, "File for the merged map")
      ->required()
      ->check(require_path)
      ->type_name("MAP");
  merging->add_flag("--json", o->json, "Print as JSON");
  return [o, merging] {
    if (merging->parsed()) return merge(*o);
    if (o->map.empty()) throw UsageError("map: expected a MAP, or `merge A B ... -o MAP`");
    return show(*o);
  };
}

}  // namespace chasles::app
