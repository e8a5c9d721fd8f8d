#include <opencv2/imgcodecs.hpp>

#include <chasles/base/opencv_codecs_testing.hpp>

// A library that tests load when they need OpenCV's readers and writers of images.
namespace {

void encode(const std::string& ending, const cv::Mat& image, const std::vector<int>& parameters,
            std::vector<std::uint8_t>& bytes) {
  cv::imencode(ending, image, bytes, parameters);
}

void decode(const std::vector<std::uint8_t>& bytes, int flags, cv::Mat& image) {
  image = cv::imdecode(bytes, flags);
}

}  // namespace

extern "C" const chasles::test::OpenCvCodecs chasles_opencv_codecs;
const chasles::test::OpenCvCodecs chasles_opencv_codecs = {.encode = encode, .decode = decode};
