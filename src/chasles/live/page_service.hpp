#pragma once

#include <memory>
#include <string>

#include <chasles/live/feed.hpp>
#include <chasles/live/service.hpp>

namespace chasles {

/// A page and its socket: GET / is the page, GET /live the updates of a feed (docs/live.md
/// describes the protocol).
class PageService final : public LiveService {
 public:
  /// The feed must outlive the service.
  PageService(std::string page, LiveFeed& feed);

  HttpAnswer answer(const Gate& gate, const Request& request) const override;
  std::unique_ptr<LiveSession> open() override;
  void refresh(std::size_t viewers) override { feed_.refresh(viewers); }

 private:
  const std::string page_;
  LiveFeed& feed_;
};

}  // namespace chasles
