#include <array>
#include <optional>
#include <thread>
#include <unordered_set>
#include <utility>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>
#include <sys/resource.h>

#include <chasles/error.hpp>
#include <chasles/live/server.hpp>
#include <chasles/live/viewer_message.hpp>

namespace chasles {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Failure = beast::error_code;
using net::ip::tcp;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr std::size_t kLongestHeader = 8192;  // [bytes]
constexpr std::size_t kFragment = 1 << 16;    // of a text, between which pings are sent [bytes]
constexpr milliseconds kLinger{1000};         // for the other side to read an answer
constexpr milliseconds kGoodbye{500};         // for the other side to close
constexpr milliseconds kClosingTick{10};
constexpr int kNiceness = 10;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

/// The head of an answer. Nothing may frame the page, guess at its type, keep it, or learn its URL.
std::string head(std::string_view status, std::string_view type, std::size_t length) {
  return fmt::format(
      "HTTP/1.1 {}\r\nContent-Type: {}; charset=utf-8\r\nContent-Length: {}\r\n"
      "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n"
      "Referrer-Policy: no-referrer\r\nContent-Security-Policy: frame-ancestors 'none'\r\n"
      "Cross-Origin-Resource-Policy: same-origin\r\n\r\n",
      status, type, length);
}

/// What all connections share. Everything happens on the server's thread.
struct Shared {
  LiveServerOptions options;
  Gate gate;
  std::string page;
  LiveFeed* feed = nullptr;
  std::unordered_set<class Connection*> served = {}, refused = {};
};

class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Shared& shared, tcp::socket socket)
      : shared_(shared), stream_(std::move(socket)), buffer_(kLongestHeader) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    shared_.served.erase(this);
    shared_.refused.erase(this);
  }

  void serve() {
    shared_.served.insert(this);
    parser_.header_limit(kLongestHeader);
    parser_.body_limit(0);
    stream_.expires_after(shared_.options.handshake);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](Failure f, std::size_t) {
                       if (f == http::error::end_of_stream || f == beast::error::timeout) return;
                       if (f)
                         return self->answer("400 Bad Request", "text/plain", "not understood\n");
                       self->answer_request();
                     });
  }

  void refuse() {
    shared_.refused.insert(this);
    answer("503 Service Unavailable", "text/plain", "too many viewers\n");
  }

  bool joined() const { return joined_; }
  bool writing() const { return writing_; }

  /// Sends what the viewer does not have yet, unless the last of it is still on its way.
  void tell() {
    if (!joined_ || writing_ || closing_) return;
    text_ = shared_.feed->next(cursor_);
    if (!text_) return;
    writing_ = true;
    socket_->async_write(net::buffer(*text_), [self = shared_from_this()](Failure f, std::size_t) {
      self->writing_ = false;
      self->text_.reset();
      if (f) return self->hang_up();
      self->tell();
    });
  }

  void say_goodbye(websocket::close_code code) {
    if (closing_) return;
    closing_ = true;
    if (!socket_) return hang_up();
    socket_->async_close(code, [self = shared_from_this()](Failure) {});
  }

 private:
  void hang_up() {
    closing_ = true;
    Failure ignored;
    auto& stream = socket_ ? beast::get_lowest_layer(*socket_) : stream_;
    stream.socket().close(ignored);
  }

  void answer_request() {
    const auto& request = parser_.get();
    const Answer decided = decide(shared_.gate, {.method = view_of(request.method_string()),
                                                 .target = view_of(request.target()),
                                                 .host = view_of(request[http::field::host]),
                                                 .origin = view_of(request[http::field::origin]),
                                                 .upgrade = websocket::is_upgrade(request)});
    switch (decided) {
      case Answer::kPage:
        return answer("200 OK", "text/html", shared_.page);
      case Answer::kSocket:
        return accept_viewer();
      case Answer::kNotFound:
        return answer("404 Not Found", "text/plain", "there is only /\n");
      case Answer::kForbidden:
        return answer("403 Forbidden", "text/plain",
                      "not from there, or not with this token: use the URL that was printed\n");
    }
  }

  /// The body must live as long as the connection.
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

  /// A connection that is closed with unread bytes would take the answer with it.
  void drain() {
    stream_.async_read_some(net::buffer(drained_),
                            [self = shared_from_this()](Failure f, std::size_t) {
                              if (!f) self->drain();
                            });
  }

  void accept_viewer() {
    stream_.expires_never();
    socket_.emplace(std::move(stream_));
    socket_->set_option(
        websocket::stream_base::timeout{.handshake_timeout = shared_.options.handshake,
                                        .idle_timeout = shared_.options.silence,
                                        .keep_alive_pings = true});
    socket_->read_message_max(shared_.options.message_bytes);
    socket_->write_buffer_bytes(kFragment);
    buffer_.clear();
    socket_->async_accept(parser_.get(), [self = shared_from_this()](Failure f) {
      if (!f) self->listen();
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

  /// False where the viewer says what it may not.
  bool take_message() {
    if (++messages_ > shared_.options.messages || !socket_->got_text()) return false;
    const auto bytes = buffer_.cdata();
    const auto message =
        parse_viewer_message({static_cast<const char*>(bytes.data()), bytes.size()});
    if (!message) return false;
    if (message->stop) shared_.feed->stop();
    if (message->join) {
      cursor_ = *message->join;
      joined_ = true;
      tell();
    }
    return true;
  }

  Shared& shared_;
  beast::tcp_stream stream_;
  std::optional<websocket::stream<beast::tcp_stream>> socket_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  std::string head_;
  std::array<char, 1024> drained_{};
  LiveCursor cursor_;
  LiveText text_;  ///< on its way
  int messages_ = 0;
  bool joined_ = false, writing_ = false, closing_ = false;
};

tcp::endpoint endpoint_of(const LiveServerOptions& options) {
  Failure failure;
  const auto address = net::ip::make_address(options.address, failure);
  if (failure) {
    throw UsageError(fmt::format(
        "the live server's address: found '{}', expected a numeric one, as 127.0.0.1 or 0.0.0.0",
        options.address));
  }
  return {address, options.port};
}

}  // namespace

class LiveServer::Impl {
 public:
  Impl(const LiveServerOptions& options, std::string page, LiveFeed& feed)
      : shared_{.options = options, .gate = {}, .page = std::move(page), .feed = &feed} {
    listen();
    shared_.gate = {.address = options.address,
                    .port = acceptor_.local_endpoint().port(),
                    .token = is_loopback(options.address) ? "" : random_token()};
    accept();
    tick();
    thread_ = std::thread([this] {
      ::setpriority(PRIO_PROCESS, 0, kNiceness);  // of this thread alone, on Linux
      io_.run();
    });
  }

  ~Impl() { close(milliseconds(0)); }

  const Gate& gate() const { return shared_.gate; }

  void close(milliseconds patience) {
    if (!thread_.joinable()) return;
    net::post(io_, [this, patience] {
      closing_ = Clock::now() + patience;
      Failure ignored;
      acceptor_.close(ignored);
      tick();
    });
    thread_.join();
  }

 private:
  void listen() {
    const tcp::endpoint endpoint = endpoint_of(shared_.options);
    Failure failure;
    acceptor_.open(endpoint.protocol(), failure);
    if (!failure) acceptor_.set_option(net::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(net::socket_base::max_listen_connections, failure);
    if (failure) {
      throw UsageError(fmt::format(
          "the live server cannot listen on {} port {}: {}; another port may be free (0: any)",
          shared_.options.address, shared_.options.port, failure.message()));
    }
  }

  void accept() {
    acceptor_.async_accept([this](Failure failure, tcp::socket socket) {
      if (!acceptor_.is_open()) return;
      if (failure) return accept_later();
      take(std::move(socket));
      accept();
    });
  }

  /// The process may have no file descriptor left for the moment.
  void accept_later() {
    pause_.expires_after(shared_.options.between_updates);
    pause_.async_wait([this](Failure failure) {
      if (!failure && acceptor_.is_open()) accept();
    });
  }

  void take(tcp::socket socket) {
    const bool full = shared_.served.size() >= shared_.options.connections;
    if (full && shared_.refused.size() >= shared_.options.connections) return;  // just closed
    const auto connection = std::make_shared<Connection>(shared_, std::move(socket));
    full ? connection->refuse() : connection->serve();
  }

  void tick() {
    std::size_t viewers = 0;
    for (const Connection* connection : shared_.served) viewers += connection->joined();
    shared_.feed->refresh(viewers);
    bool busy = false;
    for (const auto& connection : held()) {
      connection->tell();
      busy = busy || connection->writing();
    }
    if (closing_) end_when_told(busy);
    timer_.expires_after(closing_ ? kClosingTick : shared_.options.between_updates);
    timer_.async_wait([this](Failure failure) {
      if (!failure) tick();
    });
  }

  void end_when_told(bool busy) {
    const auto now = Clock::now();
    if (busy && now < *closing_) return;
    if (!farewell_) {
      farewell_ = now + kGoodbye;
      for (const auto& connection : held()) {
        connection->say_goodbye(websocket::close_code::going_away);
      }
    }
    if (shared_.served.empty() || now >= *farewell_) io_.stop();
  }

  /// A connection may end while the others are gone through.
  std::vector<std::shared_ptr<Connection>> held() const {
    std::vector<std::shared_ptr<Connection>> all;
    for (Connection* connection : shared_.served) all.push_back(connection->shared_from_this());
    return all;
  }

  Shared shared_;  // outlives what io_ still holds
  net::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  net::steady_timer timer_{io_}, pause_{io_};
  std::optional<Clock::time_point> closing_, farewell_;
  std::thread thread_;
};

LiveServer::LiveServer(const LiveServerOptions& options, std::string page, LiveFeed& feed)
    : impl_(std::make_unique<Impl>(options, std::move(page), feed)) {}

LiveServer::~LiveServer() = default;

const Gate& LiveServer::gate() const { return impl_->gate(); }

void LiveServer::close(std::chrono::milliseconds patience) { impl_->close(patience); }

}  // namespace chasles
