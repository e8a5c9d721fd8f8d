#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>

#include <chasles/live/server.hpp>
#include <chasles/live/service.hpp>

// A connection of the live server, included by server.cpp only: Boost's headers take a minute to
// compile.
namespace chasles::live_detail {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Failure = beast::error_code;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kLongestHeader = 8192;  // [bytes]
constexpr std::size_t kFragment = 1 << 16;  // part of a text; pings are sent between parts [bytes]
constexpr milliseconds kLinger{1000};       // time for the peer to read an answer

inline std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

/// The head of an answer. It forbids to frame the page, to guess its type, to cache it, and to pass
/// on its URL.
inline std::string head(std::string_view status, std::string_view type, std::size_t length) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Length: {}\r\n"
      "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
      "Referrer-Policy: no-referrer\r\nContent-Security-Policy: frame-ancestors 'none'\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\n\r\n",
      status, type, length);
}

/// State shared by all connections. It is used on the server's thread only.
struct Shared {
  LiveServerOptions options;
  Gate gate;
  LiveService* service = nullptr;
  std::unordered_set<class Connection*> served = {}, rejected = {};
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Shared& shared, tcp::socket socket)
      : shared_(shared), stream_(std::move(socket)), buffer_(kLongestHeader) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    shared_.served.erase(this);
    shared_.rejected.erase(this);
  }

  void serve() {
    shared_.served.insert(this);
    parser_.header_limit(kLongestHeader);
    parser_.body_limit(0);
    stream_.expires_after(shared_.options.handshake);
    http::async_read(
        stream_, buffer_, parser_, [self = shared_from_this()](Failure f, std::size_t) {
          if (f == http::error::end_of_stream || f == beast::error::timeout) return;
          if (f) return self->answer("400 Bad Request", "text/plain", "malformed request\n");
          self->answer_request();
        });
  }

  void reject() {
    shared_.rejected.insert(this);
    answer("503 Service Unavailable", "text/plain", "too many viewers\n");
  }

  bool joined() const { return session_ && session_->joined(); }
  bool writing() const { return writing_; }

  /// Sends the next update to the viewer, unless the previous one is still being sent.
  void notify() {
    if (!joined() || writing_ || closing_) return;
    message_ = session_->next();
    if (!message_) return;
    writing_ = true;
    socket_->binary(message_.binary);
    socket_->async_write(net::buffer(*message_.bytes),
                         [self = shared_from_this()](Failure f, std::size_t) {
                           self->writing_ = false;
                           self->message_ = {};
                           if (f) return self->hang_up();
                           self->notify();
                         });
  }

  /// Closes the connection of a viewer that does not send "join" in time.
  void expect_to_join() {
    const bool late = Clock::now() - since_ > shared_.options.handshake;
    if (session_ && !joined() && late) say_goodbye(websocket::close_code::policy_error);
  }

  void say_goodbye(websocket::close_code code) {
    if (closing_) return;
    closing_ = true;
    if (!session_) return hang_up();  // also during the handshake, which alone may write then
    socket_->async_close(code, [self = shared_from_this()](Failure) {});
  }

  void hang_up() {
    closing_ = true;
    Failure ignored;
    auto& stream = socket_ ? beast::get_lowest_layer(*socket_) : stream_;
    stream.socket().close(ignored);
  }

 private:
  void answer_request() {
    const auto& request = parser_.get();
    const auto repeated = [&](http::field field) { return request.count(field) > 1; };
    const HttpAnswer decided = shared_.service->answer(
        shared_.gate, {.method = view_of(request.method_string()),
                       .target = view_of(request.target()),
                       .host = view_of(request[http::field::host]),
                       .origin = view_of(request[http::field::origin]),
                       .protocols = view_of(request[http::field::sec_websocket_protocol]),
                       .upgrade = websocket::is_upgrade(request),
                       .repeated = repeated(http::field::host) || repeated(http::field::origin)});
    if (decided.socket) return accept_viewer(decided.subprotocol);
    answer(decided.status, decided.type, decided.body);
  }

  /// The body must outlive the connection.
  void answer(std::string_view status, std::string_view type, std::string_view body) {
    head_ = head(status, type, body.size());
    stream_.expires_after(shared_.options.silence);
    const std::array<net::const_buffer, 2> all = {net::buffer(head_),
                                                  net::buffer(body.data(), body.size())};
    net::async_write(stream_, all, [self = shared_from_this()](Failure f, std::size_t) {
      if (f) return;
      Failure ignored;
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
      self->stream_.expires_after(kLinger);
      self->drain();
    });
  }

  /// Reads the remaining bytes: a connection closed with unread bytes would lose the answer.
  void drain() {
    stream_.async_read_some(net::buffer(drained_),
                            [self = shared_from_this()](Failure f, std::size_t) {
                              if (!f) self->drain();
                            });
  }

  void accept_viewer(std::string_view subprotocol) {
    stream_.expires_never();
    socket_.emplace(std::move(stream_));
    socket_->set_option(
        websocket::stream_base::timeout{.handshake_timeout = shared_.options.handshake,
                                        .idle_timeout = shared_.options.silence,
                                        .keep_alive_pings = true});
    socket_->set_option(
        websocket::stream_base::decorator([subprotocol](websocket::response_type& response) {
          if (subprotocol.empty()) return;
          response.set(http::field::sec_websocket_protocol,
                       beast::string_view(subprotocol.data(), subprotocol.size()));
        }));
    socket_->read_message_max(shared_.options.message_bytes);
    socket_->write_buffer_bytes(kFragment);
    buffer_.clear();
    // So far it was that of a request's head.
    buffer_.max_size(shared_.options.message_bytes);
    socket_->async_accept(parser_.get(), [self = shared_from_this()](Failure f) {
      if (f || self->closing_) return;
      self->session_ = self->shared_.service->open();
      self->listen();
      self->notify();
    });
  }

  void listen() {
    socket_->async_read(buffer_, [self = shared_from_this()](Failure f, std::size_t) {
      if (f) return self->hang_up();
      if (!self->take_message()) return self->say_goodbye(websocket::close_code::policy_error);
      self->buffer_.clear();
      self->listen();
    });
  }

  /// False if the viewer's message is not allowed.
  bool take_message() {
    if (++messages_ > shared_.options.messages) return false;
    const auto bytes = buffer_.cdata();
    const std::string_view message{static_cast<const char*>(bytes.data()), bytes.size()};
    if (!session_->take(message, socket_->got_binary())) return false;
    notify();
    return true;
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  std::optional<websocket::stream<beast::tcp_stream>> socket_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  std::string head_;
  std::array<char, 1024> drained_{};
  std::unique_ptr<LiveSession> session_;  ///< once the WebSocket handshake is complete
  LiveMessage message_;                   ///< being sent
  const Clock::time_point since_ = Clock::now();
  int messages_ = 0;
  bool writing_ = false, closing_ = false;
};

}  // namespace chasles::live_detail
