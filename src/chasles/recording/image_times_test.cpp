#include <fmt/format.h>

#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

constexpr std::int64_t kFirst = 1403636584763555584;  // [ns]

class ImageTimes : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = test::scratch();
    place = {
        .images = folder / "images/cam0", .name = "cam0", .shared = {folder / "images", folder}};
    fs::create_directories(place.images);
  }
  static Time time(int i) { return Time(kFirst + 49999872L * i); }
  static std::string seconds(int i) {
    return fmt::format("{}.{:09}", time(i).count() / 1000000000, time(i).count() % 1000000000);
  }
  // Four images; their content does not matter.
  template <typename Name>
  void add_images(const Name& name) const {
    for (const auto& entry : fs::directory_iterator(place.images)) fs::remove(entry.path());
    for (int i = 0; i < 4; ++i) test::spill(place.images / name(i), "x");
  }
  void add_numbered() const {
    add_images([](int i) { return fmt::format("{:06}.png", i); });
  }
  template <typename Line>
  void add_list(const fs::path& file, const std::string& heading, const Line& line) const {
    std::string text = heading;
    for (int i = 0; i < 4; ++i) text += line(i) + "\n";
    test::spill(folder / file, text);
  }
  // The times of the images that the list names, and how far they are from the truth at most.
  void expect_times(Time most = Time(0)) {
    const auto files = list_camera_images(place, remarks);
    ASSERT_TRUE(files.has_value());
    ASSERT_EQ(files->images.size(), 4u);
    for (int i = 0; i < 4; ++i) {
      const StampedFile& image = files->images[static_cast<std::size_t>(i)];
      EXPECT_LE(std::abs((image.time - time(i)).count()), most.count());
      EXPECT_TRUE(fs::exists(place.images / image.file)) << image.file;
    }
  }
  std::string error() {
    return input_error([&] { list_camera_images(place, remarks); });
  }
  fs::path folder;
  CameraPlace place;
  std::vector<std::string> remarks;
};

TEST_F(ImageTimes, NamesAreTimes) {
  add_images([](int i) { return fmt::format("{}.png", time(i).count()); });
  expect_times();
  EXPECT_TRUE(remarks.empty());
  add_images([](int i) { return fmt::format("left_{}.jpg", time(i).count()); });
  expect_times();
  add_images([](int i) { return seconds(i) + ".png"; });
  expect_times();
  expect_parts(remarks.at(0), {"the names of the images of cam0", "seconds"});
  add_images([](int i) { return seconds(i).substr(0, 17) + ".png"; });  // microseconds
  expect_times(Time(1000));
}

TEST_F(ImageTimes, NumbersWithoutAListSayWhatIsMissing) {
  add_numbered();
  expect_parts(error(), {"images/cam0: the names of its 4 images (000000.png to 000003.png)",
                         "no times", "images/cam0/times.txt", "000000.png`"});
  add_images([](int i) { return fmt::format("frame_{:04}.png", i + 1); });
  expect_parts(error(), {"frame_0001.png to frame_0004.png", "times.txt"});
  add_images([](int i) { return fmt::format("{}.png", "abcd"[i]); });
  expect_parts(error(), {"a.png to d.png", "times.txt"});
}

TEST_F(ImageTimes, AListHasManyForms) {
  add_numbered();
  const fs::path list = "images/cam0/times.txt";
  const auto name = [](int i) { return fmt::format("{:06}", i); };
  add_list(list, "", [&](int i) { return seconds(i); });
  expect_times();
  add_list(list, "", [&](int i) { return fmt::format("{}", time(i).count()); });
  expect_times();
  add_list(list, "# index time\n", [&](int i) { return fmt::format("{} {}", i, seconds(i)); });
  expect_times();
  add_list(list, "", [&](int i) { return name(i) + " " + seconds(i); });
  expect_times();
  add_list(list, "", [&](int i) { return name(i) + ".png " + seconds(i); });
  expect_times();
  add_list(list, "", [&](int i) { return seconds(i) + "," + name(i) + ".png"; });
  expect_times();
  add_list(list, "# id timestamp image_name\n",
           [&](int i) { return fmt::format("{} {} cam0/{}.png", i, seconds(i), name(i)); });
  const auto files = list_camera_images(place, remarks);
  EXPECT_EQ(files->images.at(3).file, "cam0/000003.png");
  EXPECT_EQ(files->images.at(3).time, time(3));
  add_list(list, "time [us];frame\n",
           [&](int i) { return fmt::format("{};{}", time(i).count() / 1000, i); });
  expect_times(Time(1000));
}

TEST_F(ImageTimes, AListMayBeBesideTheImages) {
  add_numbered();
  const auto line = [](int i) { return seconds(i); };
  add_list("timestamps.txt", "", line);
  expect_times();
  expect_parts(remarks.back(), {"the times of the images of cam0 are those of", "timestamps.txt"});
  add_list("images/cam0_times.txt", "", [](int i) { return seconds(i + 1); });
  EXPECT_EQ(list_camera_images(place, remarks)->images.at(0).time, time(1));  // its own
  add_images([](int i) { return fmt::format("{}.png", time(i).count()); });
  expect_times();  // names that are times come first
}

TEST_F(ImageTimes, AListMustFitTheImages) {
  add_numbered();
  test::spill(place.images / "times.txt", "1.5\n2.5\n");
  expect_parts(error(), {"times.txt: has 2 times, and the folder 4 images"});
  test::spill(place.images / "times.txt", "1.5\n2.5\n3.5\n4.5\n5.5\n");
  EXPECT_EQ(list_camera_images(place, remarks)->images.size(), 4u);
  expect_parts(remarks.back(), {"times.txt"});
  test::spill(place.images / "times.txt", "here are no times\n");
  expect_parts(error(), {"times.txt"});
  add_images([](int i) { return fmt::format("{}.png", i + 1); });
  test::spill(place.images / "times.txt", "1.5\n2.5\n3.5\n4.5\n");  // numbers from 1 on
  const auto files = list_camera_images(place, remarks);
  EXPECT_EQ(files->images.at(0).file, "1.png");
  EXPECT_EQ(files->images.at(0).time, std::chrono::milliseconds(1500));
}

// Of N images from 1 on and one time more, either the image of the first or the one of the last
// time is missing.
TEST_F(ImageTimes, NumbersFromOneAreNotShiftedSilently) {
  add_images([](int i) { return fmt::format("{:06}.png", i + 1); });
  test::spill(place.images / "times.txt", "1.5\n2.5\n3.5\n4.5\n5.5\n");
  expect_parts(error(), {"times.txt: has 5 times", "numbered from 1 to 4",
                         "000001.png to 000004.png", "image 0 which is missing", "file's name"});
  fs::remove(place.images / "000002.png");  // the last number is the number of times
  test::spill(place.images / "times.txt", "1.5\n2.5\n3.5\n4.5\n");
  const auto gap = list_camera_images(place, remarks);
  ASSERT_EQ(gap->images.size(), 3u);
  EXPECT_EQ(gap->images[1].file, "000003.png");
  EXPECT_EQ(gap->images[1].time, std::chrono::milliseconds(3500));
  // What states the numbers, or begins with 0, is no question.
  test::spill(place.images / "times.txt", "0 1.5\n1 2.5\n2 3.5\n3 4.5\n4 5.5\n");
  EXPECT_EQ(list_camera_images(place, remarks)->images.at(0).time, std::chrono::milliseconds(2500));
  test::spill(place.images / "000000.png", "x");
  test::spill(place.images / "times.txt", "1.5\n2.5\n3.5\n4.5\n5.5\n");
  EXPECT_EQ(list_camera_images(place, remarks)->images.at(1).time, std::chrono::milliseconds(2500));
}

// 5, 10 and 15 ms as numbers of microseconds, within samples from 0 to 20 ms.
TEST_F(ImageTimes, WholeNumbersAreInTheUnitInWhichTheyAreWithinTheSamples) {
  const std::vector<ImuSample> imu{{.time = Time(0) + std::chrono::seconds(1)},
                                   {.time = std::chrono::seconds(2)}};
  const auto fitted = [&](std::int64_t factor) {
    CameraFiles files{.folder = folder, .images = {}};
    for (int i = 0; i < 3; ++i)
      files.images.push_back({.time = Time(factor * (i + 12)), .file = ""});
    std::vector<std::optional<CameraFiles>> cameras{std::nullopt, files};
    fit_units(cameras, imu, remarks);
    return cameras[1]->images[2].time;
  };
  EXPECT_EQ(fitted(100'000'000), std::chrono::milliseconds(1400));  // nanoseconds
  EXPECT_TRUE(remarks.empty());
  EXPECT_EQ(fitted(100'000), std::chrono::milliseconds(1400));
  expect_parts(remarks.at(0), {"microseconds"});
  EXPECT_EQ(fitted(100), std::chrono::milliseconds(1400));
  expect_parts(remarks.at(1), {"milliseconds"});
  EXPECT_EQ(fitted(7), Time(98));  // in no unit
}

TEST_F(ImageTimes, AnotherColumnBeforeThatOfTheFilesIsNotTaken) {
  add_numbered();
  const auto listed = [&](const char* heading, const auto& line) {
    SCOPED_TRACE(heading);
    add_list("images/cam0/times.csv", heading, line);
    expect_times();
  };
  const auto left = [](int i) { return fmt::format("left,{},{:06}.png", time(i).count(), i); };
  listed("name,time_ns,file\n", left);
  listed("name,time_ns,picture\n", left);
  listed("image,time_ns,path\n",
         [](int i) { return fmt::format("{},{},{:06}.png", i + 7, time(i).count(), i); });
  listed("camera,image,time [ns]\n",
         [](int i) { return fmt::format("0,{:06},{}", i, time(i).count()); });
  listed("timestamp [s]\n", [](int i) { return seconds(i); });
}

}  // namespace
}  // namespace chasles
