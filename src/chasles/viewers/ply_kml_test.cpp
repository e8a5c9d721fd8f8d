#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <regex>
#include <sstream>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/kml.hpp>
#include <chasles/viewers/ply.hpp>

namespace chasles {
namespace {

using test::synthetic_drive;

// An independent reader: elements with their rows as numbers, by the header's types.
struct Ply {
  struct Element {
    std::vector<std::string> names;
    std::vector<std::vector<double>> rows;
    double at(std::size_t row, const std::string& name) const {
      for (std::size_t k = 0; k < names.size(); ++k) {
        if (names[k] == name) return rows.at(row)[k];
      }
      throw std::out_of_range(name);
    }
  };
  Element vertex, edge;
};

template <typename Number>
double take(std::string_view& bytes) {
  Number number;
  std::memcpy(&number, bytes.data(), sizeof(number));  // the machine is little-endian
  bytes.remove_prefix(sizeof(number));
  return static_cast<double>(number);
}

Ply read_ply(const std::string& file) {
  static_assert(std::endian::native == std::endian::little);
  const std::size_t end = file.find("end_header\n");
  std::istringstream header(file.substr(0, end));
  std::string_view body = std::string_view(file).substr(end + 11);
  Ply ply;
  Ply::Element* element = nullptr;
  std::vector<std::pair<Ply::Element*, std::size_t>> sizes;
  std::map<Ply::Element*, std::vector<std::string>> types;
  for (std::string word; header >> word;) {
    if (word == "comment") std::getline(header, word);
    if (word == "element") {
      std::size_t size = 0;
      header >> word >> size;
      element = word == "vertex" ? &ply.vertex : &ply.edge;
      sizes.emplace_back(element, size);
    } else if (word == "property") {
      std::string type;
      header >> type >> word;
      types[element].push_back(type);
      element->names.push_back(word);
    }
  }
  for (const auto& [e, size] : sizes) {
    for (std::size_t i = 0; i < size; ++i) {
      auto& row = e->rows.emplace_back();
      for (const std::string& type : types[e]) {
        row.push_back(type == "float"   ? take<float>(body)
                      : type == "uchar" ? take<std::uint8_t>(body)
                                        : take<std::int32_t>(body));
      }
    }
  }
  EXPECT_TRUE(body.empty());
  return ply;
}

TEST(PlyOfARun, HasTheMapTheWaysAndTheirUncertainty) {
  ReportRun drive = synthetic_drive({.states = 80, .landmarks = 120});
  drive.run.landmarks[3].covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  drive.run.landmarks[11].id = 1LL << 40;
  const auto& run = drive.run;
  const Ply ply = read_ply(run_ply(run));
  ASSERT_EQ(ply.vertex.rows.size(), 119u + 3 * 80);
  EXPECT_EQ(ply.edge.rows.size(), 3u * 79);
  const RunLandmark& l = run.landmarks[10];  // the tenth that is finite
  EXPECT_EQ(ply.vertex.at(9, "landmark"), static_cast<double>(l.id));
  EXPECT_EQ(ply.vertex.at(10, "landmark"), -1) << "an id that PLY's integers do not hold";
  EXPECT_EQ(ply.vertex.at(9, "kind"), 0);
  EXPECT_EQ(ply.vertex.at(9, "observations"), l.observations);
  EXPECT_FLOAT_EQ(static_cast<float>(ply.vertex.at(9, "y")), static_cast<float>(l.p_world.y()));
  EXPECT_FLOAT_EQ(static_cast<float>(ply.vertex.at(9, "cov_xz")),
                  static_cast<float>(l.covariance(0, 2)));
  EXPECT_FLOAT_EQ(static_cast<float>(ply.vertex.at(9, "sigma")),
                  static_cast<float>(std::sqrt(l.covariance.trace())));
  const std::size_t pose = 119 + 5;
  EXPECT_EQ(ply.vertex.at(pose, "kind"), 1);
  EXPECT_EQ(ply.vertex.at(pose, "landmark"), -1);
  EXPECT_FLOAT_EQ(static_cast<float>(ply.vertex.at(pose, "cov_yy")),
                  static_cast<float>(run.states[5].pose_covariance(4, 4)));
}

TEST(PlyOfARun, LandmarksOfAMapShowTheirSessionAndWhetherTheyReturned) {
  const ReportRun drive = synthetic_drive({.states = 10, .landmarks = 30, .prior_map = true});
  const MapSketch& map = *drive.run.prior_map;
  const Ply ply = read_ply(run_ply(drive.run)), alone = read_ply(map_ply(map));
  ASSERT_EQ(ply.vertex.rows.size(), 30u + 20 + 3 * 10) << "the run has ten of the map";
  ASSERT_EQ(alone.vertex.rows.size(), 30u);
  std::size_t other = 30;
  for (std::size_t i = 0; i < 30; ++i) {
    const bool same = i % 3 == 0;
    EXPECT_EQ(ply.vertex.at(i, "kind"), same ? 4 : 0);
    EXPECT_EQ(ply.vertex.at(i, "returned"), i % 6 == 0);
    EXPECT_EQ(ply.vertex.at(i, "session"), same ? map.points[i].session : -1);
    EXPECT_EQ(alone.vertex.at(i, "session"), map.points[i].session);
    EXPECT_EQ(alone.vertex.at(i, "kind"), 4);
    EXPECT_FLOAT_EQ(static_cast<float>(alone.vertex.at(i, "z")),
                    static_cast<float>(map.points[i].p_map.z()));
    if (same) continue;
    EXPECT_EQ(ply.vertex.at(other, "kind"), 4);
    EXPECT_EQ(ply.vertex.at(other, "session"), map.points[i].session);
    const Eigen::Vector3d p_world = map.world_T_map * map.points[i].p_map;
    EXPECT_FLOAT_EQ(static_cast<float>(ply.vertex.at(other, "x")), static_cast<float>(p_world.x()));
    EXPECT_NEAR(ply.vertex.at(other, "cov_xy"), drive.run.landmarks[i].covariance(0, 1), 1e-6);
    ++other;
  }
}

TEST(PlyOfARun, WithoutEdgesItHasTheSameVertices) {
  const ReportRun drive = synthetic_drive({.states = 80, .landmarks = 120, .prior_map = true});
  const std::string points = run_ply(drive.run, PlyEdges::kNo);
  EXPECT_EQ(points.find("element edge"), std::string::npos);
  EXPECT_EQ(map_ply(*drive.run.prior_map).find("element edge"), std::string::npos);
  EXPECT_EQ(read_ply(points).vertex.rows, read_ply(run_ply(drive.run)).vertex.rows);
}

TEST(PlyOfARun, EdgesJoinTheNeighboursOfAWayAlone) {
  const ReportRun drive = synthetic_drive({.states = 80, .landmarks = 120});
  const Ply ply = read_ply(run_ply(drive.run));
  for (std::size_t i = 0; i < ply.edge.rows.size(); ++i) {
    const auto from = static_cast<std::size_t>(ply.edge.at(i, "vertex1"));
    const auto to = static_cast<std::size_t>(ply.edge.at(i, "vertex2"));
    EXPECT_EQ(to, from + 1);
    EXPECT_EQ(ply.vertex.at(from, "kind"), ply.vertex.at(to, "kind"));
    EXPECT_GE(ply.vertex.at(from, "kind"), 1);
  }
}

TEST(PlyOfARun, TheLeastCertainLandmarkIsTheBrightest) {
  chasles::Run run;
  run.landmarks.resize(3);
  for (int k = 0; k < 3; ++k) {
    RunLandmark& l = run.landmarks[static_cast<std::size_t>(k)];
    l.id = k;
    l.covariance = std::pow(10, k) * Eigen::Matrix3d::Identity();
  }
  const Ply ply = read_ply(run_ply(run));
  EXPECT_LT(ply.vertex.at(0, "green"), ply.vertex.at(1, "green"));
  EXPECT_LT(ply.vertex.at(1, "green"), ply.vertex.at(2, "green"));
}

// A run whose truth has a georeference, and whose own world is rotated against the truth's.
chasles::Run drive_on_earth() {
  Run run = synthetic_drive({.states = 100, .landmarks = 0}).run;
  run.name = "</name><x>&\x01 of \"Karlsruhe\"";
  run.georeference = {{.latitude = 49.011, .longitude = 8.423, .altitude = 116}};
  const SE3 turned{so3::exp({0, 0, 0.7}), {100, -30, 4}};
  run.truth.clear();
  for (const RunState& s : run.states) run.truth.push_back({s.time, turned * s.world_T_imu});
  return run;
}

// Longitude, latitude, altitude of the rows between two marks.
std::vector<Eigen::Vector3d> places(const std::string& text, const std::string& after,
                                    const std::string& until) {
  const std::size_t begin = text.find("<coordinates>", text.find(after)) + 13;
  std::istringstream rows(text.substr(begin, text.find(until, begin) - begin));
  std::vector<Eigen::Vector3d> list;
  char comma = 0;
  for (Eigen::Vector3d p; rows >> p.x() >> comma >> p.y() >> comma >> p.z();) list.push_back(p);
  return list;
}

TEST(KmlOfARun, TheEstimateLiesWhereTheTruthDoes) {
  const auto run = drive_on_earth();
  const std::string kml = run_kml(run);
  const auto truth = places(kml, "<name>truth", "</coordinates>");
  const auto estimate = places(kml, "<name>estimate", "</coordinates>");
  ASSERT_EQ(truth.size(), run.truth.size());
  ASSERT_EQ(estimate.size(), run.states.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_LT((truth[i] - estimate[i]).head<2>().norm(), 3e-9);
    // Mercator's inverse, in closed form.
    const double degree = M_PI / 180, s = std::cos(49.011 * degree) * 6378137;
    const Eigen::Vector3d& p = run.truth[i].pose.p;
    EXPECT_NEAR(truth[i].x(), 8.423 + p.x() / s / degree, 1e-9);
    const double y = s * std::atanh(std::sin(49.011 * degree)) + p.y();
    EXPECT_NEAR(truth[i].y(), std::asin(std::tanh(y / s)) / degree, 1e-9);
    EXPECT_NEAR(truth[i].z(), 116 + p.z(), 1e-3);
  }
}

TEST(KmlOfARun, IsWellFormedWhateverTheNameAndHasATimeForEachPlace) {
  const auto run = drive_on_earth();
  const std::string kml = run_kml(run);
  EXPECT_NE(kml.find("<name>&lt;/name&gt;&lt;x&gt;&amp; of \"Karlsruhe\"</name>"),
            std::string::npos);
  // A small parser: every opened element is closed, in order.
  std::vector<std::string> open;
  const std::regex tag("<(/?)([A-Za-z:]+)[^>]*>");
  for (std::sregex_iterator it(kml.begin(), kml.end(), tag), end; it != end; ++it) {
    if ((*it)[1].length() == 0) {
      open.push_back((*it)[2]);
    } else {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), (*it)[2]);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
  const auto count = [&](const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = kml.find(what); at != std::string::npos; at = kml.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("<when>"), run.states.size());
  EXPECT_EQ(count("<gx:coord>"), run.states.size());
  EXPECT_NE(kml.find("<when>2011-09-30T12:08:26.000Z</when>"), std::string::npos);
}

TEST(KmlOfARun, ANameInWhateverBytesLeavesXmlInUtf8) {
  auto run = drive_on_earth();
  run.name = "caf\xe9 \xc3\xa9 \xef\xbf\xbe\xef\xbf\xbf \xed\xa0\x80 \xf0\x9f\x9a\x97";
  const std::string kml = run_kml(run);
  const std::string r = "\xef\xbf\xbd";
  EXPECT_NE(kml.find("<name>caf" + r + " \xc3\xa9 " + r + r + " " + r + r + r +
                     " \xf0\x9f\x9a\x97</name>"),
            std::string::npos);
  EXPECT_EQ(valid_utf8(kml), kml);
}

TEST(KmlOfARun, LongitudesGoOnAcrossTheDateLineAndUnknownPlacesAreLeftOut) {
  auto run = drive_on_earth();
  run.georeference->origin.longitude = 179.9999;
  run.dead_reckoning = run.truth;
  run.dead_reckoning[3].pose.p.x() = std::numeric_limits<double>::quiet_NaN();
  const std::string kml = run_kml(run);
  bool west = false;
  for (const auto& p : places(kml, "<name>truth", "</coordinates>")) {
    EXPECT_LE(std::abs(p.x()), 180);
    west = west || p.x() < 0;
  }
  EXPECT_TRUE(west);
  EXPECT_EQ(places(kml, "<name>dead reckoning", "</coordinates>").size(),
            run.dead_reckoning.size() - 1);
  EXPECT_EQ(kml.find("nan"), std::string::npos);
}

TEST(KmlOfARun, ARunThatIsNowhereOnTheEarthIsRejected) {
  auto run = drive_on_earth();
  run.georeference.reset();
  EXPECT_THROW(run_kml(run), InputError);
  run = drive_on_earth();
  run.truth.clear();
  EXPECT_THROW(run_kml(run), InputError);
}

}  // namespace
}  // namespace chasles
