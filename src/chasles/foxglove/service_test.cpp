#include <chrono>
#include <memory>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/foxglove/testing.hpp>
#include <chasles/live/server.hpp>
#include <chasles/live/testing.hpp>

// The service behind a server, seen by a client of sockets.
namespace chasles {
namespace {

using namespace std::chrono_literals;
using test::Client;
using test::foxglove_start;
using test::get;
using test::kUpgrade;
using test::synthetic_drive;
using test::Watcher;

std::string upgrade(std::string_view protocols, std::string_view more = "") {
  return fmt::format("{}Sec-WebSocket-Protocol: {}\r\n{}", kUpgrade, protocols, more);
}

struct Served {
  Served() : service("chasles 0"), server(foxglove_server_options(0), service) {}

  FoxgloveService service;
  LiveServer server;
  std::uint16_t port = server.gate().port;
};

/// The head of the answer to a request for a socket.
std::string answer(const Served& served, std::string_view more, std::string_view target = "/",
                   std::string_view host = "") {
  Client client(served.port);
  client.send(get(served.port, target, more, host));
  return client.answer_head();
}

/// A client that is connected.
struct Connected {
  explicit Connected(const Served& served, int room = 0) : client(served.port, room) {
    client.send(get(served.port, "/", upgrade("foxglove.websocket.v1")));
    EXPECT_TRUE(client.answer_head().starts_with("HTTP/1.1 101 "));
  }

  /// Reads until the condition is true; the code with which the server closed, 0 if it did not.
  template <typename Condition>
  int until(const Condition& condition) {
    while (!condition()) {
      const auto frame = client.frame();
      if (!frame) return -1;
      if (frame->opcode == 8) return frame->close_code();
      if (frame->opcode <= 2) watcher.take(frame->text, frame->opcode == 2);
    }
    return 0;
  }
  int until_closed() {
    return until([] { return false; });
  }
  void subscribe(const std::vector<std::string>& topics) {
    EXPECT_EQ(until([&] { return watcher.channels.contains(topics.front()); }), 0);
    client.say(watcher.subscription(topics));
  }

  Client client;
  Watcher watcher;
};

TEST(FoxgloveService, TheHandshakeChoosesTheSubprotocol) {
  const Served served;
  EXPECT_EQ(foxglove_url(served.server.gate()), fmt::format("ws://127.0.0.1:{}", served.port));
  for (const auto& [offered, chosen] : std::vector<std::pair<std::string, std::string>>{
           {"foxglove.websocket.v1", "foxglove.websocket.v1"},
           {"foxglove.websocket.v1, foxglove.sdk.v1", "foxglove.sdk.v1"}}) {
    const std::string head = answer(served, upgrade(offered));
    EXPECT_TRUE(head.starts_with("HTTP/1.1 101 ")) << head;
    EXPECT_NE(head.find("Sec-WebSocket-Protocol: " + chosen), std::string::npos) << head;
  }
}

TEST(FoxgloveService, OtherRequestsAreAnsweredWithAnError) {
  const Served served;
  const auto status = [&](auto&&... request) {
    const std::string head = answer(served, request...);
    return head.substr(0, head.find('\r'));
  };
  const std::string wanted = upgrade("foxglove.websocket.v1");
  EXPECT_EQ(status(""), "HTTP/1.1 400 Bad Request") << "no WebSocket";
  EXPECT_EQ(status(kUpgrade), "HTTP/1.1 400 Bad Request") << "no subprotocol";
  EXPECT_EQ(status(upgrade("chat")), "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status(wanted, "/live"), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status(wanted, "/../etc/passwd"), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status(wanted, "/?x=1"), "HTTP/1.1 101 Switching Protocols");
  EXPECT_EQ(status(wanted, "/", "rebound.example"), "HTTP/1.1 403 Forbidden");
  EXPECT_EQ(status(wanted, "/", fmt::format("rebound.example:{}", served.port)),
            "HTTP/1.1 403 Forbidden");
  EXPECT_EQ(status(wanted, "/", fmt::format("localhost:{}", served.port)),
            "HTTP/1.1 101 Switching Protocols");
  for (const char* origin : {"https://app.foxglove.dev", "file://", "http://localhost:8080"}) {
    EXPECT_EQ(status(wanted + "Origin: " + origin + "\r\n"), "HTTP/1.1 101 Switching Protocols");
  }
  for (const char* origin : {"https://evil.example", "null"}) {
    EXPECT_EQ(status(wanted + "Origin: " + origin + "\r\n"), "HTTP/1.1 403 Forbidden");
  }
  EXPECT_EQ(status(wanted + "Origin: file://\r\nOrigin: file://\r\n"), "HTTP/1.1 403 Forbidden");
}

TEST(FoxgloveService, ARunArrivesAndItsEndIsReported) {
  const ReportRun drive = synthetic_drive({.states = 200, .landmarks = 50});
  const auto served = std::make_unique<Served>();
  served->service.begin(foxglove_start(drive));
  Connected seen(*served);
  seen.subscribe({"/pose", "/map", "/ways"});
  for (const RunState& state : drive.run.states) served->service.add(state);
  EXPECT_EQ(seen.until([&] { return seen.watcher.count("/pose") == 200; }), 0);
  served->service.finish(drive.run, drive.summary, false);
  std::thread close([&] { served->server.close(3s); });
  EXPECT_EQ(seen.until_closed(), 1001);
  close.join();
  EXPECT_EQ(seen.watcher.count("/pose"), 200u);
  EXPECT_EQ(seen.watcher.count("/map"), 1u);
  EXPECT_EQ(seen.watcher.statuses.back().at("message"),
            "the run is complete: 200 states, 50 landmarks");
}

TEST(FoxgloveService, AFailureIsReported) {
  Served served;
  Connected seen(served);
  served.service.fail("no start");
  EXPECT_EQ(seen.until([&] { return !seen.watcher.statuses.empty(); }), 0);
  EXPECT_EQ(seen.watcher.statuses[0].at("message"), "the run failed: no start");
  EXPECT_EQ(seen.watcher.statuses[0].at("level"), 2);
}

TEST(FoxgloveService, MapsAndFramesAreAskedForOnlyWhereAViewerIs) {
  const ReportRun drive = synthetic_drive({.states = 10, .landmarks = 5});
  Served served;
  served.service.begin(foxglove_start(drive, 1, true));
  int maps = 0;
  const auto make = [&] { return ++maps, LiveMap{.landmarks = drive.run.landmarks}; };
  std::this_thread::sleep_for(200ms);
  served.service.map(make);
  EXPECT_EQ(maps, 0);
  EXPECT_FALSE(served.service.claim_frame());
  Connected seen(served);
  seen.subscribe({"/cam0/image"});
  for (int tries = 0; tries < 1000 && !served.service.shows_frames(); ++tries) {
    std::this_thread::sleep_for(5ms);
  }
  for (int tries = 0; tries < 1000 && !served.service.claim_frame(); ++tries) {
    std::this_thread::sleep_for(5ms);
  }
  EXPECT_TRUE(served.service.shows_frames());
  served.service.map(make);
  served.service.map(make);
  EXPECT_EQ(maps, 1) << "at most one per second";
}

TEST(FoxgloveService, HostileClientsAreAnsweredOrClosedAndOthersGoOn) {
  const ReportRun drive = synthetic_drive({.states = 20, .landmarks = 5});
  Served served;
  served.service.begin(foxglove_start(drive));
  Connected good(served), rude(served), large(served), flood(served), claims(served);
  good.subscribe({"/pose"});
  rude.client.say("nonsense");
  rude.client.send(std::string("\x82\x83\x00\x00\x00\x00\x01\x02\x03", 9));  // binary, three bytes
  rude.client.say(R"({"op": "advertise", "channels": []})");
  EXPECT_EQ(rude.until([&] { return rude.watcher.statuses.size() == 3; }), 0);
  EXPECT_EQ(rude.watcher.statuses[2].at("message"),
            "'advertise' is not supported: this server only sends");
  large.client.say(std::string(70'000, ' '));
  EXPECT_EQ(large.until_closed(), 1009);
  for (int k = 0; k < 200; ++k) flood.client.say("nonsense");
  EXPECT_EQ(flood.until_closed(), 1008);
  claims.client.send(std::string("\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff\x00\x00\x00\x00", 14));
  EXPECT_EQ(claims.until_closed(), 1009) << "a length that is only claimed";
  rude.subscribe({"/pose"});
  for (const RunState& state : drive.run.states) served.service.add(state);
  for (Connected* client : {&good, &rude}) {
    EXPECT_EQ(client->until([&] { return client->watcher.count("/pose") == 20; }), 0);
  }
}

TEST(FoxgloveService, WhoeverDoesNotReadHoldsNothingUp) {
  const ReportRun drive = synthetic_drive({.states = 3000, .landmarks = 2000});
  const auto served = std::make_unique<Served>();
  served->service.begin(foxglove_start(drive));
  Connected deaf(*served, 4096), good(*served);
  deaf.subscribe({"/state", "/odometry", "/map", "/map/ellipsoids"});
  good.subscribe({"/pose"});
  const auto start = std::chrono::steady_clock::now();
  for (const RunState& state : drive.run.states) served->service.add(state);
  served->service.finish(drive.run, drive.summary, false);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);
  EXPECT_EQ(good.until([&] { return good.watcher.count("/pose") == StateChannel::kMostBehind; }),
            0);
  served->server.close(100ms);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 10s);
}

}  // namespace
}  // namespace chasles
