#include "print.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>

namespace chasles::app {
namespace {

[[noreturn]] void reject_stdout(int error) {
  throw UsageError(fmt::format("stdout cannot be written: {}", std::strerror(error)));
}

// The text of a log message.
class PrintableMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm&,
              spdlog::memory_buf_t& out) override {
    const std::string text = printable({message.payload.data(), message.payload.size()});
    out.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PrintableMessage>();
  }
};

}  // namespace

void print_text(std::string_view text) {
  const std::string bytes = printable(text);
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size()) reject_stdout(errno);
}

void note_text(std::string_view text) {
  const std::string bytes = printable(text);
  std::fwrite(bytes.data(), 1, bytes.size(), stderr);
}

void flush_stdout() {
  if (std::fflush(stdout) != 0) reject_stdout(errno);
}

void log_to_stderr(const char* name, bool threads) {
  spdlog::drop(name);  // of an earlier call
  spdlog::set_default_logger(threads ? spdlog::stderr_color_mt(name)
                                     : spdlog::stderr_color_st(name));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PrintableMessage>('*').set_pattern("%n: %^%l%$: %*");
  spdlog::set_formatter(std::move(formatter));
}

}  // namespace chasles::app
