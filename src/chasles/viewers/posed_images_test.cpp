#include <memory>
#include <string>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/report/testing.hpp>
#include <chasles/viewers/posed_images.hpp>

namespace chasles {
namespace {

// Images that are no files, as those of a bag.
class NoFiles : public ImageSource {
 public:
  std::size_t size() const override { return 3; }
  Time time(std::size_t i) const override { return std::chrono::seconds(i); }
  ImageFrame read(std::size_t /*i*/) const override { return {}; }
};

TEST(PosedImages, ARecordingWithoutImageFilesIsAnError) {
  ReportRun drive = test::synthetic_drive({.states = 20, .landmarks = 4});
  const auto message = [&](const Recording& recording) -> std::string {
    try {
      posed_images(drive, RunPath::kStates, recording);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  Recording recording;
  recording.name = "flight";
  EXPECT_NE(message(recording).find("recording 'flight' has no images, expected"),
            std::string::npos);
  recording.images = std::make_shared<NoFiles>();
  EXPECT_NE(message(recording).find("has no such camera"), std::string::npos);
  recording.cameras.resize(1);
  EXPECT_NE(message(recording).find("has images that are no files"), std::string::npos);
  // Camera 0 of a run with --cameras 2.
  drive.summary = R"({"cameras": [{"number": 2}]})";
  EXPECT_NE(message(recording).find("no such camera, expected one with the images of camera 2"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
