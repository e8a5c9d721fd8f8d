#include <jerror.h>

#include <chasles/codec/jpeg_error.hpp>

namespace chasles {
namespace {

JpegErrors& errors_of(j_common_ptr jpeg) { return *reinterpret_cast<JpegErrors*>(jpeg->err); }

[[noreturn]] void leave_with_message(j_common_ptr jpeg) {
  JpegErrors& errors = errors_of(jpeg);
  errors.base.format_message(jpeg, errors.message);
  std::longjmp(errors.jump, 1);
}

// Extra bytes between segments harm nothing: some cameras write them.
void note(j_common_ptr jpeg, int level) {
  JpegErrors& errors = errors_of(jpeg);
  const int code = errors.base.msg_code;
  if (level >= 0 || errors.damaged) return;
  errors.damaged = code == JWRN_HIT_MARKER || code == JWRN_JPEG_EOF || code == JWRN_HUFF_BAD_CODE ||
                   code == JWRN_MUST_RESYNC || code == JWRN_NOT_SEQUENTIAL ||
                   code == JWRN_BOGUS_PROGRESSION;
  if (errors.damaged) errors.base.format_message(jpeg, errors.message);
}

void print_nothing(j_common_ptr) {}

}  // namespace

void leave_jpeg(j_common_ptr jpeg, const char* message) {
  JpegErrors& errors = errors_of(jpeg);
  std::snprintf(errors.message, sizeof errors.message, "%s", message);
  std::longjmp(errors.jump, 1);
}

JpegErrors::JpegErrors() {
  jpeg_std_error(&base);
  base.error_exit = leave_with_message;
  base.emit_message = note;
  base.output_message = print_nothing;
}

}  // namespace chasles
