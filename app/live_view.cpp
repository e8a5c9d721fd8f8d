#include "live_view.hpp"

#include <charconv>
#include <chrono>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/data/utf8.hpp>
#include <chasles/error.hpp>

namespace chasles::app {
namespace {

constexpr std::chrono::seconds kPatience{3};

}  // namespace

std::uint16_t port_of(const std::string& option, const std::string& text) {
  std::uint16_t port = 0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, port);
  if (!text.empty() && (error != std::errc() || stop != end)) {
    throw UsageError(
        fmt::format("{}: found '{}', expected a port from 0 to 65535 (0 or none: any free port)",
                    option, text));
  }
  return port;
}

void declare_live(CLI::App& parser, LiveOptions& o) {
  parser
      .add_option_function<std::string>(
          "--live",
          [&o](const std::string& text) {
            o.wanted = true;
            o.port = port_of("--live", text);
          },
          "Serve the page of the run in progress, to this machine only; prints the URL (default: "
          "any free port)")
      ->expected(0, 1)
      ->type_name("[PORT]")
      ->group("Output");
  parser
      .add_option("--live-address", o.address,
                  "With --live: the numeric address to listen on. With an address other than "
                  "loopback, anyone with the printed URL and its token can view and stop the run")
      ->type_name("ADDRESS")
      ->group("Output");
}

LiveView::LiveView(const LiveOptions& options, std::function<void()> stop,
                   const std::filesystem::path& output) {
  if (!options.wanted && options.address != LiveOptions{}.address) {
    throw UsageError("--live-address needs --live");
  }
  if (!output.empty()) growing_ = std::make_unique<GrowingRun>(output);
  if (!options.wanted) return;
  run_ = std::make_unique<LiveRun>(std::move(stop));
  server_ = std::make_unique<LiveServer>(
      LiveServerOptions{.address = options.address, .port = options.port}, live_page(), *run_);
  for (const std::string& url : urls(server_->gate())) {
    fmt::print(stderr, "chasles: live: {}\n", url);
  }
}

LiveView::~LiveView() {
  if (server_) server_->close(kPatience);
}

void LiveView::begin(const Run& header, const nlohmann::ordered_json& known, std::size_t frames) {
  if (growing_) growing_->begin(header, known);
  if (!run_) return;
  run_->begin({.name = header.name,
               .extra_names = header.extra_names,
               .truth = header.truth,
               .pairing = header.pairing,
               .dead_reckoning = header.dead_reckoning,
               .summary = json_text(known),
               .frames = frames});
}

void LiveView::advance(const Run& run, std::size_t frames, double recorded_seconds,
                       const std::function<LiveMap()>& map) {
  if (growing_) growing_->extend(run, [&map] { return map().landmarks; });
  if (!run_) return;
  for (; shown_ < run.states.size(); ++shown_) run_->add(run.states[shown_]);
  run_->progress(frames, recorded_seconds);
  run_->map(map);
}

void LiveView::smoothing() {
  if (run_) run_->smoothing();
}

void LiveView::finish(const Run& run, std::string summary, bool interrupted) {
  if (growing_) growing_->end();
  growing_.reset();
  if (run_) run_->finish({.run = run, .summary = std::move(summary)}, interrupted);
}

void LiveView::fail(const std::string& why) {
  if (run_) run_->fail(why);
}

}  // namespace chasles::app
