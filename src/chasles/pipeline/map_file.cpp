#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>
#include <zlib.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/pipeline/map_bytes.hpp>
#include <chasles/pipeline/map_file.hpp>

namespace chasles {
namespace {

// As PNG's: a transfer as text destroys it visibly.
constexpr std::string_view kMagic =
    "\x89"
    "CHASLES-MAP\r\n\x1a\n";
constexpr std::uint32_t kVersion = 3, kBeforeLenses = 2;
static_assert(kMagic.size() == 16);

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

// Up to version 2 a lens has five coefficients and one of three models. A map that needs no more is
// written as such, so that earlier programs read it.
constexpr std::size_t kCoefficientsBefore = 5;
bool needs_lenses(const LandmarkMap& map) {
  for (const MapSession& session : map.sessions) {
    for (const Camera& camera : session.cameras) {
      if (camera.distortion > Distortion::kEquidistant) return true;
      if (camera.coefficients.size() > kCoefficientsBefore) return true;
    }
  }
  return false;
}

std::size_t coefficients_of_version(std::uint32_t version) {
  return version > kBeforeLenses ? LensCoefficients::kMost : kCoefficientsBefore;
}

void put(const Camera& camera, std::uint32_t version, MapWriter& out) {
  out.put(static_cast<std::int32_t>(camera.width));
  out.put(static_cast<std::int32_t>(camera.height));
  for (const double v : {camera.fx, camera.fy, camera.cx, camera.cy}) out.put(v);
  out.put(static_cast<std::uint8_t>(camera.distortion));
  const std::size_t count = coefficients_of_version(version);
  for (std::size_t i = 0; i < count; ++i) out.put(camera.coefficients[i]);
  out.put_all(camera.cam_T_imu.R);
  out.put_all(camera.cam_T_imu.p);
}

constexpr std::size_t kCameraBytes = 8 + 32 + 1 + 8 * kCoefficientsBefore + 96;

Camera get_camera(std::uint32_t version, MapReader& in) {
  Camera camera;
  camera.width = in.get<std::int32_t>();
  camera.height = in.get<std::int32_t>();
  for (double* v : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *v = in.get<double>();
  const auto distortion = in.get<std::uint8_t>();
  camera.distortion = static_cast<Distortion>(distortion);
  in.check(find_lens_model(camera.distortion) != nullptr, "an unknown lens");
  std::vector<double> all(coefficients_of_version(version));
  for (double& k : all) k = in.get<double>();
  // Version 2 may have any numbers for a camera without distortion.
  if (camera.distortion == Distortion::kNone) all.clear();
  const auto stated = without_padding(camera.distortion, all);
  in.check(coefficients_fault(camera.distortion, stated).empty(), "a lens that cannot be");
  camera.coefficients = LensCoefficients(stated);
  in.get_all(camera.cam_T_imu.R);
  in.get_all(camera.cam_T_imu.p);
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy);
  in.check(finite && camera.width > 0 && camera.height > 0, "a camera that cannot be");
  return camera;
}

// A direction as three small numbers: 1/127 rad is enough, because views within 40 degrees are
// compared. The largest is 127, so that what was read is written as the same numbers.
Eigen::Vector3f rounded(const Eigen::Vector3f& direction) {
  const Eigen::Vector3f scaled = 127 * direction / direction.cwiseAbs().maxCoeff();
  return scaled.unaryExpr([](float v) { return std::round(v); });
}

// The descriptors of a merged map: its parts refer to them.
using Descriptors = std::array<Descriptor, PatchView::kLevels>;
struct KnownDescriptors {
  std::vector<Descriptors> all;
  std::map<Descriptors, std::uint32_t> numbers;

  explicit KnownDescriptors(const LandmarkMap& map) {
    for (const MapPoint& point : map.points) {
      for (const PatchView& view : point.appearance.views()) {
        numbers.emplace(view.descriptors, static_cast<std::uint32_t>(all.size()));
        all.push_back(view.descriptors);
      }
    }
  }
};
constexpr std::uint32_t kUnknown = 0xffffffff;

void put(const PatchView& view, const KnownDescriptors* known, MapWriter& out) {
  out.put(static_cast<std::int8_t>(view.level));
  const Eigen::Vector3f from = rounded(view.from);
  for (int i = 0; i < 3; ++i) out.put(static_cast<std::int8_t>(from(i)));
  if (known) {
    const auto number = known->numbers.find(view.descriptors);
    out.put(number == known->numbers.end() ? kUnknown : number->second);
    if (number != known->numbers.end()) return;
  }
  for (const Descriptor& descriptor : view.descriptors) {
    for (const std::uint64_t part : descriptor) out.put(part);
  }
}

constexpr std::size_t kViewBytes = 4 + 32 * PatchView::kLevels, kKnownViewBytes = 4 + 4;

PatchView get_view(const KnownDescriptors* known, MapReader& in) {
  PatchView view;
  view.level = in.get<std::int8_t>();
  for (int i = 0; i < 3; ++i) view.from(i) = in.get<std::int8_t>();
  in.check(view.from.norm() > 100, "a view without direction");
  view.from = rounded(view.from).normalized();
  const auto number = known ? in.get<std::uint32_t>() : kUnknown;
  if (number != kUnknown) {
    in.check(number < known->all.size(), "a view of an unknown number");
    view.descriptors = known->all[number];
    return view;
  }
  for (Descriptor& descriptor : view.descriptors) {
    for (std::uint64_t& part : descriptor) part = in.get<std::uint64_t>();
  }
  return view;
}

constexpr std::size_t kPointBytes = 24 + 4 + 4 + 24 + 1;

void put(const MapPoint& point, const Eigen::Matrix3d& own, const KnownDescriptors* known,
         MapWriter& out) {
  out.put_all(point.p_map);
  out.put(static_cast<std::uint32_t>(point.session));
  out.put(static_cast<std::uint32_t>(point.observations));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) out.put(static_cast<float>(own(i, j)));
  }
  const auto& views = point.appearance.views();
  out.put(static_cast<std::uint8_t>(views.size()));
  for (const PatchView& view : views) put(view, known, out);
}

MapPoint get_point(std::size_t sessions, const KnownDescriptors* known, MapReader& in,
                   Eigen::Matrix3d& own) {
  MapPoint point;
  in.get_all(point.p_map);
  const auto session = in.get<std::uint32_t>(), observations = in.get<std::uint32_t>();
  in.check(session < sessions, "a landmark of an unknown session");
  in.check(observations < 1'000'000'000, "an impossible number of observations");
  point.session = static_cast<int>(session);
  point.observations = static_cast<int>(observations);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) own(i, j) = own(j, i) = static_cast<double>(in.get<float>());
  }
  in.check(own.allFinite() && own.diagonal().minCoeff() >= 0, "a covariance that cannot be");
  const auto views = in.get<std::uint8_t>();
  in.check(views > 0 && views <= Appearance::kMostViews, "an impossible number of views");
  std::vector<PatchView> list;
  for (int i = 0; i < views; ++i) list.push_back(get_view(known, in));
  point.appearance = Appearance(std::move(list));
  return point;
}

void check_savable(const LandmarkMap& map) {
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const MapPoint& point = map.points[i];
    if (!point.p_map.allFinite() || !map.covariance.own()[i].allFinite() ||
        point.appearance.empty()) {
      throw UsageError("a landmark that is not finite or has no view cannot be saved in a map");
    }
  }
  if (!map.covariance.shared().cast<Eigen::half>().allFinite()) {
    throw UsageError("a map whose covariance is not finite cannot be saved");
  }
}

void put(const LandmarkMap& map, std::uint32_t version, const KnownDescriptors* known,
         MapWriter& out) {
  check_savable(map);
  out.put(static_cast<std::uint32_t>(map.sessions.size()));
  for (const MapSession& session : map.sessions) {
    out.put(std::string_view(session.name));
    out.put(static_cast<std::int64_t>(session.begin.count()));
    out.put(static_cast<std::int64_t>(session.end.count()));
    out.put(static_cast<std::uint32_t>(session.cameras.size()));
    for (const Camera& camera : session.cameras) put(camera, version, out);
  }
  out.put(static_cast<std::uint32_t>(map.points.size()));
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    put(map.points[i], map.covariance.own()[i], known, out);
  }
  out.put(static_cast<std::uint32_t>(map.covariance.rank()));
  out.put_all(map.covariance.shared().cast<Eigen::half>());
}

LandmarkMap get_map(std::uint32_t version, const KnownDescriptors* known, MapReader& in) {
  LandmarkMap map;
  map.sessions.resize(in.get_count(4 + 16 + 4));
  for (MapSession& session : map.sessions) {
    session.name = in.get_text();
    session.begin = Time(in.get<std::int64_t>());
    session.end = Time(in.get<std::int64_t>());
    const std::size_t cameras = in.get_count(kCameraBytes);
    for (std::size_t i = 0; i < cameras; ++i) session.cameras.push_back(get_camera(version, in));
  }
  map.points.resize(in.get_count(kPointBytes + (known ? kKnownViewBytes : kViewBytes)));
  std::vector<Eigen::Matrix3d> own(map.points.size());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    map.points[i] = get_point(map.sessions.size(), known, in, own[i]);
  }
  const std::size_t number = version == 1 ? sizeof(float) : sizeof(Eigen::half);
  const std::size_t rank = in.get_count(3 * number * map.points.size());
  in.check(map.points.empty() ? rank == 0 : rank <= 3 * map.points.size(), "an impossible rank");
  Eigen::MatrixXd shared(3 * static_cast<Eigen::Index>(own.size()),
                         static_cast<Eigen::Index>(rank));
  for (Eigen::Index i = 0; i < shared.rows(); ++i) {
    for (Eigen::Index j = 0; j < shared.cols(); ++j) {
      shared(i, j) = static_cast<double>(version == 1 ? static_cast<Eigen::half>(in.get<float>())
                                                      : in.get<Eigen::half>());
    }
  }
  in.check(shared.allFinite(), "a number that is not finite");
  map.covariance = JointCovariance(std::move(own), std::move(shared));
  return map;
}

// A check sum, a size, and what they are of.
void put_section(const std::string& bytes, MapWriter& out) {
  out.put(checksum(bytes));
  out.put(static_cast<std::uint64_t>(bytes.size()));
  out.append(bytes);
}

struct Section {
  std::string_view bytes;
  std::size_t first = 0;  // its place in the file
};

// From the end of what precedes it.
Section section(std::string_view file, std::size_t at, const std::string& name) {
  constexpr std::size_t kHeader = 4 + 8;
  MapReader header(file.substr(at), at, name);
  const auto sum = header.get<std::uint32_t>();
  const auto size = header.get<std::uint64_t>();
  const Section found{.bytes = file.substr(at + kHeader, size), .first = at + kHeader};
  if (found.bytes.size() != size) {
    throw InputError(fmt::format("{}: a damaged map: found {} bytes, expected {}; copy it again",
                                 name, file.size(), found.first + size));
  }
  if (checksum(found.bytes) != sum) {
    throw InputError(name +
                     ": a damaged map: its checksum is wrong; copy it again, or make it again");
  }
  return found;
}

struct Sections {
  std::uint32_t version = 0;
  Section map, parts;
};

Sections sections(std::string_view bytes, const std::string& name) {
  if (!bytes.starts_with(kMagic)) {
    throw InputError(name + ": is no map of Chasles; expected a file of `chasles run --save-map`");
  }
  constexpr std::size_t kFirst = kMagic.size() + 4;
  Sections found;
  found.version = MapReader(bytes.substr(kMagic.size()), kMagic.size(), name).get<std::uint32_t>();
  if (found.version < 1 || found.version > kVersion) {
    throw InputError(
        fmt::format("{}: found a map of version {}, expected at most {}; use the version of "
                    "Chasles that made it, or make it again",
                    name, found.version, kVersion));
  }
  found.map = section(bytes, kFirst, name);
  std::size_t end = found.map.first + found.map.bytes.size();
  if (found.version > 1) {
    found.parts = section(bytes, end, name);
    end = found.parts.first + found.parts.bytes.size();
  }
  if (end != bytes.size()) {
    throw InputError(fmt::format("{}: a damaged map: found {} bytes, expected {}; copy it again",
                                 name, bytes.size(), end));
  }
  return found;
}

LandmarkMap map_of(const Sections& file, const std::string& name) {
  MapReader in(file.map.bytes, file.map.first, name);
  LandmarkMap map = get_map(file.version, nullptr, in);
  in.check_end();
  return map;
}

}  // namespace

std::string map_bytes(const LandmarkMap& map, std::span<const LandmarkMap> parts) {
  MapWriter of_map, of_parts, file;
  const bool lenses = needs_lenses(map) || std::ranges::any_of(parts, needs_lenses);
  const std::uint32_t version = lenses ? kVersion : kBeforeLenses;
  put(map, version, nullptr, of_map);
  const KnownDescriptors known(map);
  of_parts.put(static_cast<std::uint32_t>(parts.size()));
  for (const LandmarkMap& part : parts) put(part, version, &known, of_parts);
  file.append(kMagic);
  file.put(version);
  put_section(of_map.bytes(), file);
  put_section(of_parts.bytes(), file);
  return file.bytes();
}

std::size_t write_map(const LandmarkMap& map, const std::filesystem::path& file,
                      std::span<const LandmarkMap> parts) {
  const std::string bytes = map_bytes(map, parts);
  replace_file(file, bytes);
  return bytes.size();
}

LandmarkMap parse_map(std::string_view bytes, const std::string& name) {
  return map_of(sections(bytes, name), name);
}

LandmarkMap read_map(const std::filesystem::path& file) {
  return parse_map(read_file(file), file.string());
}

std::vector<LandmarkMap> parse_map_parts(std::string_view bytes, const std::string& name) {
  const Sections file = sections(bytes, name);
  LandmarkMap map = map_of(file, name);
  std::vector<LandmarkMap> parts;
  if (file.version > 1) {
    const KnownDescriptors known(map);
    MapReader in(file.parts.bytes, file.parts.first, name);
    parts.resize(in.get_count(3 * sizeof(std::uint32_t)));
    for (LandmarkMap& part : parts) part = get_map(file.version, &known, in);
    in.check_end();
  }
  if (parts.empty()) parts.push_back(std::move(map));
  return parts;
}

std::vector<LandmarkMap> read_map_parts(const std::filesystem::path& file) {
  return parse_map_parts(read_file(file), file.string());
}

}  // namespace chasles
