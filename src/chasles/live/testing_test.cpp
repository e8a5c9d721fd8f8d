#include <array>
#include <unistd.h>
#include <utility>

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>

#include <chasles/live/testing.hpp>

namespace chasles::test {

const std::string_view kUpgrade =
    "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";

Client::Client(std::uint16_t port, int room) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
  if (socket_ < 0) return;
  const timeval wait{.tv_sec = 5, .tv_usec = 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof(wait));
  if (room > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &room, sizeof(room));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) return;
  ::close(socket_);
  socket_ = -1;
}

Client::~Client() {
  if (socket_ >= 0) ::close(socket_);
}

void Client::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
}

bool Client::fill(std::size_t bytes) {
  std::array<char, 65536> buffer;
  while (unread_.size() < bytes) {
    const ssize_t n = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (n <= 0) return false;
    unread_.append(buffer.data(), static_cast<std::size_t>(n));
  }
  return true;
}

std::string Client::rest() {
  while (fill(unread_.size() + 1)) {
  }
  return std::exchange(unread_, {});
}

std::string Client::answer_head() {
  std::size_t end = std::string::npos;
  while ((end = unread_.find("\r\n\r\n")) == std::string::npos) {
    if (!fill(unread_.size() + 1)) return std::exchange(unread_, {});
  }
  std::string head = unread_.substr(0, end);
  unread_.erase(0, end + 4);
  return head;
}

void Client::say(std::string_view text) {
  std::string frame = "\x81";
  const std::size_t n = text.size();
  if (n < 126) {
    frame += static_cast<char>(0x80 | n);
  } else {
    const bool wide = n > 0xffff;
    frame += static_cast<char>(wide ? 0xff : 0xfe);
    for (int shift = wide ? 56 : 8; shift >= 0; shift -= 8) {
      frame += static_cast<char>(static_cast<std::uint64_t>(n) >> shift);
    }
  }
  const std::string_view mask = "\x11\x22\x33\x44";
  frame += mask;
  for (std::size_t i = 0; i < n; ++i) frame += static_cast<char>(text[i] ^ mask[i % 4]);
  send(frame);
}

std::optional<Client::Frame> Client::frame() {
  bool end = false;
  while (const std::optional<Frame> next = piece(end)) {
    if (next->opcode >= 8) return next;
    if (next->opcode != 0) started_.opcode = next->opcode;
    started_.text += next->text;
    if (end) return std::exchange(started_, {});
  }
  return std::nullopt;
}

std::optional<Client::Frame> Client::piece(bool& end) {
  if (!fill(2)) return std::nullopt;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(unread_[i]); };
  const int opcode = byte(0) & 15;
  end = (byte(0) & 128) != 0;
  std::uint64_t length = byte(1) & 127;
  const std::size_t more = length == 127 ? 8 : length == 126 ? 2 : 0;
  if (!fill(2 + more)) return std::nullopt;
  if (more > 0) length = 0;
  for (std::size_t i = 0; i < more; ++i) length = length << 8 | byte(2 + i);
  if (!fill(2 + more + length)) return std::nullopt;
  Frame frame{.opcode = opcode, .text = unread_.substr(2 + more, length)};
  unread_.erase(0, 2 + more + length);
  return frame;
}

int Client::Frame::close_code() const {
  if (opcode != 8 || text.size() < 2) return 0;
  return static_cast<unsigned char>(text[0]) << 8 | static_cast<unsigned char>(text[1]);
}

std::string get(std::uint16_t port, std::string_view target, std::string_view more,
                std::string_view host) {
  const std::string own = fmt::format("127.0.0.1:{}", port);
  return fmt::format("GET {} HTTP/1.1\r\nHost: {}\r\n{}\r\n", target, host.empty() ? own : host,
                     more);
}

Client viewer(std::uint16_t port, int room) {
  Client client(port, room);
  client.send(get(port, "/live", kUpgrade));
  client.answer_head();
  client.say(R"({"join": {}})");
  return client;
}

}  // namespace chasles::test
