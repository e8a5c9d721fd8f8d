#include <exception>

#include <fmt/format.h>

#include <chasles/session/print_text.hpp>
#include <chasles/session/remarks.hpp>

namespace chasles {

RemarksOnError::RemarksOnError(const Recording& recording)
    : recording_(recording), exceptions_(std::uncaught_exceptions()) {}

RemarksOnError::~RemarksOnError() {
  if (std::uncaught_exceptions() == exceptions_) return;
  try {
    for (const std::string& remark : recording_.remarks) {
      note_text(fmt::format("chasles: remark: {}\n", remark));
    }
  } catch (const std::exception&) {  // a closed stderr hides no error
  }
}

}  // namespace chasles
