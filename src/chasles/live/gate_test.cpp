#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include <chasles/live/gate.hpp>

namespace chasles {
namespace {

const Gate kHere{.address = "127.0.0.1", .port = 8080, .token = ""};
const Gate kOutside{.address = "0.0.0.0", .port = 8080, .token = "0123abcd"};

Answer asked(const Gate& gate, std::string_view host, std::string_view target = "/") {
  return decide(gate,
                {.method = "GET", .target = target, .host = host, .origin = "", .upgrade = false});
}

Answer upgraded(const Gate& gate, std::string_view host, std::string_view origin,
                std::string_view target = "/live") {
  return decide(
      gate, {.method = "GET", .target = target, .host = host, .origin = origin, .upgrade = true});
}

TEST(Gate, KnowsOnlyThePageAndTheSocket) {
  EXPECT_EQ(asked(kHere, "127.0.0.1:8080"), Answer::kPage);
  EXPECT_EQ(asked(kHere, "127.0.0.1:8080", "/?whatever=1"), Answer::kPage);
  for (const char* target :
       {"/live", "/../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/index.html", "", "*",
        "http://127.0.0.1:8080/", "/%00", "/summary.json", "/live/"}) {
    EXPECT_EQ(asked(kHere, "127.0.0.1:8080", target), Answer::kNotFound) << target;
    if (std::string_view(target) == "/live") continue;
    EXPECT_EQ(upgraded(kHere, "127.0.0.1:8080", "", target), Answer::kNotFound) << target;
  }
  EXPECT_EQ(decide(kHere, {.method = "POST",
                           .target = "/",
                           .host = "127.0.0.1:8080",
                           .origin = "",
                           .upgrade = false}),
            Answer::kNotFound);
}

TEST(Gate, ASecondHostOrOriginIsForbidden) {
  Request request{.method = "GET", .target = "/", .host = "127.0.0.1:8080", .origin = ""};
  EXPECT_EQ(decide(kHere, request), Answer::kPage);
  request.repeated = true;
  EXPECT_EQ(decide(kHere, request), Answer::kForbidden);
}

TEST(Gate, OnLoopbackTheHostIsLoopbackByName) {
  for (const char* host : {"localhost:8080", "127.0.0.1:8080", "[::1]:8080"}) {
    EXPECT_EQ(asked(kHere, host), Answer::kPage) << host;
  }
  for (const char* host : {"", "localhost", "localhost:80", "evil.example:8080", "127.0.0.1",
                           "127.0.0.1.evil.example:8080", "192.168.1.2:8080", "localhost:18080"}) {
    EXPECT_EQ(asked(kHere, host), Answer::kForbidden) << host;
  }
  const Gate plain{.address = "127.0.0.1", .port = 80, .token = ""};
  EXPECT_EQ(asked(plain, "localhost"), Answer::kPage);
  EXPECT_EQ(asked(plain, "evil.example"), Answer::kForbidden);
}

TEST(Gate, ElsewhereTheHostIsANumberAndTheTokenIsAskedFor) {
  const std::string right = "/?token=0123abcd";
  for (const char* host : {"192.168.1.2:8080", "[fe80::1]:8080", "localhost:8080"}) {
    EXPECT_EQ(asked(kOutside, host, right), Answer::kPage) << host;
    EXPECT_EQ(asked(kOutside, host, "/?a=b&token=0123abcd&c"), Answer::kPage) << host;
    for (const char* wrong : {"/", "/?token=", "/?token=0123abce", "/?token=0123abcd0",
                              "/?token=0123abc", "/?notoken=0123abcd", "/?x=token=0123abcd"}) {
      EXPECT_EQ(asked(kOutside, host, wrong), Answer::kForbidden) << host << wrong;
    }
    EXPECT_EQ(upgraded(kOutside, host, ""), Answer::kForbidden) << host;
    EXPECT_EQ(upgraded(kOutside, host, "", "/live?token=0123abcd"), Answer::kSocket) << host;
  }
  for (const char* host : {"evil.example:8080", "1.2.3:8080", "[evil]:8080", "192.168.1.2"}) {
    EXPECT_EQ(asked(kOutside, host, right), Answer::kForbidden) << host;
  }
}

TEST(Gate, AnOriginHasToBeTheHost) {
  EXPECT_EQ(upgraded(kHere, "localhost:8080", "http://localhost:8080"), Answer::kSocket);
  EXPECT_EQ(upgraded(kHere, "localhost:8080", ""), Answer::kSocket);
  for (const char* origin : {"http://evil.example", "null", "https://localhost:8080", "file://",
                             "http://localhost:8081", "http://127.0.0.1:8080", "localhost:8080"}) {
    EXPECT_EQ(upgraded(kHere, "localhost:8080", origin), Answer::kForbidden) << origin;
  }
}

TEST(Gate, TokensDifferAndAreCompared) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(random_token());
  EXPECT_EQ(tokens.size(), 100U);
  EXPECT_EQ(tokens.begin()->size(), 32U);
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* other : {"abd", "ab", "abcd", "", "Abc"})
    EXPECT_FALSE(same_secret("abc", other));
}

TEST(Gate, UrlsCarryTheTokenAndBracketVersionSix) {
  const auto only = [](const std::string& url) { return std::vector<std::string>{url}; };
  EXPECT_EQ(urls(kHere), only("http://127.0.0.1:8080/"));
  EXPECT_EQ(urls({.address = "::1", .port = 1, .token = ""}), only("http://[::1]:1/"));
  const auto all = urls(kOutside);
  EXPECT_NE(std::ranges::find(all, "http://127.0.0.1:8080/?token=0123abcd"), all.end());
  EXPECT_TRUE(is_loopback("127.3.2.1") && is_loopback("::1"));
  for (const char* other : {"0.0.0.0", "::", "127.evil", "128.0.0.1"})
    EXPECT_FALSE(is_loopback(other));
}

}  // namespace
}  // namespace chasles
