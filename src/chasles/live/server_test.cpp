#include <atomic>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chasles/error.hpp>
#include <chasles/live/server.hpp>
#include <chasles/live/testing.hpp>

namespace chasles {
namespace {

using namespace std::chrono_literals;
using test::Client;
using test::get;
using test::kUpgrade;
using test::viewer;
using Clock = std::chrono::steady_clock;

/// A number that rises; a viewer is told the latest, in a text of some length.
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
    options.between_updates = 10ms;
    return options;
  }

  Counter feed;
  LiveServer server;
  std::uint16_t port;
};

std::string status_of(std::uint16_t port, const std::string& request) {
  Client client(port);
  client.send(request);
  const std::string answer = client.rest();
  return answer.substr(0, answer.find('\r'));
}

/// Whether that becomes true within some seconds.
template <typename Condition>
bool comes_true(const Condition& condition) {
  const auto deadline = Clock::now() + 10s;
  while (Clock::now() < deadline) {
    if (condition()) return true;
    std::this_thread::sleep_for(5ms);
  }
  return false;
}

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

TEST(LiveServer, ThereIsNothingElse) {
  Served served;
  for (const char* target : {"/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/live",
                             "/favicon.ico", "//", "/..", "/?/../etc/passwd#x", "/page.html"}) {
    const std::string status = status_of(served.port, get(served.port, target));
    const bool is_page = std::string_view(target).starts_with("/?");
    EXPECT_EQ(status, is_page ? "HTTP/1.1 200 OK" : "HTTP/1.1 404 Not Found") << target;
  }
  const std::string host = fmt::format("Host: 127.0.0.1:{}\r\n\r\n", served.port);
  EXPECT_EQ(status_of(served.port, "DELETE / HTTP/1.1\r\n" + host), "HTTP/1.1 404 Not Found");
  EXPECT_EQ(status_of(served.port, "\x16\x03\x01 what is this\r\n\r\n"),
            "HTTP/1.1 400 Bad Request");
  EXPECT_EQ(status_of(served.port, get(served.port, "/", "X: " + std::string(9000, 'x') + "\r\n")),
            "HTTP/1.1 400 Bad Request");
}

TEST(LiveServer, ForeignHostsAndOriginsAreForbidden) {
  Served served;
  const std::string upgrade(kUpgrade);
  const auto origin = [](const std::string& text) { return "Origin: " + text + "\r\n"; };
  const std::string own = fmt::format("http://127.0.0.1:{}", served.port);
  EXPECT_EQ(status_of(served.port, get(served.port, "/", "", "rebound.example")),
            "HTTP/1.1 403 Forbidden");
  for (const char* foreign : {"http://evil.example", "null", "http://127.0.0.1:1"}) {
    EXPECT_EQ(status_of(served.port, get(served.port, "/live", upgrade + origin(foreign))),
              "HTTP/1.1 403 Forbidden");
  }
  Client client(served.port);
  client.send(get(served.port, "/live", upgrade + origin(own)));
  EXPECT_TRUE(client.answer_head().starts_with("HTTP/1.1 101 "));
}

TEST(LiveServer, OtherAddressesNeedTheToken) {
  LiveServerOptions options = Served::quick();
  options.address = "0.0.0.0";
  Served served(options);
  const std::string token = served.server.gate().token;
  ASSERT_EQ(token.size(), 32U);
  EXPECT_NE(urls(served.server.gate()).front().find(token), std::string::npos);
  EXPECT_EQ(status_of(served.port, get(served.port, "/")), "HTTP/1.1 403 Forbidden");
  EXPECT_EQ(status_of(served.port, get(served.port, "/?token=" + std::string(32, '0'))),
            "HTTP/1.1 403 Forbidden");
  EXPECT_EQ(status_of(served.port, get(served.port, "/?token=" + token)), "HTTP/1.1 200 OK");
  EXPECT_EQ(status_of(served.port, get(served.port, "/live", kUpgrade)), "HTTP/1.1 403 Forbidden");
  Client client(served.port);
  client.send(get(served.port, "/live?token=" + token, kUpgrade));
  EXPECT_TRUE(client.answer_head().starts_with("HTTP/1.1 101 "));
}

TEST(LiveServer, RefusesAnAddressThatIsNoneAndAPortThatIsTaken) {
  Served served;
  Counter feed;
  LiveServerOptions options;
  options.port = served.port;
  EXPECT_THROW(LiveServer(options, "", feed), UsageError);
  options.address = "localhost or so";
  EXPECT_THROW(LiveServer(options, "", feed), UsageError);
}

TEST(LiveServer, AViewerIsToldTheLatestAndMayStopTheRun) {
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

TEST(LiveServer, LargeSenselessOrManyMessagesCloseTheConnection) {
  Served served;
  const auto code_after = [&](const std::string& text, int times) {
    Client client = viewer(served.port);
    for (int i = 0; i < times; ++i) client.say(text);
    while (const auto frame = client.frame()) {
      if (frame->opcode == 8) return frame->close_code();
    }
    return 0;
  };
  EXPECT_EQ(code_after(std::string(5000, ' '), 1), 1009);
  EXPECT_EQ(code_after(std::string(100'000, ' '), 1), 1009);
  EXPECT_EQ(code_after("what", 1), 1008);
  EXPECT_EQ(code_after(R"({"join": {}})", 100), 1008);
  // One that is as large as it may be is taken for what it says.
  EXPECT_EQ(code_after(std::string(4096, ' '), 1), 1008);
}

TEST(LiveServer, WhoeverSaysNothingIsPutOut) {
  LiveServerOptions options = Served::quick();
  options.handshake = 200ms;
  options.silence = 400ms;
  Served served(options);
  Client mute(served.port), slow(served.port);
  slow.send("GET / HTTP/1.1\r\nHo");
  const auto start = Clock::now();
  EXPECT_EQ(mute.rest(), "");
  EXPECT_EQ(slow.rest(), "");
  // A viewer that does not answer pings is gone, too.
  Client deaf = viewer(served.port);
  while (deaf.frame()) {
  }
  EXPECT_LT(Clock::now() - start, 4s);
}

TEST(LiveServer, WhoeverDoesNotJoinIsPutOut) {
  LiveServerOptions options = Served::quick();
  options.handshake = 200ms;
  Served served(options);
  Client client(served.port);
  client.send(get(served.port, "/live", kUpgrade));
  EXPECT_TRUE(client.answer_head().starts_with("HTTP/1.1 101 "));
  const auto frame = client.frame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->close_code(), 1008);
}

/// A feed with a fault.
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

TEST(LiveServer, AThousandConnectionsAreServedOrRefused) {
  rlimit files{};
  ::getrlimit(RLIMIT_NOFILE, &files);
  files.rlim_cur = std::min<rlim_t>(files.rlim_max, 4096);
  ::setrlimit(RLIMIT_NOFILE, &files);
  Served served;
  Client first = viewer(served.port);
  EXPECT_EQ(first.frame()->text, "1");
  std::vector<Client> crowd;
  for (int i = 0; i < 1000; ++i) {
    crowd.emplace_back(served.port);
    ASSERT_TRUE(crowd.back().connected()) << i;
    crowd.back().send(get(served.port, "/live", kUpgrade));
  }
  int served_too = 0, refused = 0, closed = 0;
  for (Client& client : crowd) {
    const std::string head = client.answer_head();
    served_too += head.starts_with("HTTP/1.1 101 ");
    refused += head.starts_with("HTTP/1.1 503 ");
    closed += head.empty();
  }
  EXPECT_EQ(served_too, 63);
  EXPECT_EQ(served_too + refused + closed, 1000);
  EXPECT_GT(refused, 0);
  // Who was there before them sees nothing of it, and there is room again when they have gone.
  served.feed.value = 2;
  EXPECT_EQ(first.frame()->text, "2");
  crowd.clear();
  EXPECT_TRUE(comes_true([&] {
    Client late = viewer(served.port);
    const auto frame = late.frame();
    return frame && frame->text == "2";
  }));
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
  // The slow one has one text on its way; what it is told next is the latest.
  std::vector<std::size_t> told;
  while (told.empty() || told.back() < 60) {
    const auto frame = slow.frame();
    ASSERT_TRUE(frame);
    told.push_back(std::stoul(frame->text));
  }
  EXPECT_LT(told.size(), 20U);
}

TEST(LiveServer, TheEndIsToldToWhoeverListensAndWaitsForNobodyElse) {
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
