#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

/// Shared by the tests of this folder: a client based on sockets and RFC 6455, without a library.
namespace chasles::test {

/// A TCP connection to 127.0.0.1; waiting for bytes ends after some seconds.
class Client {
 public:
  /// `room`: size of the receive buffer [bytes]; 0: the system's default.
  explicit Client(std::uint16_t port, int room = 0);
  Client(Client&& other) noexcept
      : socket_(other.socket_),
        unread_(std::move(other.unread_)),
        started_(std::move(other.started_)) {
    other.socket_ = -1;
  }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  ~Client();

  bool connected() const { return socket_ >= 0; }
  void send(std::string_view bytes);
  /// All bytes until the peer closes the connection or the wait ends.
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
  /// The next complete message or control frame; nothing if the connection ended or no data
  /// arrived.
  std::optional<Frame> frame();

 private:
  bool fill(std::size_t bytes);
  /// `end`: whether it is the last one of a message.
  std::optional<Frame> piece(bool& end);

  int socket_ = -1;
  std::string unread_;
  Frame started_;
};

/// "GET TARGET HTTP/1.1" with a Host and further headers, each with its line end.
std::string get(std::uint16_t port, std::string_view target, std::string_view more = "",
                std::string_view host = "");

/// The headers that request a WebSocket.
extern const std::string_view kUpgrade;

/// A viewer whose socket is open and that has sent "join".
Client viewer(std::uint16_t port, int room = 0);

}  // namespace chasles::test
