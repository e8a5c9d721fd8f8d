#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/live/server_testing.hpp>

namespace chasles {
namespace {

using namespace std::chrono_literals;
using test::Client;
using test::comes_true;
using test::get;
using test::Served;
using test::viewer;
using Clock = std::chrono::steady_clock;

TEST(LiveServer, ServesThePageWithHeadersThatGuardIt) {
  Served served;
  Client client(served.port);
  client.send(get(served.port, "/"));
  const std::string head = client.answer_head();
  for (const char* line :
       {"HTTP/1.1 200 OK\r\n", "Content-Type: text/html; charset=utf-8\r\n",
        "Content-Length: 15\r\n", "Cache-Control: no-store\r\n", "Referrer-Policy: no-referrer\r\n",
        "X-Content-Type-Options: nosniff\r\n", "frame-ancestors 'none'\r\n"}) {
    EXPECT_NE(head.find(line), std::string::npos) << line << head;
  }
  EXPECT_EQ(client.rest(), "<p>the page</p>");
}

TEST(LiveServer, AViewerIsReportedTheLatestAndMayStopTheRun) {
  Served served;
  Client client = viewer(served.port);
  EXPECT_EQ(client.frame()->text, "1");
  served.feed.value = 7;
  EXPECT_EQ(client.frame()->text, "7");
  EXPECT_EQ(served.feed.stops, 0);
  client.say(R"({"stop": true})");
  EXPECT_TRUE(comes_true([&] { return served.feed.stops == 1; }));
  EXPECT_EQ(served.feed.most_viewers, 1U);
}

// Also one that is longer than the head of a request may be.
TEST(LiveServer, TakesMessagesUpToTheStatedSize) {
  LiveServerOptions options = Served::quick();
  options.message_bytes = 1 << 16;
  Served served(options);
  Client client = viewer(served.port);
  int sent = 0;
  for (const std::size_t size : {8191, 8192, 8193, 1 << 16}) {
    std::string stop = R"({"stop": true})";
    client.say(stop.append(size - stop.size(), ' '));
    ++sent;
    EXPECT_TRUE(comes_true([&] { return served.feed.stops == sent; })) << size;
  }
  client.say(std::string((1 << 16) + 1, ' '));
  int code = 0;
  while (const auto frame = client.frame()) {
    if (frame->opcode == 8) code = frame->close_code();
  }
  EXPECT_EQ(code, 1009);
}

/// A feed that throws.
class Faulty final : public LiveFeed {
 public:
  void refresh(std::size_t) override {}
  LiveText next(LiveCursor&) override { throw std::runtime_error("a fault"); }
  void stop() override {}
};

TEST(LiveServer, AFaultEndsTheServerAndNothingElse) {
  Faulty feed;
  LiveServer server({}, "", feed);
  const std::uint16_t port = server.gate().port;
  Client client = viewer(port);
  EXPECT_FALSE(client.frame());
  EXPECT_TRUE(comes_true([&] { return !Client(port).connected(); }));
  server.close(1s);
}

TEST(LiveServer, ASlowViewerLosesTextsAndNobodyElseDoes) {
  Served served(Served::quick(), 1 << 20);
  Client slow = viewer(served.port, 4096), quick = viewer(served.port);
  std::size_t seen = 0;
  for (std::size_t value = 2; value <= 60; ++value) {
    served.feed.value = value;
    while (seen < value) seen = std::stoul(quick.frame()->text);
  }
  EXPECT_EQ(seen, 60U);
  // The slow viewer has one text in transit; its next one is the latest.
  std::vector<std::size_t> received;
  while (received.empty() || received.back() < 60) {
    const auto frame = slow.frame();
    ASSERT_TRUE(frame);
    received.push_back(std::stoul(frame->text));
  }
  EXPECT_LT(received.size(), 20U);
}

TEST(LiveServer, TheEndIsReportedToWhoeverListensAndWaitsForNobodyElse) {
  const auto served = std::make_unique<Served>(Served::quick(), 1 << 22);
  Client quick = viewer(served->port), deaf = viewer(served->port, 4096);
  EXPECT_TRUE(quick.frame()->text.starts_with("1."));
  served->feed.value = 9;
  const auto start = Clock::now();
  std::thread close([&] { served->server.close(300ms); });
  EXPECT_TRUE(quick.frame()->text.starts_with("9."));
  EXPECT_EQ(quick.frame()->close_code(), 1001);
  close.join();
  EXPECT_LT(Clock::now() - start, 2s);
  EXPECT_FALSE(Client(served->port).connected());
}

}  // namespace
}  // namespace chasles
