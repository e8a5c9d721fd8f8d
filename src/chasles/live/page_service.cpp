#include <utility>

#include <chasles/live/page_service.hpp>
#include <chasles/live/viewer_message.hpp>

namespace chasles {
namespace {

class PageSession final : public LiveSession {
 public:
  explicit PageSession(LiveFeed& feed) : feed_(feed) {}

  bool joined() const override { return joined_; }

  bool take(std::string_view text, bool binary) override {
    if (binary) return false;
    const auto message = parse_viewer_message(text);
    if (!message) return false;
    if (message->stop) feed_.stop();
    if (message->join) {
      cursor_ = *message->join;
      joined_ = true;
    }
    return true;
  }

  LiveMessage next() override { return {.bytes = feed_.next(cursor_), .binary = false}; }

 private:
  LiveFeed& feed_;
  LiveCursor cursor_;
  bool joined_ = false;
};

}  // namespace

PageService::PageService(std::string page, LiveFeed& feed) : page_(std::move(page)), feed_(feed) {}

HttpAnswer PageService::answer(const Gate& gate, const Request& request) const {
  switch (decide(gate, request)) {
    case Answer::kPage:
      return {.type = "text/html", .body = page_};
    case Answer::kSocket:
      return {.socket = true};
    case Answer::kNotFound:
      return {.status = "404 Not Found", .body = "there is only /\n"};
    case Answer::kForbidden:
      break;
  }
  return {.status = "403 Forbidden",
          .body = "wrong host, origin or token: use the URL that the program printed\n"};
}

std::unique_ptr<LiveSession> PageService::open() { return std::make_unique<PageSession>(feed_); }

}  // namespace chasles
