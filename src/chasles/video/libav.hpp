#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

#include <string>
#include <string_view>

namespace chasles {

/// The functions of FFmpeg's libraries that this folder uses. They are loaded when the first video
/// is read: they bring some hundred more libraries, which would cost every start of the program,
/// and a wheel with copies of them would be under their licences.
struct Libav {
  decltype(&av_log_set_level) log_set_level;
  decltype(&av_max_alloc) max_alloc;
  decltype(&av_strerror) strerror;
  decltype(&av_dict_get) dict_get;
  decltype(&av_dict_set) dict_set;
  decltype(&av_dict_free) dict_free;
  decltype(&av_frame_alloc) frame_alloc;
  decltype(&av_frame_free) frame_free;
  decltype(&av_frame_unref) frame_unref;
  decltype(&av_rescale_q) rescale_q;
  decltype(&av_get_pix_fmt_name) pixel_format_name;
  decltype(&av_pix_fmt_desc_get) pixel_format;
  decltype(&av_display_rotation_get) display_rotation;
  decltype(&avcodec_find_decoder) find_decoder;
  decltype(&avcodec_get_name) codec_name;
  decltype(&avcodec_alloc_context3) alloc_context;
  decltype(&avcodec_free_context) free_context;
  decltype(&avcodec_parameters_to_context) parameters_to_context;
  decltype(&avcodec_open2) open_codec;
  decltype(&avcodec_send_packet) send_packet;
  decltype(&avcodec_receive_frame) receive_frame;
  decltype(&avcodec_flush_buffers) flush;
  decltype(&av_packet_alloc) packet_alloc;
  decltype(&av_packet_free) packet_free;
  decltype(&av_packet_unref) packet_unref;
  decltype(&av_find_input_format) find_input_format;
  decltype(&avformat_open_input) open_input;
  decltype(&avformat_close_input) close_input;
  decltype(&avformat_index_get_entries_count) index_entries;
  decltype(&av_read_frame) read_packet;
  decltype(&av_seek_frame) seek;
};

/// Throws InputError, starting with `where`, if the libraries are not installed. They are those of
/// the major versions of the headers, whose structs this folder uses.
const Libav& libav(const std::string& where);

/// The same from these files: libavutil, libavcodec and libavformat of one version, between blanks.
Libav load_libav(std::string_view files);

/// What an error of the libraries says.
std::string libav_error(const Libav& av, int error);

}  // namespace chasles
