#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <chasles/live/feed.hpp>
#include <chasles/live/gate.hpp>

namespace chasles {

struct LiveServerOptions {
  std::string address = "127.0.0.1";  ///< numeric
  std::uint16_t port = 0;             ///< 0: one that is free
  /// Connections at once; one more is told 503.
  std::size_t connections = 64;
  /// Bytes of a message from a viewer; a larger one closes its connection with code 1009.
  std::size_t message_bytes = 4096;
  /// Messages of a viewer in all; one more closes its connection with code 1008.
  int messages = 64;
  std::chrono::milliseconds between_updates{100};  ///< to a viewer
  std::chrono::milliseconds handshake{10'000};     ///< for a request, and until a viewer joins
  std::chrono::milliseconds silence{60'000};       ///< that a viewer may keep; it is asked halfway
};

/// Serves one page and, over WebSocket, what a feed tells: on a thread of its own, which nobody
/// waits for and which stands back (its priority is low). GET / is the page, GET /live the socket
/// (docs/live.md has the protocol), and there is nothing else: no file is ever opened. An address
/// other than loopback gets a random token, which the URL carries. Where the feed throws, the
/// server ends and nothing else.
class LiveServer {
 public:
  /// Listens at once. The feed must outlive the server. Throws UsageError where the address is none
  /// or the port is taken.
  LiveServer(const LiveServerOptions& options, std::string page, LiveFeed& feed);
  ~LiveServer();  ///< close() without patience

  const Gate& gate() const;

  /// Tells each viewer what it does not have yet, for at most that long, says goodbye and ends.
  void close(std::chrono::milliseconds patience);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace chasles
