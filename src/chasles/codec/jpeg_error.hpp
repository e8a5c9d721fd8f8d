#pragma once

#include <csetjmp>
#include <cstddef>
#include <cstdio>  // jpeglib.h needs it
#include <jpeglib.h>
#include <string>

namespace chasles {

/// What libjpeg calls at an error: it jumps to `jump` and leaves the message. Nothing is printed.
///
/// Between setjmp() and the jump there must be no object with a destructor.
struct JpegErrors {
  jpeg_error_mgr base{};  // first: libjpeg has a pointer to it
  std::jmp_buf jump;
  char message[JMSG_LENGTH_MAX] = "";
  bool damaged = false;  ///< a warning that part of the picture is missing or wrong

  JpegErrors();
};

/// Leaves with a message, as at an error of libjpeg. Throws nothing.
[[noreturn]] void leave_jpeg(j_common_ptr jpeg, const char* message);

}  // namespace chasles
