#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <string>

#include "messages.hpp"

namespace chasles::bridge {

/// The names of ROS 2 for DDS: /imu0 and imu0 are rt/imu0. Throws UsageError for a name that ROS 2
/// does not allow.
std::string dds_topic(const std::string& ros_topic);

/// How a topic is sent or received.
struct Delivery {
  bool reliable = false;
  int depth = 10;  ///< messages that may wait; one more, and the oldest is lost
  /// None is lost instead. A reader that has `depth` messages leaves the next ones to their
  /// writers, which must keep them until they are received.
  bool keep_all = false;
};

/// A participant in a DDS domain, for one thread; writers may be used by any thread. All functions
/// throw Error with what DDS says.
class Participant {
 public:
  /// `configuration`: XML of Cyclone DDS; empty: that of the environment (CYCLONEDDS_URI).
  Participant(int domain, const std::string& configuration);
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;
  ~Participant();

  dds_entity_t reader(const dds_topic_descriptor_t& type, const std::string& ros_topic,
                      const Delivery& delivery);
  dds_entity_t writer(const dds_topic_descriptor_t& type, const std::string& ros_topic,
                      const Delivery& delivery);

  /// Waits until a reader has a message, at most so long.
  void wait(double seconds);

 private:
  dds_entity_t topic(const dds_topic_descriptor_t& type, const std::string& ros_topic);

  dds_entity_t domain_ = 0, participant_ = 0, waitset_ = 0;
};

/// Messages of a topic.
template <typename Message>
class Reader {
 public:
  Reader(Participant& participant, const std::string& ros_topic, const Delivery& delivery)
      : reader_(participant.reader(TopicType<Message>::descriptor(), ros_topic, delivery)) {}

  /// Takes the oldest messages that are there, kAtOnce at most, and returns their number. They are
  /// valid during the call. It returns however fast they come.
  template <typename Each>
  std::size_t take(const Each& each) const {
    std::array<void*, kAtOnce> messages{};
    std::array<dds_sample_info_t, kAtOnce> infos;
    const Loan loan(reader_, messages,
                    dds_take(reader_, messages.data(), infos.data(), kAtOnce,
                             static_cast<std::uint32_t>(kAtOnce)));
    for (std::size_t i = 0; i < loan.size(); ++i) {
      if (infos[i].valid_data) each(*static_cast<const Message*>(messages[i]));
    }  // else a writer has gone
    return loan.size();
  }

  dds_entity_t entity() const { return reader_; }

 private:
  static constexpr std::size_t kAtOnce = 32;

  // What dds_take() lends.
  class Loan {
   public:
    Loan(dds_entity_t reader, std::array<void*, kAtOnce>& messages, dds_return_t size)
        : reader_(reader), messages_(messages), size_(size > 0 ? size : 0) {}
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan() {
      if (size_ > 0) dds_return_loan(reader_, messages_.data(), size_);
    }
    std::size_t size() const { return static_cast<std::size_t>(size_); }

   private:
    dds_entity_t reader_;
    std::array<void*, kAtOnce>& messages_;
    dds_return_t size_;
  };

  dds_entity_t reader_;
};

/// Throws Error for a result of DDS that is one.
dds_return_t checked(dds_return_t result, const std::string& what);

template <typename Message>
class Writer {
 public:
  Writer(Participant& participant, const std::string& ros_topic, const Delivery& delivery)
      : writer_(participant.writer(TopicType<Message>::descriptor(), ros_topic, delivery)) {}

  /// A message for which a slow subscriber leaves no room is dropped: SLAM does not wait for it.
  void write(const Message& message) {
    const dds_return_t result = dds_write(writer_, &message);
    if (result == DDS_RETCODE_TIMEOUT) {
      ++dropped_;
    } else {
      checked(result, "a message cannot be sent");
    }
  }
  std::size_t dropped() const { return dropped_; }

 private:
  dds_entity_t writer_;
  std::atomic<std::size_t> dropped_ = 0;
};

}  // namespace chasles::bridge
