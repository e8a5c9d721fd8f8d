#include <exception>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <sys/resource.h>

#include <chasles/base/error.hpp>
#include <chasles/live/connection_detail.hpp>
#include <chasles/live/page_service.hpp>

namespace chasles {
namespace {

using namespace live_detail;

constexpr milliseconds kGoodbye{500};  // time for the peer to close
constexpr milliseconds kClosingTick{10};
constexpr int kNiceness = 10;

tcp::endpoint endpoint_of(const LiveServerOptions& options) {
  Failure failure;
  const auto address = net::ip::make_address(options.address, failure);
  if (failure) {
    throw UsageError(fmt::format(
        "the address of {}: found '{}', expected a numeric one, as 127.0.0.1 or 0.0.0.0",
        options.name, options.address));
  }
  return {address, options.port};
}

}  // namespace

class LiveServer::Impl {
 public:
  Impl(const LiveServerOptions& options, LiveService& service)
      : shared_{.options = options, .gate = {}, .service = &service} {
    listen();
    shared_.gate = {.address = options.address,
                    .port = acceptor_.local_endpoint().port(),
                    .token = is_loopback(options.address) ? "" : random_token()};
    accept();
    tick();
    thread_ = std::thread([this] {
      ::setpriority(PRIO_PROCESS, 0, kNiceness);  // of this thread alone, on Linux
      try {
        io_.run();
      } catch (const std::exception&) {
        give_up();
      }
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
      const bool no_descriptor = failure.value() == EMFILE || failure.value() == ENFILE;
      throw UsageError(fmt::format("{} cannot listen on {} port {}: {}; {}", shared_.options.name,
                                   shared_.options.address, shared_.options.port, failure.message(),
                                   no_descriptor ? "raise the limit of open files (ulimit -n)"
                                                 : "another port may be free (0: any)"));
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

  /// The process may have no free file descriptor at the moment.
  void accept_later() {
    pause_.expires_after(shared_.options.between_updates);
    pause_.async_wait([this](Failure failure) {
      if (!failure && acceptor_.is_open()) accept();
    });
  }

  void take(tcp::socket socket) {
    const bool full = shared_.served.size() >= shared_.options.connections;
    if (full && shared_.rejected.size() >= shared_.options.connections)
      return;  // closed immediately
    const auto connection = std::make_shared<Connection>(shared_, std::move(socket));
    full ? connection->reject() : connection->serve();
  }

  void tick() {
    std::size_t viewers = 0;
    for (const Connection* connection : shared_.served) viewers += connection->joined();
    shared_.service->refresh(viewers);
    bool busy = false;
    for (const auto& connection : held()) {
      connection->notify();
      connection->expect_to_join();
      busy = busy || connection->writing();
    }
    if (closing_) end_on_request(busy);
    timer_.expires_after(closing_ ? kClosingTick : shared_.options.between_updates);
    timer_.async_wait([this](Failure failure) {
      if (!failure) tick();
    });
  }

  /// Closes all connections after an error. The run is not affected; the viewers notice the lost
  /// connection.
  void give_up() {
    Failure ignored;
    acceptor_.close(ignored);
    for (const auto& connection : held()) connection->hang_up();
  }

  void end_on_request(bool busy) {
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

  /// Works on a copy, because a connection may end during the loop.
  std::vector<std::shared_ptr<Connection>> held() const {
    std::vector<std::shared_ptr<Connection>> all;
    for (Connection* connection : shared_.served) all.push_back(connection->shared_from_this());
    return all;
  }

  Shared shared_;  // outlives the handlers of io_
  net::io_context io_{1};
  tcp::acceptor acceptor_{io_};
  net::steady_timer timer_{io_}, pause_{io_};
  std::optional<Clock::time_point> closing_, farewell_;
  std::thread thread_;
};

// The system's denials of what the server needs besides a port: descriptors.
std::unique_ptr<LiveServer::Impl> LiveServer::started(const LiveServerOptions& options,
                                                      LiveService& service) {
  try {
    return std::make_unique<Impl>(options, service);
  } catch (const boost::system::system_error& error) {
    throw UsageError(fmt::format("{} cannot start: {}; raise the limit of open files (ulimit -n)",
                                 options.name, error.code().message()));
  }
}

LiveServer::LiveServer(const LiveServerOptions& options, LiveService& service)
    : impl_(started(options, service)) {}

LiveServer::LiveServer(const LiveServerOptions& options, std::string page, LiveFeed& feed)
    : page_(std::make_unique<PageService>(std::move(page), feed)),
      impl_(started(options, *page_)) {}

LiveServer::~LiveServer() = default;

const Gate& LiveServer::gate() const { return impl_->gate(); }

void LiveServer::close(std::chrono::milliseconds patience) { impl_->close(patience); }

}  // namespace chasles
