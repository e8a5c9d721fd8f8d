#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <zlib.h>

#include <fmt/format.h>

#include <chasles/data/durable_file.hpp>
#include <chasles/data/read_budget.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>
#include <chasles/pipeline/map_file.hpp>

namespace chasles {
namespace {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

// As PNG's: a transfer as text destroys it visibly.
constexpr std::string_view kMagic =
    "\x89"
    "CHASLES-MAP\r\n\x1a\n";
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kHeader = 16 + 4 + 4 + 8;
static_assert(kMagic.size() == 16);

class Writer {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
  }
  template <typename Derived>
  void put_all(const Eigen::MatrixBase<Derived>& values) {  // row by row
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      for (Eigen::Index j = 0; j < values.cols(); ++j) put(values(i, j));
    }
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

class Cursor {
 public:
  Cursor(std::string_view bytes, const std::string& name) : bytes_(bytes), name_(name) {}

  template <typename T>
  T get() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string get_text() {
    const auto size = get<std::uint32_t>();
    need(size);
    std::string text(bytes_.substr(at_, size));
    at_ += size;
    return text;
  }
  template <typename T>
  void get_all(T& values) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      for (Eigen::Index j = 0; j < values.cols(); ++j) values(i, j) = get<typename T::Scalar>();
    }
    check(values.allFinite(), "a number that is not finite");
  }
  // A count of things of at least so many bytes each.
  std::size_t get_count(std::size_t least) {
    const auto count = get<std::uint32_t>();
    need(count * least);
    return count;
  }
  void check(bool right, const char* found) const {
    if (!right) {
      throw InputError(
          fmt::format("{}: a damaged map: found {} near byte {}; make it again, or use "
                      "a copy",
                      name_, found, kHeader + at_));
    }
  }
  void check_end() const { check(at_ == bytes_.size(), "bytes behind its end"); }

 private:
  void need(std::size_t size) const {
    check(size <= bytes_.size() - at_, "its end where more was expected");
  }

  std::string_view bytes_;
  const std::string& name_;
  std::size_t at_ = 0;
};

std::uint32_t checksum(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

void put(const Camera& camera, Writer& out) {
  out.put(static_cast<std::int32_t>(camera.width));
  out.put(static_cast<std::int32_t>(camera.height));
  for (const double v : {camera.fx, camera.fy, camera.cx, camera.cy}) out.put(v);
  out.put(static_cast<std::uint8_t>(camera.distortion));
  out.put_all(camera.coefficients);
  out.put(camera.radtan_k3);
  out.put_all(camera.cam_T_imu.R);
  out.put_all(camera.cam_T_imu.p);
}

constexpr std::size_t kCameraBytes = 8 + 32 + 1 + 32 + 8 + 96;

Camera get_camera(Cursor& in) {
  Camera camera;
  camera.width = in.get<std::int32_t>();
  camera.height = in.get<std::int32_t>();
  for (double* v : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *v = in.get<double>();
  const auto distortion = in.get<std::uint8_t>();
  in.check(distortion <= static_cast<std::uint8_t>(Distortion::kEquidistant), "an unknown lens");
  camera.distortion = static_cast<Distortion>(distortion);
  in.get_all(camera.coefficients);
  camera.radtan_k3 = in.get<double>();
  in.get_all(camera.cam_T_imu.R);
  in.get_all(camera.cam_T_imu.p);
  const bool finite = std::isfinite(camera.fx) && std::isfinite(camera.fy) &&
                      std::isfinite(camera.cx) && std::isfinite(camera.cy) &&
                      std::isfinite(camera.radtan_k3);
  in.check(finite && camera.width > 0 && camera.height > 0, "a camera that cannot be");
  return camera;
}

// 1/127 rad is enough: views within 40 degrees are compared.
void put(const PatchView& view, Writer& out) {
  out.put(static_cast<std::int8_t>(view.level));
  for (int i = 0; i < 3; ++i) {
    out.put(static_cast<std::int8_t>(std::lround(127 * view.from(i))));
  }
  for (const Descriptor& descriptor : view.descriptors) {
    for (const std::uint64_t part : descriptor) out.put(part);
  }
}

constexpr std::size_t kViewBytes = 4 + 32 * PatchView::kLevels;

PatchView get_view(Cursor& in) {
  PatchView view;
  view.level = in.get<std::int8_t>();
  for (int i = 0; i < 3; ++i) view.from(i) = in.get<std::int8_t>();
  in.check(view.from.norm() > 100, "a view without direction");
  view.from.normalize();
  for (Descriptor& descriptor : view.descriptors) {
    for (std::uint64_t& part : descriptor) part = in.get<std::uint64_t>();
  }
  return view;
}

constexpr std::size_t kPointBytes = 24 + 4 + 4 + 24 + 1;

void put(const MapPoint& point, const Eigen::Matrix3d& own, Writer& out) {
  out.put_all(point.p_map);
  out.put(static_cast<std::uint32_t>(point.session));
  out.put(static_cast<std::uint32_t>(point.observations));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) out.put(static_cast<float>(own(i, j)));
  }
  const auto& views = point.appearance.views();
  out.put(static_cast<std::uint8_t>(views.size()));
  for (const PatchView& view : views) put(view, out);
}

MapPoint get_point(std::size_t sessions, Cursor& in, Eigen::Matrix3d& own) {
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
  for (int i = 0; i < views; ++i) list.push_back(get_view(in));
  point.appearance = Appearance(std::move(list));
  return point;
}

}  // namespace

std::string map_bytes(const LandmarkMap& map) {
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    const MapPoint& point = map.points[i];
    if (!point.p_map.allFinite() || !map.covariance.own()[i].allFinite() ||
        point.appearance.empty()) {
      throw UsageError("a landmark that is not finite or has no view cannot be saved in a map");
    }
  }
  if (!map.covariance.shared().allFinite()) {
    throw UsageError("a map whose covariance is not finite cannot be saved");
  }
  Writer out;
  out.put(static_cast<std::uint32_t>(map.sessions.size()));
  for (const MapSession& session : map.sessions) {
    out.put(std::string_view(session.name));
    out.put(static_cast<std::int64_t>(session.begin.count()));
    out.put(static_cast<std::int64_t>(session.end.count()));
    out.put(static_cast<std::uint32_t>(session.cameras.size()));
    for (const Camera& camera : session.cameras) put(camera, out);
  }
  out.put(static_cast<std::uint32_t>(map.points.size()));
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    put(map.points[i], map.covariance.own()[i], out);
  }
  out.put(static_cast<std::uint32_t>(map.covariance.rank()));
  out.put_all(map.covariance.shared().cast<float>());
  const std::string body = out.take();
  Writer file;
  file.put(kVersion);
  file.put(checksum(body));
  file.put(static_cast<std::uint64_t>(body.size()));
  return std::string(kMagic) + file.take() + body;
}

std::size_t write_map(const LandmarkMap& map, const std::filesystem::path& file) {
  const std::string bytes = map_bytes(map);
  replace_file(file, bytes);
  return bytes.size();
}

LandmarkMap parse_map(std::string_view bytes, const std::string& name) {
  if (!bytes.starts_with(kMagic)) {
    throw InputError(name + ": is no map of Chasles; expected a file of `chasles run --save-map`");
  }
  Cursor header(bytes.substr(kMagic.size()), name);
  const auto version = header.get<std::uint32_t>(), sum = header.get<std::uint32_t>();
  const auto size = header.get<std::uint64_t>();
  if (version != kVersion) {
    throw InputError(
        fmt::format("{}: found a map of version {}, expected {}; use the version of "
                    "Chasles that made it, or make it again",
                    name, version, kVersion));
  }
  const std::string_view body = bytes.substr(kHeader);
  if (body.size() != size) {
    throw InputError(fmt::format("{}: a damaged map: found {} bytes, expected {}; copy it again",
                                 name, bytes.size(), kHeader + size));
  }
  if (checksum(body) != sum) {
    throw InputError(name +
                     ": a damaged map: its checksum is wrong; copy it again, or make it again");
  }
  Cursor in(body, name);
  LandmarkMap map;
  map.sessions.resize(in.get_count(4 + 16 + 4));
  for (MapSession& session : map.sessions) {
    session.name = in.get_text();
    session.begin = Time(in.get<std::int64_t>());
    session.end = Time(in.get<std::int64_t>());
    const std::size_t cameras = in.get_count(kCameraBytes);
    for (std::size_t i = 0; i < cameras; ++i) session.cameras.push_back(get_camera(in));
  }
  map.points.resize(in.get_count(kPointBytes + kViewBytes));
  std::vector<Eigen::Matrix3d> own(map.points.size());
  for (std::size_t i = 0; i < map.points.size(); ++i) {
    map.points[i] = get_point(map.sessions.size(), in, own[i]);
  }
  const std::size_t rank = in.get_count(3 * sizeof(float) * map.points.size());
  in.check(map.points.empty() ? rank == 0 : rank <= 3 * map.points.size(), "an impossible rank");
  Eigen::MatrixXf shared(3 * static_cast<Eigen::Index>(own.size()),
                         static_cast<Eigen::Index>(rank));
  in.get_all(shared);
  in.check_end();
  map.covariance = JointCovariance(std::move(own), shared.cast<double>());
  return map;
}

LandmarkMap read_map(const std::filesystem::path& file) {
  return parse_map(read_file(file), file.string());
}

}  // namespace chasles
