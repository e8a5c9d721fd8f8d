#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/bags/bag_topics.hpp>
#include <chasles/bags/sensor_times.hpp>
#include <chasles/codec/parse.hpp>

namespace chasles {
namespace {

// Of the SDK's own text; of its older recordings; the device's counter, which it may add.
constexpr std::array<std::string_view, 3> kTimeKeys{"timestamp", "frame_timestamp",
                                                    "Frame Timestamp"};
constexpr std::string_view kDomainKey = "timestamp_domain";

// A plain decimal; millionths are exact in all that the SDK writes.
bool parse_decimal(std::string_view text, SensorTime& time) {
  const std::size_t point = std::min(text.find('.'), text.size());
  const char* end = text.data() + point;
  const auto whole = std::from_chars(text.data(), end, time.whole);
  if (whole.ec != std::errc() || whole.ptr != end || time.whole < 0) return false;
  std::string part(text.substr(std::min(point + 1, text.size())));
  part.resize(6, '0');
  const char* last = part.data() + part.size();
  const auto millionths = std::from_chars(part.data(), last, time.millionths);
  return millionths.ec == std::errc() && millionths.ptr == last && time.millionths >= 0;
}

// /camera/image/metadata for /camera/image/data and /camera/image/data/compressed.
std::string metadata_name(const std::string& topic) {
  const std::string raw = raw_topic(topic);
  const std::size_t slash = raw.rfind('/');
  return (slash == std::string::npos ? "" : raw.substr(0, slash)) + "/metadata";
}

/// The times of one topic of samples or images whose stamps are times of recording.
struct SensorClock {
  TopicContents* topic = nullptr;
  std::vector<SensorTime> times;  // in order of recording
  std::int64_t unit = 0;          // [ns]
  std::size_t found = 0, rows = 0;
  Time least = Time::max(), most = Time::min();  // from the sensor's time to that of recording
};

const SensorTime* find_time(const std::vector<SensorTime>& times, Time recorded) {
  const auto found =
      std::lower_bound(times.begin(), times.end(), recorded,
                       [](const SensorTime& time, Time wanted) { return time.recorded < wanted; });
  return found != times.end() && found->recorded == recorded ? &*found : nullptr;
}

template <typename Visit>
void for_each_stamp(const TopicContents& topic, const Visit& visit) {
  for (const ImuSample& sample : topic.imu) visit(sample.time);
  for (const BagImage& image : topic.images) visit(image.time);
}

// Keeps the times by one key and one clock, in order of recording.
void tidy_times(std::vector<SensorTime>& times, std::int16_t domain) {
  std::erase_if(times, [&](const SensorTime& time) { return time.domain != domain; });
  std::int16_t key = kTimeKeys.size();
  for (const SensorTime& time : times) key = std::min(key, time.key);
  std::erase_if(times, [&](const SensorTime& time) { return time.key != key; });
  std::stable_sort(times.begin(), times.end(), [](const SensorTime& a, const SensorTime& b) {
    return a.recorded < b.recorded;
  });
}

std::size_t count_found(const TopicContents& topic, const std::vector<SensorTime>& times) {
  std::size_t found = 0;
  for_each_stamp(topic, [&](Time stamp) { found += find_time(times, stamp) != nullptr ? 1 : 0; });
  return found;
}

// The unit of the times: that in which they last as long as the times of recording, or nearly so: a
// recording may be made of one that is played slowly. 0: none does.
std::int64_t unit_of_times(const std::vector<SensorTime>& times) {
  const auto [first, last] = std::minmax_element(
      times.begin(), times.end(),
      [](const SensorTime& a, const SensorTime& b) { return a.whole < b.whole; });
  if (first == times.end()) return 0;
  const double lasted = to_seconds(times.back().recorded - times.front().recorded);
  const double counted = static_cast<double>(last->whole - first->whole) +
                         1e-6 * static_cast<double>(last->millionths - first->millionths);
  constexpr double kMost = 30;  // two units differ by 1000
  for (const std::int64_t unit : {1'000'000'000, 1'000'000, 1'000, 1}) {
    const double ratio = 1e-9 * static_cast<double>(unit) * counted / lasted;
    if (ratio > 1 / kMost && ratio < kMost && last->whole < kLastNanosecond / unit) return unit;
  }
  return 0;
}

Time in_unit(const SensorTime& time, std::int64_t unit) {
  return Time(time.whole * unit + time.millionths * unit / 1'000'000);
}

template <typename Row>
void take_times(SensorClock& clock, std::vector<Row>& rows) {
  std::erase_if(rows, [&](const Row& row) { return find_time(clock.times, row.time) == nullptr; });
  for (Row& row : rows) {
    const Time time = in_unit(*find_time(clock.times, row.time), clock.unit);
    const Time late = row.time - time;
    clock.least = std::min(clock.least, late);
    clock.most = std::max(clock.most, late);
    row.time = time;
  }
}

std::vector<std::string> names_of(const std::vector<SensorClock>& clocks) {
  std::vector<std::string> names;
  for (const SensorClock& clock : clocks) names.push_back(clock.topic->topic.name);
  return names;
}

std::string taken_text(const std::vector<SensorClock>& clocks, const std::string& domain) {
  Time spread{};
  std::size_t left_out = 0, rows = 0;
  for (const SensorClock& clock : clocks) {
    spread = std::max(spread, clock.most - clock.least);
    left_out += clock.rows - clock.found;
    rows += clock.rows;
  }
  std::string text = fmt::format(
      "header.stamp of {} is the time of arrival: the times of the sensors on .../metadata ({}) "
      "are "
      "taken; the times from sensor to arrival differ by up to {:.1f} ms",
      fmt::join(names_of(clocks), ", "), domain, 1e3 * to_seconds(spread));
  if (left_out == 0) return text;
  return text + fmt::format("; {} of {} messages have no such time: left out", left_out, rows);
}

std::string rejected_text(const std::vector<SensorClock>& clocks, const std::string& why) {
  return fmt::format(
      "header.stamp of {} is the time of arrival, which jitters: the times of the sensors on "
      ".../metadata are not taken, because {}; record with one clock (Global Time)",
      fmt::join(names_of(clocks), ", "), why);
}

}  // namespace

bool is_sensor_metadata(const BagTopic& topic) {
  return topic.wire != Wire::kOther && topic.name.ends_with("/metadata") &&
         (topic.type == "std_msgs/String" || topic.type == "diagnostic_msgs/KeyValue");
}

std::int16_t SensorTimes::domain_of(std::string_view name) {
  constexpr std::size_t kMostDomains = 100, kLongestName = 100;
  name = name.substr(0, kLongestName);
  const auto known = std::find(domains_.begin(), domains_.end(), name);
  if (known != domains_.end()) return static_cast<std::int16_t>(known - domains_.begin());
  if (domains_.size() == kMostDomains) return 0;
  domains_.emplace_back(name);
  return static_cast<std::int16_t>(domains_.size() - 1);
}

void SensorTimes::add_item(OfTopic& of, std::string_view key, std::string_view value,
                           Time recorded) {
  if (key == kDomainKey) of.domain = domain_of(value);
  const auto known = std::find(kTimeKeys.begin(), kTimeKeys.end(), key);
  SensorTime time{.recorded = recorded, .domain = of.domain};
  if (known == kTimeKeys.end() || !parse_decimal(value, time)) return;
  time.key = static_cast<std::int16_t>(known - kTimeKeys.begin());
  of.times.push_back(time);
}

void SensorTimes::add(const BagTopic& topic, const RosMessage& message, Time recorded) {
  OfTopic& of = of_topics_[topic.name];
  MessageFields fields(message.bytes, message.wire, message.where);
  std::string_view text = fields.text();
  if (topic.type == "diagnostic_msgs/KeyValue") {
    add_item(of, text, fields.text(), recorded);
    return;
  }
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(';'), text.size());
    const std::string_view item = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t equal = std::min(item.find('='), item.size());
    add_item(of, item.substr(0, equal), item.substr(std::min(equal + 1, item.size())), recorded);
  }
}

std::vector<SensorTimes::Candidate> SensorTimes::candidates(std::vector<TopicContents>& topics) {
  std::vector<Candidate> found;
  for (TopicContents& topic : topics) {
    const auto of = of_topics_.find(metadata_name(topic.topic.name));
    if (of == of_topics_.end() || of->second.times.empty()) continue;
    std::vector<SensorTime> times = of->second.times;
    tidy_times(times, times.back().domain);
    // Stamps that are no times of recording are those of the sensor already.
    const std::size_t rows = topic.imu.size() + topic.images.size();
    if (rows > 0 && 2 * count_found(topic, times) >= rows) {
      found.push_back({.topic = &topic, .times = &of->second.times});
    }
  }
  return found;
}

std::int16_t SensorTimes::most_frequent_domain(const std::vector<Candidate>& candidates) const {
  std::vector<std::size_t> counts(domains_.size());
  for (const Candidate& candidate : candidates) {
    for (const SensorTime& time : *candidate.times) {
      ++counts[static_cast<std::size_t>(time.domain)];
    }
  }
  return static_cast<std::int16_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

void SensorTimes::apply(std::vector<TopicContents>& topics, std::vector<std::string>& remarks) {
  const std::vector<Candidate> all = candidates(topics);
  if (all.empty()) return;
  const std::int16_t domain = most_frequent_domain(all);
  const auto name_of = [&](std::int16_t i) { return domains_[static_cast<std::size_t>(i)]; };
  std::vector<SensorClock> clocks;
  std::string why;
  for (const Candidate& candidate : all) {
    SensorClock clock{.topic = candidate.topic, .times = *candidate.times};
    tidy_times(clock.times, domain);
    clock.rows = clock.topic->imu.size() + clock.topic->images.size();
    clock.found = count_found(*clock.topic, clock.times);
    clock.unit = unit_of_times(clock.times);
    if (2 * clock.found < clock.rows) {
      why = fmt::format("those of {} are by another clock ({}) than those of other topics ({})",
                        clock.topic->topic.name, name_of(candidate.times->back().domain),
                        name_of(domain));
    } else if (clock.unit == 0) {
      why = fmt::format("those of {} do not rise as the times of arrival do",
                        clock.topic->topic.name);
    }
    clocks.push_back(std::move(clock));
  }
  if (!why.empty()) {
    remarks.push_back(rejected_text(clocks, why));
    return;
  }
  for (SensorClock& clock : clocks) {
    take_times(clock, clock.topic->imu);
    take_times(clock, clock.topic->images);
  }
  remarks.push_back(taken_text(clocks, name_of(domain)));
}

}  // namespace chasles
