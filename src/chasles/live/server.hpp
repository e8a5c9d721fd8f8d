#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include <chasles/live/feed.hpp>
#include <chasles/live/gate.hpp>
#include <chasles/live/service.hpp>

namespace chasles {

struct LiveServerOptions {
  std::string name = "the live server";  ///< in errors
  std::string address = "127.0.0.1";     ///< numeric
  std::uint16_t port = 0;                ///< 0: any free port
  /// Simultaneous connections; further ones are answered with 503.
  std::size_t connections = 64;
  /// Largest message from a viewer [bytes]; a larger one closes the connection with code 1009.
  std::size_t message_bytes = 4096;
  /// Total number of messages from a viewer; one more closes the connection with code 1008.
  int messages = 64;
  std::chrono::milliseconds between_updates{100};  ///< minimum time between updates
  std::chrono::milliseconds handshake{10'000};     ///< time limit for a request, and for "join"
  std::chrono::milliseconds silence{
      60'000};  ///< time without an answer until the viewer is dropped; pinged at half of it
};

/// Serves a service over HTTP and WebSocket. The server has its own thread with low priority, and
/// nothing waits for it. It opens no file. An address other than loopback gets a random token. If
/// the service throws, only the server ends.
class LiveServer {
 public:
  /// Starts listening immediately. The service must outlive the server. Throws UsageError if the
  /// address is invalid or the port is taken.
  LiveServer(const LiveServerOptions& options, LiveService& service);
  /// The same with a PageService. The feed must outlive the server.
  LiveServer(const LiveServerOptions& options, std::string page, LiveFeed& feed);
  ~LiveServer();  ///< close() without waiting

  const Gate& gate() const;

  /// Sends each viewer the remaining updates, for at most `patience`, closes the connections and
  /// ends.
  void close(std::chrono::milliseconds patience);

 private:
  class Impl;
  static std::unique_ptr<Impl> started(const LiveServerOptions& options, LiveService& service);
  std::unique_ptr<LiveService> page_;  ///< if it is the server's own; outlives the server's thread
  std::unique_ptr<Impl> impl_;
};

}  // namespace chasles
