#include <utility>

#include <fmt/format.h>

#include <chasles/foxglove/protocol.hpp>
#include <chasles/foxglove/service.hpp>
#include <chasles/foxglove/session.hpp>

namespace chasles {
namespace {

constexpr std::chrono::milliseconds kBetweenFrames{100};
constexpr std::chrono::milliseconds kBetweenUpdates{50};
constexpr std::size_t kLongestMessage = 1 << 16;  // of a client [bytes]
constexpr int kMostMessages = 100'000;            // of a client
constexpr std::size_t kMostClients = 16;

}  // namespace

FoxgloveService::FoxgloveService(std::string server)
    : server_(std::move(server)), id_(random_token()) {}

void FoxgloveService::begin(FoxgloveStart start) {
  const std::lock_guard lock(mutex_);
  inbox_.start = std::move(start);
}

void FoxgloveService::add(const RunState& state) {
  const std::lock_guard lock(mutex_);
  inbox_.states.push_back(state);
}

void FoxgloveService::map(const std::function<LiveMap()>& make) {
  if (!watched_ || !maps_.is_due()) return;
  LiveMap map = maps_(make);
  const std::lock_guard lock(mutex_);
  inbox_.map = std::move(map);
}

void FoxgloveService::frame(FoxgloveFrame frame) {
  const std::lock_guard lock(mutex_);
  inbox_.frame = std::move(frame);
}

void FoxgloveService::finish(const Run& run, std::string summary, bool interrupted) {
  End end{.run = run, .summary = std::move(summary), .interrupted = interrupted};
  const std::lock_guard lock(mutex_);
  inbox_.end = std::move(end);
}

void FoxgloveService::fail(const std::string& why) {
  const std::lock_guard lock(mutex_);
  inbox_.failure = why;
}

HttpAnswer FoxgloveService::answer(const Gate& gate, const Request& request) const {
  if (request.repeated || !knows_host(gate, request.host) || !is_foxglove_origin(request.origin)) {
    return {.status = "403 Forbidden",
            .body = "wrong host or origin: connect Foxglove to the URL that the program printed\n"};
  }
  if (request.method != "GET" || request.target.substr(0, request.target.find('?')) != "/") {
    return {.status = "404 Not Found", .body = "there is only /\n"};
  }
  const std::string_view subprotocol = foxglove_subprotocol(request.protocols);
  if (!request.upgrade || subprotocol.empty()) {
    return {.status = "400 Bad Request",
            .body =
                "expected a WebSocket with the subprotocol foxglove.websocket.v1 or "
                "foxglove.sdk.v1: open this URL in Foxglove\n"};
  }
  return {.socket = true, .subprotocol = subprotocol};
}

std::unique_ptr<LiveSession> FoxgloveService::open() {
  const std::string name =
      channels_.name().empty() ? server_ : fmt::format("{}: {}", server_, channels_.name());
  return std::make_unique<FoxgloveSession>(channels_, name, id_);
}

void FoxgloveService::refresh(std::size_t viewers) {
  watched_ = viewers > 0;
  Inbox news;
  {
    const std::lock_guard lock(mutex_);
    std::swap(news, inbox_);
  }
  take(std::move(news));
  ask_for_frame();
}

void FoxgloveService::take(Inbox news) {
  if (news.start) channels_.begin(std::move(*news.start));
  channels_.add(news.states);
  if (news.map) channels_.map(std::move(*news.map));
  if (news.frame) channels_.frame(std::move(*news.frame));
  channels_.show();
  if (news.end) take_end(std::move(*news.end));
  if (news.failure) channels_.notice(StatusLevel::kError, "the run failed: " + *news.failure);
}

void FoxgloveService::take_end(End end) {
  const std::string text = fmt::format("the run {}: {} states, {} landmarks",
                                       end.interrupted ? "was ended" : "is complete",
                                       end.run.states.size(), end.run.landmarks.size());
  channels_.finish(std::move(end.run), end.summary);
  channels_.notice(StatusLevel::kInfo, text);
}

void FoxgloveService::ask_for_frame() {
  const Pace::Clock::time_point now = Pace::Clock::now();
  shows_frames_ = channels_.shows_frames();
  if (!shows_frames_ || now < next_frame_) return;
  next_frame_ = now + kBetweenFrames;
  wants_frame_ = true;
}

LiveServerOptions foxglove_server_options(std::uint16_t port) {
  LiveServerOptions options;
  options.name = "the Foxglove server";
  options.port = port;
  options.connections = kMostClients;
  options.message_bytes = kLongestMessage;
  options.messages = kMostMessages;
  options.between_updates = kBetweenUpdates;
  return options;
}

std::string foxglove_url(const Gate& gate) {
  return fmt::format("ws://{}:{}", gate.address, gate.port);
}

}  // namespace chasles
