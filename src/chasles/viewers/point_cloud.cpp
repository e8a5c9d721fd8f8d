#include <stdexcept>
#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/point_cloud.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

// NumericType of foxglove.PackedElementField.
constexpr int kUint8 = 1, kFloat32 = 7;

}  // namespace

PointCloud::PointCloud(std::string frame, std::vector<std::string> more)
    : frame_(std::move(frame)), more_(std::move(more)) {}

void PointCloud::add(const CloudPoint& point) {
  if (point.more.size() != more_.size()) {
    throw std::invalid_argument("PointCloud::add: expected a value for each further field");
  }
  for (int k = 0; k < 3; ++k) append_little_endian(bytes_, static_cast<float>(point.p(k)));
  append_little_endian(bytes_, static_cast<float>(point.sigma));
  for (const std::uint8_t part : point.colour) append_little_endian(bytes_, part);
  append_little_endian(bytes_, std::uint8_t{255});
  for (const std::uint8_t value : point.more) append_little_endian(bytes_, value);
}

Json PointCloud::message(Time time) const {
  Json fields = Json::array();
  unsigned offset = 0;
  const auto field = [&](const std::string& name, int type, unsigned size) {
    fields.push_back({{"name", name}, {"offset", offset}, {"type", type}});
    offset += size;
  };
  for (const char* name : {"x", "y", "z", "sigma"}) field(name, kFloat32, 4);
  for (const char* name : {"red", "green", "blue", "alpha"}) field(name, kUint8, 1);
  for (const std::string& name : more_) field(name, kUint8, 1);
  return {{"timestamp", proto_time(time)},
          {"frame_id", frame_},
          {"pose", proto_pose({})},
          {"point_stride", offset},
          {"fields", fields},
          {"data", Json::binary({bytes_.begin(), bytes_.end()})}};
}

}  // namespace chasles
