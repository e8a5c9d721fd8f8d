#include "participant.hpp"

#include <cctype>
#include <memory>

#include <fmt/format.h>

#include <chasles/base/error.hpp>

namespace chasles::bridge {
namespace {

using Qos = std::unique_ptr<dds_qos_t, void (*)(dds_qos_t*)>;

// A reliable writer waits so long for a slow reader.
constexpr dds_duration_t kMostBlocking = DDS_MSECS(10);

Qos qos_of(const Delivery& delivery) {
  Qos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_reliability(qos.get(),
                       delivery.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       kMostBlocking);
  dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  dds_qset_history(qos.get(), delivery.keep_all ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST,
                   delivery.depth);
  if (delivery.keep_all) {
    dds_qset_resource_limits(qos.get(), delivery.depth, DDS_LENGTH_UNLIMITED, delivery.depth);
  }
  const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &plain);
  return qos;
}

bool is_name_part(const std::string& name, std::size_t i) {
  const auto c = static_cast<unsigned char>(name[i]);
  if (c == '/') return i == 0 || name[i - 1] != '/';
  const bool first = i == 0 || name[i - 1] == '/';
  return std::isalpha(c) != 0 || c == '_' || (std::isdigit(c) != 0 && !first);
}

}  // namespace

dds_return_t checked(dds_return_t result, const std::string& what) {
  if (result >= 0) return result;
  throw Error(ExitCode::kUsage, fmt::format("DDS: {}: {}", what, dds_strretcode(result)));
}

std::string dds_topic(const std::string& ros_topic) {
  bool valid = !ros_topic.empty() && ros_topic.back() != '/';
  for (std::size_t i = 0; i < ros_topic.size(); ++i) valid = valid && is_name_part(ros_topic, i);
  if (!valid) {
    throw UsageError(fmt::format(
        "the topic '{}' has a name that ROS 2 does not allow, expected letters, digits, _ and /, "
        "as in /cam0/image_raw",
        ros_topic));
  }
  return (ros_topic.front() == '/' ? "rt" : "rt/") + ros_topic;
}

Participant::Participant(int domain, const std::string& configuration) {
  const auto number = static_cast<dds_domainid_t>(domain);
  const std::string rejected = fmt::format(
      "the domain {} cannot be joined (is there such an interface? --network, CYCLONEDDS_URI)",
      domain);
  if (!configuration.empty()) {
    domain_ = checked(dds_create_domain(number, configuration.c_str()), rejected);
  }
  participant_ = checked(dds_create_participant(number, nullptr, nullptr), rejected);
  waitset_ = checked(dds_create_waitset(participant_), "no memory for a wait set");
}

Participant::~Participant() {
  dds_delete(participant_);
  if (domain_ > 0) dds_delete(domain_);
}

dds_entity_t Participant::topic(const dds_topic_descriptor_t& type, const std::string& ros_topic) {
  return checked(
      dds_create_topic(participant_, &type, dds_topic(ros_topic).c_str(), nullptr, nullptr),
      fmt::format("the topic {} cannot be used as {}: is it given twice, with two types?",
                  ros_topic, type.m_typename));
}

dds_entity_t Participant::reader(const dds_topic_descriptor_t& type, const std::string& ros_topic,
                                 const Delivery& delivery) {
  const dds_entity_t reader = checked(
      dds_create_reader(participant_, topic(type, ros_topic), qos_of(delivery).get(), nullptr),
      "no subscription to " + ros_topic);
  // Unlike a status, a condition holds until all messages have been taken.
  const dds_entity_t any = checked(dds_create_readcondition(reader, DDS_ANY_STATE), ros_topic);
  checked(dds_waitset_attach(waitset_, any, 0), ros_topic);
  return reader;
}

dds_entity_t Participant::writer(const dds_topic_descriptor_t& type, const std::string& ros_topic,
                                 const Delivery& delivery) {
  return checked(
      dds_create_writer(participant_, topic(type, ros_topic), qos_of(delivery).get(), nullptr),
      "no publication on " + ros_topic);
}

void Participant::wait(double seconds) {
  checked(dds_waitset_wait(waitset_, nullptr, 0, static_cast<dds_duration_t>(1e9 * seconds)),
          "waiting for messages");
}

}  // namespace chasles::bridge
