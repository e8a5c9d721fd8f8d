#pragma once

#include <chrono>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>

// A peer of the bridge with another implementation of DDS, Fast DDS. It passes serialised messages
// on as they are, so that it needs no description of their types.
namespace chasles::test {

/// A topic as DDS names it: "rt/imu0", "sensor_msgs::msg::dds_::Imu_".
struct WireTopic {
  std::string name, type;
};

/// A participant over the loopback alone, which finds others of this machine without multicast.
class FastClient {
 public:
  explicit FastClient(int domain);
  FastClient(const FastClient&) = delete;
  FastClient& operator=(const FastClient&) = delete;
  ~FastClient();

  eprosima::fastdds::dds::Topic* topic(const WireTopic& topic);
  eprosima::fastdds::dds::DomainParticipant& participant() { return *participant_; }

 private:
  eprosima::fastdds::dds::DomainParticipant* participant_;
};

/// Sends messages of a topic: CDR with its four bytes of encapsulation.
class FastWriter {
 public:
  struct Options {
    bool reliable = true;
    int depth = 0;  ///< 0: all messages are kept until they are acknowledged
  };
  FastWriter(FastClient& client, const WireTopic& topic, Options options);
  void write(std::string bytes);
  int readers() const;
  /// Whether all reliable readers have all messages within this time.
  bool acknowledged(std::chrono::seconds within) const;

 private:
  eprosima::fastdds::dds::DataWriter* writer_;
};

/// Keeps the messages of a topic.
class FastReader : private eprosima::fastdds::dds::DataReaderListener {
 public:
  using Clock = std::chrono::steady_clock;
  struct Message {
    std::string bytes;
    Clock::time_point came;
  };
  FastReader(FastClient& client, const WireTopic& topic, bool reliable);
  ~FastReader() override;
  std::vector<Message> messages() const;
  int writers() const;

 private:
  void on_data_available(eprosima::fastdds::dds::DataReader* reader) override;

  eprosima::fastdds::dds::DataReader* reader_;
  mutable std::mutex mutex_;
  std::vector<Message> messages_;
};

}  // namespace chasles::test
