#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include <chasles/live/gate.hpp>

namespace chasles {

/// A WebSocket message, which several viewers may share.
struct LiveMessage {
  std::shared_ptr<const std::string> bytes;  ///< null: none
  bool binary = false;                       ///< else text

  explicit operator bool() const { return bytes != nullptr; }
};

/// What a service sends to one viewer, and hears from it. Used on the server's thread only.
class LiveSession {
 public:
  LiveSession() = default;
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;
  virtual ~LiveSession() = default;

  /// Whether the viewer has said what it wants. One that does not in time is put out.
  virtual bool joined() const = 0;
  /// A message from the viewer. False if it is not allowed: the connection is closed with 1008.
  virtual bool take(std::string_view message, bool binary) = 0;
  /// The next message for the viewer; none if it has everything. It is called when the message
  /// before has been sent: nothing waits for a slow viewer.
  virtual LiveMessage next() = 0;
};

/// The answer to an HTTP request: a WebSocket, or a text. What the views refer to must outlive the
/// server.
struct HttpAnswer {
  bool socket = false;
  std::string_view subprotocol = {};  ///< of the socket; empty: none
  std::string_view status = "200 OK", type = "text/plain", body = {};
};

/// What a LiveServer serves. All functions are called on the server's thread.
class LiveService {
 public:
  LiveService() = default;
  LiveService(const LiveService&) = delete;
  LiveService& operator=(const LiveService&) = delete;
  virtual ~LiveService() = default;

  virtual HttpAnswer answer(const Gate& gate, const Request& request) const = 0;
  /// A viewer's socket has opened.
  virtual std::unique_ptr<LiveSession> open() = 0;
  /// Called periodically, before LiveSession::next(); `viewers` is the number of those who joined.
  virtual void refresh(std::size_t viewers) = 0;
};

}  // namespace chasles
