#include "fast_client.hpp"

#include <cstring>
#include <stdexcept>

#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

namespace chasles::test {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

constexpr std::uint32_t kLargest = 1 << 22;  // bytes of a message
constexpr int kParticipants = 32;            // whose ports are looked at

template <typename Pointer>
Pointer made(Pointer pointer, const char* what) {
  if (pointer == nullptr) throw std::runtime_error(std::string("Fast DDS makes no ") + what);
  return pointer;
}

// Messages that are serialised already: a std::string with the encapsulation at its front.
class Serialised : public dds::TopicDataType {
 public:
  explicit Serialised(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kLargest;
    m_isGetKeyDefined = false;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
    const std::string& bytes = *static_cast<std::string*>(data);
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = bytes[1] == 0 ? CDR_BE : CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
    static_cast<std::string*>(data)->assign(reinterpret_cast<const char*>(payload->data),
                                            payload->length);
    return true;
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<std::string*>(data)->size()); };
  }
  void* createData() override { return new std::string; }
  void deleteData(void* data) override { delete static_cast<std::string*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

dds::DomainParticipantQos loopback_qos(int domain) {
  dds::DomainParticipantQos qos;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.emplace_back("127.0.0.1");
  udp->sendBufferSize = udp->receiveBufferSize = 1 << 22;
  qos.transport().use_builtin_transports = false;
  qos.transport().user_transports.push_back(udp);
  for (int i = 0; i < kParticipants; ++i) {
    rtps::Locator_t locator;
    rtps::IPLocator::setIPv4(locator, "127.0.0.1");
    // The ports of RTPS 2.x, section 9.6.1.
    locator.port = static_cast<std::uint32_t>(7400 + 250 * domain + 10 + 2 * i);
    qos.wire_protocol().builtin.initialPeersList.push_back(locator);
  }
  qos.wire_protocol().builtin.discovery_config.leaseDuration_announcementperiod = {1, 0};
  return qos;
}

}  // namespace

FastClient::FastClient(int domain)
    : participant_(made(dds::DomainParticipantFactory::get_instance()->create_participant(
                            static_cast<dds::DomainId_t>(domain), loopback_qos(domain)),
                        "participant")) {}

FastClient::~FastClient() {
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
}

dds::Topic* FastClient::topic(const WireTopic& topic) {
  dds::TypeSupport(new Serialised(topic.type)).register_type(participant_);
  return made(participant_->create_topic(topic.name, topic.type, dds::TOPIC_QOS_DEFAULT), "topic");
}

FastWriter::FastWriter(FastClient& client, const WireTopic& topic, Options options) {
  dds::DataWriterQos qos;
  qos.reliability().kind =
      options.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.history().kind = options.depth == 0 ? dds::KEEP_ALL_HISTORY_QOS : dds::KEEP_LAST_HISTORY_QOS;
  if (options.depth > 0) qos.history().depth = options.depth;
  qos.resource_limits().max_samples = 100000;
  qos.resource_limits().max_samples_per_instance = 100000;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  dds::Publisher* publisher =
      made(client.participant().create_publisher(dds::PUBLISHER_QOS_DEFAULT), "publisher");
  writer_ = made(publisher->create_datawriter(client.topic(topic), qos), "writer");
}

void FastWriter::write(std::string bytes) {
  if (!writer_->write(&bytes)) throw std::runtime_error("Fast DDS does not send a message");
}

int FastWriter::readers() const {
  dds::PublicationMatchedStatus status;
  writer_->get_publication_matched_status(status);
  return status.current_count;
}

bool FastWriter::acknowledged(std::chrono::seconds within) const {
  return writer_->wait_for_acknowledgments({static_cast<std::int32_t>(within.count()), 0}) ==
         ReturnCode_t::RETCODE_OK;
}

FastReader::FastReader(FastClient& client, const WireTopic& topic, bool reliable) {
  dds::DataReaderQos qos;
  qos.reliability().kind =
      reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
  qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
  qos.resource_limits().max_samples = 100000;
  qos.resource_limits().max_samples_per_instance = 100000;
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  dds::Subscriber* subscriber =
      made(client.participant().create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT), "subscriber");
  reader_ = made(subscriber->create_datareader(client.topic(topic), qos, this), "reader");
}

FastReader::~FastReader() { reader_->set_listener(nullptr); }

void FastReader::on_data_available(dds::DataReader* reader) {
  Message message;
  dds::SampleInfo info;
  while (reader->take_next_sample(&message.bytes, &info) == ReturnCode_t::RETCODE_OK) {
    if (!info.valid_data) continue;
    message.came = Clock::now();
    const std::lock_guard lock(mutex_);
    messages_.push_back(message);
  }
}

std::vector<FastReader::Message> FastReader::messages() const {
  const std::lock_guard lock(mutex_);
  return messages_;
}

int FastReader::writers() const {
  dds::SubscriptionMatchedStatus status;
  reader_->get_subscription_matched_status(status);
  return status.current_count;
}

}  // namespace chasles::test
