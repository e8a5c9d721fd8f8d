#include <dlfcn.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/video/libav.hpp>

namespace chasles {
namespace {

// "libavutil.so.57 libavcodec.so.59 libavformat.so.59"
constexpr std::string_view kLibavFiles = CHASLES_LIBAV_FILES;

// Debian's package of libavformat.so.59 is libavformat59.
std::string package_of(std::string_view file) {
  return std::string(file.substr(0, file.find(".so."))).append(file.substr(file.rfind('.') + 1));
}

void* load_libav_file(std::string_view file) {
  if (void* library = dlopen(std::string(file).c_str(), RTLD_NOW | RTLD_LOCAL)) return library;
  throw InputError(
      fmt::format("{} cannot be loaded, and videos need it: install FFmpeg's libraries of this "
                  "version (Debian, Ubuntu: {}) ({})",
                  file, package_of(file), dlerror()));
}

template <typename Function>
void find_in(void* library, std::string_view file, const char* name, Function& function) {
  void* address = dlsym(library, name);
  if (address == nullptr) throw InputError(fmt::format("{} has no function {}", file, name));
  function = reinterpret_cast<Function>(address);
}

void find_util(void* library, std::string_view file, Libav& av) {
  find_in(library, file, "av_log_set_level", av.log_set_level);
  find_in(library, file, "av_max_alloc", av.max_alloc);
  find_in(library, file, "av_strerror", av.strerror);
  find_in(library, file, "av_dict_get", av.dict_get);
  find_in(library, file, "av_dict_set", av.dict_set);
  find_in(library, file, "av_dict_free", av.dict_free);
  find_in(library, file, "av_frame_alloc", av.frame_alloc);
  find_in(library, file, "av_frame_free", av.frame_free);
  find_in(library, file, "av_frame_unref", av.frame_unref);
  find_in(library, file, "av_rescale_q", av.rescale_q);
  find_in(library, file, "av_get_pix_fmt_name", av.pixel_format_name);
  find_in(library, file, "av_pix_fmt_desc_get", av.pixel_format);
  find_in(library, file, "av_display_rotation_get", av.display_rotation);
}

void find_codec(void* library, std::string_view file, Libav& av) {
  find_in(library, file, "avcodec_find_decoder", av.find_decoder);
  find_in(library, file, "avcodec_get_name", av.codec_name);
  find_in(library, file, "avcodec_alloc_context3", av.alloc_context);
  find_in(library, file, "avcodec_free_context", av.free_context);
  find_in(library, file, "avcodec_parameters_to_context", av.parameters_to_context);
  find_in(library, file, "avcodec_open2", av.open_codec);
  find_in(library, file, "avcodec_send_packet", av.send_packet);
  find_in(library, file, "avcodec_receive_frame", av.receive_frame);
  find_in(library, file, "avcodec_flush_buffers", av.flush);
  find_in(library, file, "av_packet_alloc", av.packet_alloc);
  find_in(library, file, "av_packet_free", av.packet_free);
  find_in(library, file, "av_packet_unref", av.packet_unref);
}

void find_format(void* library, std::string_view file, Libav& av) {
  find_in(library, file, "av_find_input_format", av.find_input_format);
  find_in(library, file, "avformat_open_input", av.open_input);
  find_in(library, file, "avformat_close_input", av.close_input);
  find_in(library, file, "avformat_index_get_entries_count", av.index_entries);
  find_in(library, file, "av_read_frame", av.read_packet);
  find_in(library, file, "av_seek_frame", av.seek);
}

}  // namespace

Libav load_libav(std::string_view names) {
  const auto files = split_words(names);
  Libav av{};  // the libraries stay loaded until the program ends
  find_util(load_libav_file(files[0]), files[0], av);
  find_codec(load_libav_file(files[1]), files[1], av);
  find_format(load_libav_file(files[2]), files[2], av);
  // Their messages have neither the file nor what to do; ours have. A table of a few bytes may
  // claim gigabytes.
  av.log_set_level(AV_LOG_QUIET);
  av.max_alloc(read_budget().bytes);
  return av;
}

const Libav& libav(const std::string& where) {
  try {
    static const Libav functions = load_libav(kLibavFiles);
    return functions;
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", where, error.what()));
  }
}

std::string libav_error(const Libav& av, int error) {
  char text[AV_ERROR_MAX_STRING_SIZE] = {};
  av.strerror(error, text, sizeof text);
  return text;
}

}  // namespace chasles
