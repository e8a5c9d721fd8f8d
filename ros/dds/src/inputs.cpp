#include "inputs.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>

#include "options.hpp"

namespace chasles::bridge {
namespace {

constexpr int kSamplesKept = 2000, kImagesKept = 10;
constexpr std::size_t kMostWarnings = 20;

bool is_compressed(const std::string& topic) { return topic.ends_with("/compressed"); }

// As rmw makes a stamp: sec may be negative, nanosec is not.
Time time_of(const builtin_interfaces_msg_dds__Time_& stamp) {
  return std::chrono::seconds(stamp.sec) + std::chrono::nanoseconds(stamp.nanosec);
}

std::string_view view(const dds_sequence_octet& bytes) {
  return {reinterpret_cast<const char*>(bytes._buffer), bytes._length};
}

GrayImage decoded(ImageDecoder& decoder, const ImageMessage& message) {
  return decoder.decode(RosImage{.height = message.height,
                                 .width = message.width,
                                 .encoding = message.encoding,
                                 .big_endian = message.is_bigendian != 0,
                                 .step = message.step,
                                 .data = view(message.data)});
}
GrayImage decoded(ImageDecoder& decoder, const CompressedImageMessage& message) {
  return decoder.decode(view(message.data));
}

std::uint32_t publishers_of(dds_entity_t reader) {
  dds_subscription_matched_status_t matched{};
  dds_get_subscription_matched_status(reader, &matched);
  return matched.current_count;
}

Eigen::Vector3d vector(const geometry_msgs_msg_dds__Vector3_& v) { return {v.x, v.y, v.z}; }

std::string ros_type(const dds_topic_descriptor_t& type) {
  std::string name = type.m_typename;
  for (std::size_t at; (at = name.find("::")) != std::string::npos;) name.replace(at, 2, "/");
  if (const std::size_t at = name.find("dds_/"); at != std::string::npos) name.erase(at, 5);
  name.pop_back();
  return name;
}

}  // namespace

SensorTopics topics_of(const BridgeOptions& o, const SensorCalibration& calibration) {
  const std::size_t cameras = calibration.cameras.size();
  if (!o.cameras.empty() && o.cameras.size() != cameras) {
    throw UsageError(fmt::format(
        "--camera: found {} topics, expected {}: one for each camera of {}, in its order",
        o.cameras.size(), cameras, o.calibration.string()));
  }
  SensorTopics topics{.imu = o.imu.empty() ? calibration.imu_topic : o.imu,
                      .accelerometer = o.accelerometer,
                      .cameras = o.cameras};
  if (topics.imu.empty()) topics.imu = "/imu0";
  for (std::size_t c = topics.cameras.size(); c < cameras; ++c) {
    const bool known =
        c < calibration.camera_topics.size() && !calibration.camera_topics[c].empty();
    topics.cameras.push_back(known ? calibration.camera_topics[c]
                                   : fmt::format("/cam{}/image_raw", c));
  }
  std::vector<std::string> names{dds_topic(topics.imu)};
  if (!topics.accelerometer.empty()) names.push_back(dds_topic(topics.accelerometer));
  for (const std::string& topic : topics.cameras) names.push_back(dds_topic(topic));
  std::ranges::sort(names);
  if (const auto twice = std::ranges::adjacent_find(names); twice != names.end()) {
    throw UsageError(
        fmt::format("the topic {} is given twice, expected one for each sensor", twice->substr(2)));
  }
  return topics;
}

template <typename Message>
void Inputs::subscribe(Participant& participant, const std::string& topic, const Delivery& delivery,
                       std::function<void(Source&, const Message&)> take) {
  const Reader<Message> reader(participant, topic, delivery);
  sources_.push_back(std::make_unique<Source>());
  Source& source = *sources_.back();
  source.topic = topic;
  source.type = ros_type(TopicType<Message>::descriptor());
  source.reader = reader.entity();
  takes_.emplace_back([reader, &source, take = std::move(take)] {
    return reader.take([&](const Message& message) {
      ++source.messages;
      take(source, message);
    });
  });
}

Inputs::Inputs(Participant& participant, const BridgeOptions& options, const SensorTopics& topics,
               app::RobotSlam& slam, OnSample on_sample)
    : slam_(slam), on_sample_(std::move(on_sample)) {
  const auto delivery = [&](int depth) {
    return Delivery{.reliable = options.reliable, .depth = depth, .keep_all = options.reliable};
  };
  subscribe_to_imu(participant, topics, delivery(kSamplesKept));
  for (std::size_t c = 0; c < topics.cameras.size(); ++c) {
    const Camera& camera = slam.cameras()[c];
    decoders_.emplace_back(ImageSize{.width = camera.width, .height = camera.height},
                           options.image_bits, fmt::format("cam{} ({})", c, topics.cameras[c]));
    const auto take = [this, c](Source& source, const auto& message) {
      take_image(source, c, message);
    };
    if (is_compressed(topics.cameras[c])) {
      subscribe<CompressedImageMessage>(participant, topics.cameras[c], delivery(kImagesKept),
                                        take);
    } else {
      subscribe<ImageMessage>(participant, topics.cameras[c], delivery(kImagesKept), take);
    }
  }
}

void Inputs::subscribe_to_imu(Participant& participant, const SensorTopics& topics,
                              const Delivery& delivery) {
  if (topics.accelerometer.empty()) {
    return subscribe<ImuMessage>(
        participant, topics.imu, delivery,
        [this](Source& source, const ImuMessage& message) { take_sample(source, message); });
  }
  const auto take = [this](Source& source, const ImuMessage& message, const auto& value_of,
                           const auto& add) {
    const Time time = time_of(message.header.stamp);
    if (!source.stamps.is_set(time, source.topic)) return;
    for (const Time joined : add(AxesSample{.time = time, .value = value_of(message)})) {
      note_sample(joined);
    }
  };
  subscribe<ImuMessage>(
      participant, topics.imu, delivery, [this, take](Source& source, const ImuMessage& message) {
        take(
            source, message, [](const ImuMessage& m) { return vector(m.angular_velocity); },
            [this](const AxesSample& rate) { return slam_.add_rate(rate); });
      });
  subscribe<ImuMessage>(participant, topics.accelerometer, delivery,
                        [this, take](Source& source, const ImuMessage& message) {
                          take(
                              source, message,
                              [](const ImuMessage& m) { return vector(m.linear_acceleration); },
                              [this](const AxesSample& force) { return slam_.add_force(force); });
                        });
}

std::size_t Inputs::take() {
  std::size_t taken = 0;
  for (const auto& take : takes_) taken += take();
  return taken;
}

void Inputs::take_sample(Source& source, const ImuMessage& message) {
  const Time time = time_of(message.header.stamp);
  if (!source.stamps.is_set(time, source.topic)) return;
  ImuSample sample{.time = time};
  sample.specific_force_imu = vector(message.linear_acceleration);
  sample.angular_rate_imu = vector(message.angular_velocity);
  slam_.add(sample);
  note_sample(time);
}

void Inputs::note_sample(Time time) {
  if (last_sample_ && time > *last_sample_) on_sample_(time, to_seconds(time - *last_sample_));
  last_sample_ = time;
}

// The first image shows whether topic and calibration belong together; later ones may be damaged,
// and end no run that goes on without them.
template <typename Message>
void Inputs::take_image(Source& source, std::size_t camera, const Message& message) {
  const auto arrived = app::RobotSlam::Clock::now();
  const Time time = time_of(message.header.stamp);
  if (!source.stamps.is_set(time, source.topic)) return;
  GrayImage image;
  try {
    image = decoded(decoders_[camera], message);
  } catch (const InputError& error) {
    if (source.messages == 1 && !slam_.has_estimate()) throw;
    if (++source.damaged <= kMostWarnings) spdlog::warn("{}", error.what());
    if (source.damaged == kMostWarnings) spdlog::warn("further damaged images are only counted");
  }
  slam_.add(camera, time, std::move(image), arrived);
}

void Inputs::describe(app::RobotDiagnosis& diagnosis) {
  using enum app::RobotDiagnosis::Level;
  for (const auto& source : sources_) {
    const auto add = [&](const char* what, const auto number) {
      diagnosis.value(what + source->topic, number);
    };
    const std::size_t unset = source->stamps.unset();
    diagnosis.add(source->damaged > std::exchange(source->reported_damaged, source->damaged),
                  kWarning, "images on " + source->topic + " could not be decoded: see the log");
    diagnosis.add(unset > std::exchange(source->reported_unset, unset), kWarning,
                  "messages on " + source->topic + " have a header.stamp of 0");
    add("publishers of ", publishers_of(source->reader));
    if (unset > 0) add("stamps of 0 on ", unset);
    if (source->damaged > 0) add("damaged on ", source->damaged);
  }
}

void Inputs::warn_of_silence() {
  for (const auto& source : sources_) {
    if (source->messages > 0 || source->warned) continue;
    source->warned = true;
    dds_requested_incompatible_qos_status_t rejected{};
    dds_get_requested_incompatible_qos_status(source->reader, &rejected);
    spdlog::warn("no message on {} ({}): {} publishers are there{}", source->topic, source->type,
                 publishers_of(source->reader),
                 rejected.total_count > 0
                     ? fmt::format(", and {} more that are not reliable (--reliable asks for that)",
                                   rejected.total_count)
                     : ", check the topic, the domain and the network");
  }
}

}  // namespace chasles::bridge
