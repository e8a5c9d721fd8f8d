#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

/// What the tests of this folder share: a client that knows sockets and RFC 6455, and no library.
namespace chasles::test {

/// A TCP connection to 127.0.0.1; a wait for bytes ends after some seconds.
class Client {
 public:
  /// `room`: of what the other side may send before it is read [bytes]; 0: the system's choice.
  explicit Client(std::uint16_t port, int room = 0);
  Client(Client&& other) noexcept
      : socket_(other.socket_), unread_(std::move(other.unread_)), begun_(std::move(other.begun_)) {
    other.socket_ = -1;
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client();

  bool connected() const { return socket_ >= 0; }
  void send(std::string_view bytes);
  /// Everything until the other side closes, or the wait ends.
  std::string rest();
  /// The head of an answer, up to its empty line.
  std::string answer_head();

  /// A text frame, masked.
  void say(std::string_view text);
  struct Frame {
    int opcode = 0;  ///< 1: text, 8: close, 9: ping
    std::string text;
    int close_code() const;
  };
  /// The next message, put together, or the next control frame; none where the connection ended or
  /// nothing came.
  std::optional<Frame> frame();

 private:
  bool fill(std::size_t bytes);
  /// `end`: whether it is a message's last.
  std::optional<Frame> piece(bool& end);

  int socket_ = -1;
  std::string unread_;
  Frame begun_;
};

/// "GET TARGET HTTP/1.1" with a Host and more headers, each with its end of line.
std::string get(std::uint16_t port, std::string_view target, std::string_view more = "",
                std::string_view host = "");

/// The headers that ask for a WebSocket.
extern const std::string_view kUpgrade;

/// A viewer: the socket is open, and has said "join".
Client viewer(std::uint16_t port, int room = 0);

}  // namespace chasles::test
