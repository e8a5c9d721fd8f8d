#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/viewers/colours.hpp>
#include <chasles/viewers/kml.hpp>
#include <chasles/viewers/placement.hpp>

namespace chasles {
namespace {

// Escapes text for XML. Entities replace markup; U+FFFD replaces invalid UTF-8 and the two
// non-characters; control characters are removed.
std::string escaped(const std::string& text) {
  std::string valid = valid_utf8(text);
  for (const char* none : {"\xef\xbf\xbe", "\xef\xbf\xbf"}) {
    for (std::size_t at = 0; (at = valid.find(none, at)) != std::string::npos;) {
      valid.replace(at, 3, "\xef\xbf\xbd");
    }
  }
  std::string out;
  for (const char c : valid) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) out += c;
    }
  }
  return out;
}

// KML's order is alpha, blue, green, red.
std::string style(const std::string& id, unsigned colour) {
  const Rgb c = rgb(colour);
  return fmt::format(
      "<Style id=\"{}\"><LineStyle><color>ff{:02x}{:02x}{:02x}</color><width>3</width></LineStyle>"
      "</Style>\n",
      id, c[2], c[1], c[0]);
}

// Longitudes from -180 to 180.
std::string degrees_and_metres(const Geodetic& g, const char* separator) {
  return fmt::format("{1:.9f}{0}{2:.9f}{0}{3:.3f}", separator, std::remainder(g.longitude, 360),
                     g.latitude, g.altitude);
}

std::string line(const std::string& name, const std::string& id, const Georeference& earth,
                 const Trajectory& way, const SE3& placed) {
  std::string text = fmt::format(
      "<Placemark><name>{}</name><styleUrl>#{}</styleUrl><LineString><tessellate>1</tessellate>"
      "<altitudeMode>clampToGround</altitudeMode><coordinates>\n",
      name, id);
  for (const StampedPose& s : way) {
    if (!s.pose.p.allFinite()) continue;
    text += degrees_and_metres(to_geodetic(earth, placed * s.pose.p), ",") + "\n";
  }
  return text + "</coordinates></LineString></Placemark>\n";
}

// 2011-09-26T13:02:25.964Z
std::string utc(Time time) {
  using namespace std::chrono;
  const auto day = floor<days>(sys_time<nanoseconds>(time));
  const year_month_day date(day);
  const hh_mm_ss clock(floor<milliseconds>(time - day.time_since_epoch()));
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", static_cast<int>(date.year()),
                     static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                     clock.hours().count(), clock.minutes().count(), clock.seconds().count(),
                     clock.subseconds().count());
}

std::string track(const Georeference& earth, const Trajectory& way, const SE3& placed) {
  std::string text =
      "<Placemark><name>estimate, over time</name><styleUrl>#estimate</styleUrl><gx:Track>"
      "<altitudeMode>clampToGround</altitudeMode>\n";
  for (const StampedPose& s : way) text += "<when>" + utc(s.time) + "</when>\n";
  for (const StampedPose& s : way) {
    text += "<gx:coord>" + degrees_and_metres(to_geodetic(earth, placed * s.pose.p), " ") +
            "</gx:coord>\n";
  }
  return text + "</gx:Track></Placemark>\n";
}

}  // namespace

std::string run_kml(const Run& run) {
  if (!run.georeference) {
    throw InputError(fmt::format(
        "run '{}' is not georeferenced: the place of its world on the Earth is unknown. Runs of "
        "KITTI raw recordings are, with their own truth; summary.json then has 'georeference'",
        run.name));
  }
  const Trajectory estimate = finite_poses(run);
  const SE3 placed = truth_T_world(run);
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
      "xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n<name>{}</name>\n",
      escaped(run.name));
  text += style("estimate", kEstimateColour) + style("truth", kTruthColour) +
          style("dead_reckoning", kDeadReckoningColour);
  text += line("truth", "truth", *run.georeference, run.truth, {});
  if (!run.dead_reckoning.empty()) {
    text += line("dead reckoning", "dead_reckoning", *run.georeference, run.dead_reckoning, placed);
  }
  text += line("estimate", "estimate", *run.georeference, estimate, placed);
  text += track(*run.georeference, estimate, placed);
  return text + "</Document>\n</kml>\n";
}

}  // namespace chasles
