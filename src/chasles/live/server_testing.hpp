#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include <fmt/format.h>

#include <chasles/live/server.hpp>
#include <chasles/live/testing.hpp>

/// Shared by the tests of the live server: a server of a number.
namespace chasles::test {

/// A rising number; a viewer receives the latest value, in a text of a given length.
class Counter final : public LiveFeed {
 public:
  explicit Counter(std::size_t length = 0) : padding_(length, '.') {}
  void refresh(std::size_t viewers) override {
    shown_ = value.load();
    most_viewers = std::max(most_viewers.load(), viewers);
  }
  LiveText next(LiveCursor& cursor) override {
    if (cursor.rows >= shown_) return nullptr;
    cursor.rows = shown_;
    ++texts;
    return std::make_shared<const std::string>(fmt::format("{}{}", shown_, padding_));
  }
  void stop() override { ++stops; }

  std::atomic<std::size_t> value = 1, most_viewers = 0, texts = 0;
  std::atomic<int> stops = 0;

 private:
  std::size_t shown_ = 0;
  std::string padding_;
};

struct Served {
  explicit Served(LiveServerOptions options = quick(), std::size_t length = 0)
      : feed(length), server(options, "<p>the page</p>", feed), port(server.gate().port) {}
  static LiveServerOptions quick() {
    LiveServerOptions options;
    options.between_updates = std::chrono::milliseconds(10);
    return options;
  }

  Counter feed;
  LiveServer server;
  std::uint16_t port;
};

/// The first line of the answer to a request.
inline std::string status_of(std::uint16_t port, const std::string& request) {
  Client client(port);
  client.send(request);
  const std::string answer = client.rest();
  return answer.substr(0, answer.find('\r'));
}

/// Whether the condition becomes true within some seconds.
template <typename Condition>
bool comes_true(const Condition& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (std::chrono::steady_clock::now() < deadline) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

}  // namespace chasles::test
