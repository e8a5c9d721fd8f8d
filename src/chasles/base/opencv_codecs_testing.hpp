#pragma once

#include <cstdint>
#include <dlfcn.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace chasles::test {

/// cv::imencode and cv::imdecode, from a library beside the program (tests/opencv_codecs.cpp). It
/// is loaded when the first image is encoded or decoded: OpenCV's brings 130 others, GDAL among
/// them, which cost every start of a program 0.17 s, and CTest starts a program for each test.
struct OpenCvCodecs {
  void (*encode)(const std::string& ending, const cv::Mat& image,
                 const std::vector<int>& parameters, std::vector<std::uint8_t>& bytes);
  void (*decode)(const std::vector<std::uint8_t>& bytes, int flags, cv::Mat& image);
};

inline const OpenCvCodecs& opencv_codecs() {
  static const OpenCvCodecs* const codecs = [] {
    const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    void* library = dlopen((folder / "libopencv_codecs.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    void* found = library ? dlsym(library, "chasles_opencv_codecs") : nullptr;
    if (found == nullptr) throw std::runtime_error(dlerror());
    return static_cast<const OpenCvCodecs*>(found);
  }();
  return *codecs;
}

/// The bytes of an image file whose kind that ending names (".png"); `parameters` as those of
/// cv::imencode.
inline std::vector<std::uint8_t> opencv_encoded(const std::string& ending, const cv::Mat& image,
                                                const std::vector<int>& parameters = {}) {
  std::vector<std::uint8_t> bytes;
  opencv_codecs().encode(ending, image, parameters, bytes);
  return bytes;
}

/// The image in the bytes of a file, read with these cv::ImreadModes; empty if OpenCV cannot read
/// it.
inline cv::Mat opencv_decoded(const std::vector<std::uint8_t>& bytes, int flags) {
  cv::Mat image;
  if (!bytes.empty()) opencv_codecs().decode(bytes, flags, image);
  return image;
}

/// The same of an image file; empty if there is none.
inline cv::Mat opencv_read(const std::filesystem::path& file, int flags) {
  std::ifstream stream(file, std::ios::binary);
  return opencv_decoded({std::istreambuf_iterator<char>(stream), {}}, flags);
}

}  // namespace chasles::test
