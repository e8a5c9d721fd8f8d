#include <chrono>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chasles/base/error.hpp>
#include <chasles/live/server_testing.hpp>

// Requests and messages that the live server rejects.
namespace chasles {
namespace {

using namespace std::chrono_literals;
using test::Client;
using test::comes_true;
using test::Counter;
using test::get;
using test::kUpgrade;
using test::Served;
using test::status_of;
using test::viewer;
using Clock = std::chrono::steady_clock;

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
  const std::string host = fmt::format("Host: 127.0.0.1:{}\r\n", served.port);
  for (const std::string& second : {host, std::string("hOST: evil.example\r\n")}) {
    EXPECT_EQ(status_of(served.port, get(served.port, "/", second)), "HTTP/1.1 403 Forbidden");
  }
  EXPECT_EQ(status_of(served.port, get(served.port, "/live", upgrade + origin(own) + origin(own))),
            "HTTP/1.1 403 Forbidden");
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

TEST(LiveServer, RejectsAnAddressThatIsNoneAndAPortThatIsTaken) {
  Served served;
  Counter feed;
  LiveServerOptions options;
  options.port = served.port;
  EXPECT_THROW(LiveServer(options, "", feed), UsageError);
  options.address = "localhost or so";
  EXPECT_THROW(LiveServer(options, "", feed), UsageError);
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
  // A message of the largest size is accepted.
  EXPECT_EQ(code_after(std::string(4096, ' '), 1), 1008);
}

/// The bytes of a frame of RFC 6455, of at most 125 bytes or of 126 to 65535.
std::string frame_bytes(int first_byte, const std::string& text, bool masked = true) {
  std::string out(1, static_cast<char>(first_byte));
  const int mask = masked ? 0x80 : 0;
  if (text.size() < 126) {
    out += static_cast<char>(mask | static_cast<int>(text.size()));
  } else {
    out += static_cast<char>(mask | 126);
    out += static_cast<char>(text.size() >> 8);
    out += static_cast<char>(text.size() & 0xff);
  }
  return out + (masked ? std::string(4, '\0') : "") + text;
}

TEST(LiveServer, FramesThatAreNotOfTheProtocolCloseTheConnection) {
  Served served;
  const auto code_after = [&](const std::string& bytes) {
    Client client = viewer(served.port);
    client.send(bytes);
    while (const auto frame = client.frame()) {
      if (frame->opcode == 8) return frame->close_code();
    }
    return 0;
  };
  const std::string stop = R"({"stop": true})", half(2500, ' ');
  EXPECT_EQ(code_after(frame_bytes(0x82, stop)), 1008) << "binary";
  EXPECT_EQ(code_after(frame_bytes(0x81, stop, false)), 1002) << "not masked, as no browser does";
  EXPECT_EQ(code_after(frame_bytes(0x83, stop)), 1002) << "an opcode that is none";
  EXPECT_EQ(code_after(frame_bytes(0x01, half) + frame_bytes(0x80, half)), 1009)
      << "the pieces of a message count together";
  EXPECT_EQ(code_after(std::string("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10) + "mask"), 1009)
      << "a length that is only claimed";
  EXPECT_EQ(served.feed.stops, 0);
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
  // A viewer that does not answer pings is dropped as well.
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

TEST(LiveServer, AThousandConnectionsAreServedOrRejected) {
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
  int served_too = 0, rejected = 0, closed = 0;
  for (Client& client : crowd) {
    const std::string head = client.answer_head();
    served_too += head.starts_with("HTTP/1.1 101 ");
    rejected += head.starts_with("HTTP/1.1 503 ");
    closed += head.empty();
  }
  EXPECT_EQ(served_too, 63);
  EXPECT_EQ(served_too + rejected + closed, 1000);
  EXPECT_GT(rejected, 0);
  // Existing viewers are not affected, and new ones are accepted after the others have gone.
  served.feed.value = 2;
  EXPECT_EQ(first.frame()->text, "2");
  crowd.clear();
  EXPECT_TRUE(comes_true([&] {
    Client late = viewer(served.port);
    const auto frame = late.frame();
    return frame && frame->text == "2";
  }));
}

}  // namespace
}  // namespace chasles
