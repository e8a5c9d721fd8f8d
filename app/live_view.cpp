#include "live_view.hpp"

#include <charconv>
#include <chrono>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>

#include "print.hpp"

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
  parser
      .add_option_function<std::string>(
          "--foxglove",
          [&o](const std::string& text) {
            o.foxglove = text.empty() ? kFoxglovePort : port_of("--foxglove", text);
          },
          fmt::format("Serve the run in progress to Foxglove, on this machine only; prints the URL "
                      "(default port: {}; 0: any free port)",
                      kFoxglovePort))
      ->expected(0, 1)
      ->type_name("[PORT]")
      ->group("Output");
}

LiveView::LiveView(const LiveOptions& options, std::function<void()> stop,
                   const std::filesystem::path& output) {
  if (!options.wanted && options.address != LiveOptions{}.address) {
    throw UsageError("--live-address needs --live");
  }
  if (!output.empty()) growing_ = std::make_unique<GrowingRun>(output);
  if (options.wanted) serve_page(options, std::move(stop));
  if (options.foxglove) serve_foxglove(*options.foxglove);
}

void LiveView::serve_page(const LiveOptions& options, std::function<void()> stop) {
  run_ = std::make_unique<LiveRun>(std::move(stop));
  LiveServerOptions server;
  server.address = options.address;
  server.port = options.port;
  server_ = std::make_unique<LiveServer>(server, live_page(), *run_);
  for (const std::string& url : urls(server_->gate())) {
    note("chasles: live: {}\n", url);
  }
}

void LiveView::serve_foxglove(std::uint16_t port) {
  foxglove_ = std::make_unique<FoxgloveService>("chasles " CHASLES_VERSION);
  foxglove_server_ = std::make_unique<LiveServer>(foxglove_server_options(port), *foxglove_);
  note("chasles: foxglove: {}\n", foxglove_url(foxglove_server_->gate()));
}

LiveView::~LiveView() {
  if (server_) server_->close(kPatience);
  if (foxglove_server_) foxglove_server_->close(kPatience);
}

void LiveView::begin(const RunRecorder& recorder, const nlohmann::ordered_json& known,
                     const Recording& recording) {
  recorder_ = &recorder;
  const Run header = recorder.header();
  if (growing_) growing_->begin(header, known);
  if (run_) {
    run_->begin({.name = header.name,
                 .extra_names = header.extra_names,
                 .truth = header.truth,
                 .pairing = header.pairing,
                 .dead_reckoning = header.dead_reckoning,
                 .summary = json_text(known),
                 .frames = frame_count(recording)});
  }
  if (!foxglove_) return;
  const bool pictures = recording.images != nullptr;
  frames_.emplace(recording.cameras, pictures, *foxglove_);
  foxglove_->begin({.header = header,
                    .summary = json_text(known),
                    .cameras = static_cast<int>(recording.cameras.size()),
                    .pictures = pictures});
}

void LiveView::on_images(const ImageFrame& images) {
  if (frames_) frames_->on_images(images);
}

void LiveView::on_frame(const FeatureFrame& frame) {
  if (frames_) frames_->on_frame(frame);
}

void LiveView::on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
  if (frames_) frames_->on_outcomes(frame, outcomes);
}

void LiveView::on_progress(std::size_t frames, Time now) {
  const Run& run = recorder_->run();
  const std::function<LiveMap()> map = [this] { return recorder_->live_map(); };
  if (growing_) growing_->extend(run, [&map] { return map().landmarks; });
  for (; shown_ < run.states.size(); ++shown_) {
    if (run_) run_->add(run.states[shown_]);
    if (foxglove_) foxglove_->add(run.states[shown_]);
  }
  if (run_) {
    run_->progress(frames, recorder_->recorded_seconds(now));
    run_->map(map);
  }
  if (foxglove_) foxglove_->map(map);
}

void LiveView::on_smoothing() {
  if (run_) run_->smoothing();
}

void LiveView::finish(const Run& run, std::string summary, bool interrupted) {
  if (growing_) growing_->end();
  growing_.reset();
  if (frames_) frames_->finish();
  if (foxglove_) foxglove_->finish(run, summary, interrupted);
  if (run_) run_->finish({.run = run, .summary = std::move(summary)}, interrupted);
}

void LiveView::fail(const std::string& why) {
  if (run_) run_->fail(why);
  if (foxglove_) foxglove_->fail(why);
}

}  // namespace chasles::app
