#include <algorithm>

#include <sqlite3.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/bag_testing.hpp>
#include <chasles/codec/bomb_testing.hpp>
#include <chasles/recording/bag_images.hpp>
#include <chasles/recording/readers.hpp>

// The bags are those of tools/test-bags, by the Python packages rosbags and mcap.
namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::BombStopwatch;
using test::expect_parts;
using test::input_error;
using test::kStamp;
using test::written_bag;

/// A folder with Kalibr's files, and copies of bags there.
class Bag : public ::testing::Test {
 protected:
  fs::path copy(const std::string& name, const std::string& as) {
    fs::create_directories((folder / as).parent_path());
    fs::copy(written_bag(name), folder / as, fs::copy_options::recursive);
    return folder / as;
  }
  std::string rejection(const fs::path& path) {
    return input_error([&] { read_recording(path); });
  }
  fs::path folder = test::scratch();
};

void expect_the_walk(const Recording& r) {
  ASSERT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.imu[3].time, kStamp + std::chrono::milliseconds(15)) << "the message's own stamp";
  EXPECT_EQ(r.imu[3].specific_force_imu, Eigen::Vector3d(1, -2, 12));
  EXPECT_EQ(r.imu[3].angular_rate_imu, Eigen::Vector3d(0.1, -0.2, 3.3));
  ASSERT_EQ(r.images->size(), 3u);
  for (const std::size_t k : {2u, 0u, 1u}) {
    const ImageFrame frame = r.images->read(k);
    EXPECT_EQ(frame.time, kStamp + std::chrono::milliseconds(5 * k));
    ASSERT_EQ(frame.images.size(), 2u);
    EXPECT_EQ(frame.images[0].pixels[3], test::shade_of(0, static_cast<int>(k)) + 3);
    ASSERT_EQ(frame.images[1].empty(), k == 1);
    if (k != 1) {
      EXPECT_EQ(frame.images[1].pixels[3], test::shade_of(1, static_cast<int>(k)) + 3);
    }
  }
}

class WrittenBag : public Bag, public ::testing::WithParamInterface<const char*> {};

TEST_P(WrittenBag, HoldsTheWalk) {
  const fs::path path = copy(GetParam(), GetParam());
  test::write_kalibr(fs::is_directory(path) ? path : path.parent_path());
  const Recording r = read_recording(path);
  EXPECT_EQ(r.name, path.stem().string());
  expect_the_walk(r);
  EXPECT_EQ(r.cameras[1].cam_T_imu.p.x(), 0.4);
  ASSERT_EQ(r.remarks.size(), 1u);
  expect_parts(r.remarks[0], {"cam1 has an image for 2 of the 3 frames"});
}

INSTANTIATE_TEST_SUITE_P(Writers, WrittenBag,
                         ::testing::Values("none.bag", "bz2.bag", "lz4.bag", "calibrated.bag",
                                           "db3", "db3/db3.db3", "db3_message", "mcap", "none.mcap",
                                           "lz4.mcap", "zstd.mcap", "unchecked.mcap",
                                           "streamed.mcap"),
                         [](const auto& one) {
                           std::string name = one.param;
                           std::replace_if(
                               name.begin(), name.end(),
                               [](char c) { return c == '.' || c == '/'; }, '_');
                           return name;
                         });

// `ros2 bag record --compression-mode file`.
TEST_F(Bag, AFileThatIsCompressedAsAWholeHoldsTheWalk) {
  const fs::path path = copy("db3_file", "packed");
  test::write_kalibr(path);
  for (const fs::path& given : {path, path / "db3_file.db3.zstd"}) {
    const Recording r = read_recording(given);
    expect_the_walk(r);
    expect_parts(r.remarks.at(0), {"db3_file.db3.zstd is compressed as a whole (zstd)"});
  }
}

TEST_F(Bag, OfImagesOfAnotherKindTheFormatIsNamed) {
  std::string message = test::message_header(kStamp);
  test::put_text(message, "rgb8; avif compressed bgr8");
  test::put_text(message, "no image");
  test::spill(folder / "walk.mcap",
              test::mcap_of("/cam0/compressed", "sensor_msgs/CompressedImage", {message}));
  const BagContents contents = scan_bags({folder / "walk.mcap"});
  EXPECT_EQ(contents.topics.at(0).format, "rgb8; avif compressed bgr8");
  const Camera camera{
      .width = 8, .height = 6, .fx = 4, .fy = 4, .cx = 3.5, .cy = 2.5, .cam_T_imu = {}};
  std::vector<std::string> remarks;
  expect_parts(
      input_error([&] {
        open_bag_images(contents.files, {&contents.topics[0]}, {camera}, {}, "walk.mcap", remarks);
      }),
      {"walk.mcap: topic /cam0/compressed: its images have the format 'rgb8; avif",
       "expected one of PNG", "republish compressed raw", "in/compressed:=/cam0/compressed",
       "out:=/cam0`"});
}

// One line, not one for each of the first 20 images.
TEST_F(Bag, OfImagesWithoutAnEncodingTheKnownOnesAreNamed) {
  test::spill(folder / "walk.mcap",
              test::mcap_of("/cam0", "sensor_msgs/Image",
                            {test::image_message(kStamp, test::picture(1), "")}));
  const BagContents contents = scan_bags({folder / "walk.mcap"});
  const Camera camera{
      .width = 8, .height = 6, .fx = 4, .fy = 4, .cx = 3.5, .cy = 2.5, .cam_T_imu = {}};
  std::vector<std::string> remarks;
  expect_parts(input_error([&] {
                 open_bag_images(contents.files, {&contents.topics[0]}, {camera}, {}, "walk.mcap",
                                 remarks);
               }),
               {"topic /cam0: the encoding is ''", "mono8"});
}

// `rosbag record` was ended before it wrote a chunk.
TEST_F(Bag, OfTheFirstLineAloneSaysWhy) {
  test::write_kalibr(folder);
  for (const std::size_t zeros : {0u, 40u}) {
    test::spill(folder / "walk.bag.active", "#ROSBAG V2.0\n" + std::string(zeros, '\0'));
    expect_parts(rejection(folder / "walk.bag.active"), {"walk.bag.active: ends before its first"});
  }
}

TEST_F(Bag, OfForeignMessagesTheSerialisationIsNamed) {
  std::string bytes = test::mcap_of("/camera", "foxglove.CompressedImage", {"abc"});
  for (std::size_t at = 20; (at = bytes.find("ros1", at)) != std::string::npos; ++at) {
    if (bytes[at + 4] == '\0') bytes.replace(at, 4, "json");
  }
  test::spill(folder / "walk.mcap", bytes);
  const std::initializer_list<std::string> parts{"walk.mcap: its messages are serialised as json",
                                                 "/camera of foxglove.CompressedImage",
                                                 "ROS 2 (cdr)"};
  expect_parts(rejection(folder / "walk.mcap"), parts);
  test::write_kalibr(folder);
  expect_parts(rejection(folder / "walk.mcap"), parts);
}

// rosbag2 puts a bag into a folder of its own: Kalibr's files may lie beside the folder.
TEST_F(Bag, TheCalibrationMayLieBesideTheFolder) {
  const fs::path path = copy("db3", "walk");
  test::write_kalibr(folder);
  expect_the_walk(read_recording(path));
  expect_the_walk(read_recording(path / "db3.db3"));
}

TEST_F(Bag, CameraInfoAndStaticTransformsCalibrate) {
  for (const char* name : {"calibrated.bag", "mcap"}) {
    const fs::path path = copy(name, name);
    expect_parts(rejection(path),
                 {"neither camchain-imucam.yaml nor imu.yaml", "imu.yaml with the"});
    test::spill(folder / "imu.yaml", test::kKalibrImu);
    const Recording r = read_recording(path);
    expect_the_walk(r);
    EXPECT_EQ(r.imu_noise->gyroscope_noise_density, 0.005);
    EXPECT_EQ(r.cameras[0].fy, 4.5);
    EXPECT_EQ(r.cameras[0].distortion, Distortion::kRadtan);
    EXPECT_EQ(r.cameras[0].coefficients, (LensCoefficients{-0.3, 0.1, 1e-3, 2e-3}));
    // The origin of the IMU is 0.25 m above base_link, and the camera 0.5 m before it.
    const Eigen::Vector3d p_cam0 = r.cameras[0].cam_T_imu * Eigen::Vector3d::Zero();
    EXPECT_TRUE(p_cam0.isApprox(Eigen::Vector3d(0, -0.25, -0.5), 1e-12)) << p_cam0.transpose();
    const Eigen::Vector3d ahead = r.cameras[0].cam_T_imu * Eigen::Vector3d(2, 0, 0);
    EXPECT_TRUE(ahead.isApprox(Eigen::Vector3d(0, -0.25, 1.5), 1e-12)) << ahead.transpose();
    const Eigen::Vector3d p_cam1 = r.cameras[1].cam_T_imu * Eigen::Vector3d::Zero();
    EXPECT_TRUE(p_cam1.isApprox(Eigen::Vector3d(-0.1, -0.25, -0.5), 1e-12));
    expect_parts(r.remarks[0], {"cam0 is /cam0/image_raw", "/cam0/camera_info", "'imu_link'"});
    fs::remove(folder / "imu.yaml");
  }
}

TEST_F(Bag, WithoutCameraInfoItSaysWhatToAdd) {
  test::spill(folder / "imu.yaml", test::kKalibrImu);
  expect_parts(rejection(copy("none.bag", "walk.bag")),
               {"no sensor_msgs/CameraInfo on /cam0/camera_info", "Kalibr's files"});
}

// rosbag record --split.
TEST_F(Bag, SeveralBagsInAFolderAreOneRecording) {
  copy("none.bag", "parts/walk_0.bag");
  copy("lz4.bag", "parts/walk_1.bag");
  test::write_kalibr(folder / "parts");
  const Recording r = read_recording(folder / "parts");
  EXPECT_EQ(r.name, "parts");
  expect_the_walk(r);  // each message twice: the second is left out
  std::string remarks;
  for (const std::string& remark : r.remarks) remarks += remark + "\n";
  expect_parts(remarks,
               {"2 bags are read as one recording", "5 of 10 IMU samples repeat the time"});
}

std::string slurp_of(const std::string& name) { return test::slurp(written_bag(name)); }

TEST_F(Bag, BagsFarApartAreNotOneRecording) {
  const std::string bytes = slurp_of("none.bag");
  // The recording times of the messages of the second bag are an hour later.
  std::string later = bytes;
  for (std::size_t at = 0; (at = later.find("time=", at)) != std::string::npos; at += 5) {
    std::uint32_t seconds = 0;
    std::memcpy(&seconds, later.data() + at + 5, sizeof seconds);
    seconds += 3600;
    std::memcpy(later.data() + at + 5, &seconds, sizeof seconds);
  }
  test::write_kalibr(folder);
  test::spill(folder / "a.bag", bytes);
  test::spill(folder / "b.bag", later);
  expect_parts(rejection(folder), {"b.bag", "begins 3600 s after the end of a.bag", "name one"});
}

// `rosbag record` writes the index and its place when it ends.
TEST_F(Bag, ABagThatWasNotClosedIsReadUpToItsEnd) {
  test::write_kalibr(folder);
  std::string bytes = slurp_of("none.bag");
  const std::size_t place = bytes.find("index_pos=") + 10;
  std::uint64_t index = 0;
  std::memcpy(&index, bytes.data() + place, sizeof index);
  bytes.replace(place, 8, std::string(8, '\0'));
  test::spill(folder / "walk.bag.active", bytes.substr(0, index - 20));
  const Recording r = read_recording(folder / "walk.bag.active");
  expect_the_walk(r);
  expect_parts(r.remarks[0], {"walk.bag.active", "was not closed", "rosbag reindex"});
  // Space that the file system gave to the file before a crash.
  test::spill(folder / "walk.bag.active", bytes.substr(0, index) + std::string(4096, '\0'));
  expect_the_walk(read_recording(folder / "walk.bag.active"));
  test::spill(folder / "walk.bag.active", bytes.substr(0, 4200));
  expect_parts(rejection(folder / "walk.bag.active"), {"holds no message"});
}

TEST_F(Bag, AnMcapFileThatWasNotClosedIsReadUpToItsEnd) {
  test::write_kalibr(folder);
  const std::string bytes = slurp_of("streamed.mcap");
  test::spill(folder / "walk.mcap", bytes.substr(0, bytes.size() - 45));
  const Recording r = read_recording(folder / "walk.mcap");
  expect_the_walk(r);
  expect_parts(r.remarks[0], {"walk.mcap", "was not closed by its recorder"});
}

// A PNG of 12 bits in 16 lost its upper four bits, and so did every bright pixel.
TEST_F(Bag, OfCompressedImagesTheBitsInUseAreTaken) {
  cv::Mat image(6, 8, CV_16UC1, cv::Scalar(1000));
  image.at<std::uint16_t>(0, 1) = 3000;
  std::string message = test::message_header(kStamp);
  test::put_text(message, "mono16; png compressed");
  test::put_text(message, test::encoded(image));
  test::spill(folder / "walk.mcap",
              test::mcap_of("/cam0/compressed", "sensor_msgs/CompressedImage", {message}));
  const BagContents contents = scan_bags({folder / "walk.mcap"});
  const Camera camera{
      .width = 8, .height = 6, .fx = 4, .fy = 4, .cx = 3.5, .cy = 2.5, .cam_T_imu = {}};
  std::vector<std::string> remarks;
  const auto images =
      open_bag_images(contents.files, {&contents.topics[0]}, {camera}, {}, "walk.mcap", remarks);
  EXPECT_EQ(images->read(0).images[0].pixels[0], 1000 / 16);
  EXPECT_EQ(images->read(0).images[0].pixels[1], 3000 / 16);
  ASSERT_EQ(remarks.size(), 1u);
  expect_parts(remarks[0], {"cam0 have 16 bits and use 12"});
}

TEST_F(Bag, ManyMessagesOfALongNameTakeTimeInProportion) {
  const BombStopwatch quick;
  const std::string name = "/" + std::string(4000, 'n');
  const std::vector<std::string> messages(100'000);
  test::spill(folder / "a.mcap", test::mcap_of(name, "sensor_msgs/Imu", messages));
  const BagContents contents = scan_bags({folder / "a.mcap"});
  EXPECT_EQ(contents.topics.at(0).messages, messages.size());
  EXPECT_LT(contents.topics[0].damage.size(), 500u) << "the name is shortened";
  test::spill(folder / "a.mcap", test::mcap_of(name + name, "sensor_msgs/Imu", messages));
  expect_parts(input_error([&] { scan_bags({folder / "a.mcap"}); }),
               {"a.mcap: the name of a topic", "8002 bytes, expected at most 4096"});
}

TEST_F(Bag, StaticTransformsAreKeptOnceAndCounted) {
  const auto message = [](int frames, double x = 0) {
    std::string bytes;
    test::put(bytes, static_cast<std::uint32_t>(frames));
    for (int i = 0; i < frames; ++i) {
      bytes += test::message_header(kStamp);
      test::put_text(bytes, "frame" + std::to_string(i));
      for (int k = 0; k < 7; ++k) test::put(bytes, k == 0 ? x : k == 6 ? 1.0 : 0.0);
    }
    return bytes;
  };
  const auto scanned = [&](const std::vector<std::string>& messages) {
    test::spill(folder / "a.mcap", test::mcap_of("/tf_static", "tf2_msgs/TFMessage", messages));
    return scan_bags({folder / "a.mcap"});
  };
  const BombStopwatch quick;
  const BagContents repeated = scanned(std::vector<std::string>(100, message(50)));
  EXPECT_EQ(repeated.transforms.size(), 50u);
  EXPECT_EQ(repeated.topics.at(0).damage, "");
  const BagContents corrected = scanned({message(3), message(1, 0.2)});
  ASSERT_EQ(corrected.transforms.size(), 3u);
  EXPECT_EQ(corrected.transforms[0].parent_T_child.p.x(), 0.2) << "the last one counts";
  expect_parts(scanned({message(10'001)}).topics.at(0).damage,
               {"a.mcap: topic /tf_static: has more than 10000 static transforms"});
}

// The chain is read up to the cameras of the run.
TEST_F(Bag, OfALensThatIsNotReadTheOtherCamerasRun) {
  const fs::path path = copy("none.bag", "walk.bag");
  test::write_kalibr(folder);
  std::string chain = test::slurp(folder / "camchain-imucam.yaml");
  chain.replace(chain.rfind("pinhole"), 7, "cubic");
  test::spill(folder / "camchain-imucam.yaml", chain);
  expect_parts(rejection(path), {"camchain-imucam.yaml", "'cubic'"});
  EXPECT_EQ(read_recording(path, {.cameras = 1}).images->size(), 3u);
  test::spill(folder / "topics.yaml", "imu: /imu0\ncameras: [/cam0/image_raw, /cam1/image_raw]\n");
  EXPECT_EQ(read_recording(path, {.cameras = 1}).cameras.size(), 1u);
}

void make_database(const fs::path& file, const std::string& statements) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

TEST_F(Bag, ADatabaseThatComputesIsRejected) {
  const std::string topics =
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format);"
      "INSERT INTO topics VALUES (1, '/imu0', 'sensor_msgs/msg/Imu', 'cdr');";
  const std::string rows =
      "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 5000) ";
  make_database(folder / "view.db3",
                topics + "CREATE TABLE m(topic_id, timestamp, data);" + rows +
                    "INSERT INTO m SELECT 2, i, x'00' FROM n;" +
                    "CREATE VIEW messages AS SELECT a.rowid, a.topic_id, a.timestamp, a.data "
                    "FROM m a, m b, m c;");
  std::string sum = "topic_id";
  for (int i = 0; i < 900; ++i) sum += " + 1";
  make_database(folder / "sum.db3",
                topics + "CREATE TABLE messages(topic_id, data, timestamp AS (" + sum + "));" +
                    rows + "INSERT INTO messages SELECT 2, x'00' FROM n;");
  const BombStopwatch quick;
  expect_parts(input_error([&] { scan_bags({folder / "view.db3"}); }),
               {"view.db3: 'messages' is no table"});
  expect_parts(input_error([&] { scan_bags({folder / "sum.db3"}); }),
               {"sum.db3: reading takes more than", "steps"});
}

TEST_F(Bag, ChangedBytesAreFoundByTheCheckSums) {
  test::write_kalibr(folder);
  for (const char* name : {"none.mcap", "streamed.mcap"}) {
    std::string bytes = slurp_of(name);
    const std::size_t pixels = bytes.find("mono8");
    bytes[pixels + 30] = static_cast<char>(bytes[pixels + 30] ^ 1);
    test::spill(folder / "walk.mcap", bytes);
    expect_parts(rejection(folder / "walk.mcap"), {"walk.mcap", "the check sum of the"});
  }
}

TEST_F(Bag, WhatIsNoRecordingIsNamed) {
  test::write_kalibr(folder);
  std::string own("\x89MCAP0\r\n", 8), header;
  test::put_text(header, "");
  test::put_text(header, "chasles 1.2.3");
  own += '\1';
  test::put(own, std::uint64_t{header.size()});
  test::spill(folder / "run.mcap", own + header);
  expect_parts(rejection(folder / "run.mcap"), {"run.mcap", "`chasles export` wrote"});
  test::spill(folder / "old.bag", "#ROSBAG V1.2\n");
  expect_parts(rejection(folder / "old.bag"), {"rosbag fix"});
  fs::create_directories(folder / "empty");
  test::spill(folder / "empty" / "metadata.yaml",
              "rosbag2_bagfile_information:\n  relative_file_paths: [gone.db3]\n");
  test::write_kalibr(folder / "empty");
  expect_parts(rejection(folder / "empty"), {"no .db3 or .mcap file"});
}

// Messages as those of an image of a driver that does not set the stamps.
TEST_F(Bag, StampsThatWereNotSetAreRejected) {
  test::write_kalibr(folder);
  std::string bytes = slurp_of("none.bag");
  std::string stamp;
  test::put(stamp, std::uint32_t{1403636584});
  const auto unset = [&](const std::string& frame, int most) {
    std::string changed = bytes;
    for (std::size_t at = 0;
         most-- > 0 && (at = changed.find(frame, at + 1)) != std::string::npos;) {
      changed.replace(at - 12, 8, std::string(8, '\0'));
    }
    test::spill(folder / "walk.bag", changed);
    return folder / "walk.bag";
  };
  expect_parts(rejection(unset("cam0_optical", 3)), {"/cam0/image_raw", "of all 3 messages is 0"});
  expect_parts(rejection(unset("imu_link", 5)), {"/imu0", "of all 5 messages is 0"});
  const Recording r = read_recording(unset("imu_link", 1));
  EXPECT_EQ(r.imu.size(), 4u);
  expect_parts(r.remarks[0], {"1 of 5 messages of /imu0", "left out"});
}

TEST_F(Bag, LengthsAndOffsetsThatLeadElsewhereAreRejected) {
  test::write_kalibr(folder);
  const std::string bytes = slurp_of("none.bag");
  const auto error = [&](std::size_t at, const std::string& other) {
    std::string changed = bytes;
    test::spill(folder / "walk.bag", changed.replace(at, other.size(), other));
    return rejection(folder / "walk.bag");
  };
  const std::string kLong("\xff\xff\x00\x00", 4);
  const std::size_t chunk = bytes.find("compression=none");
  for (const std::size_t field : {chunk, bytes.find("topic=/imu0")}) {
    expect_parts(error(field - 4, kLong), {"walk.bag", "the bag is damaged", "at byte"});
  }
  expect_parts(error(bytes.find("index_pos=") + 10, kLong + kLong),
               {"the index is beyond the end"});
  expect_parts(error(chunk + 12, "zlib"), {"its compression is 'zlib'"});
  const std::size_t message = bytes.find("conn=", bytes.find("op=\x02", chunk));
  expect_parts(error(message + 5, kLong), {"connection 65535 is not known"});
}

TEST_F(Bag, EveryByteMayBeWrong) {
  test::write_kalibr(folder);
  for (const char* name : {"none.bag", "lz4.bag", "unchecked.mcap", "zstd.mcap"}) {
    const std::string bytes = slurp_of(name);
    int rejected = 0;
    for (std::size_t at = 8; at < bytes.size(); at += 11) {
      std::string changed = bytes;
      changed[at] = static_cast<char>(changed[at] ^ 0xff);
      test::spill(folder / "walk", changed);
      try {
        read_recording(folder / "walk");
      } catch (const InputError&) {
        ++rejected;
      }
    }
    EXPECT_GT(rejected, 30) << name;
  }
}

TEST_F(Bag, TruncatedBagsAreRejectedByName) {
  test::write_kalibr(folder);
  for (const char* name : {"none.bag", "bz2.bag"}) {
    const std::string bytes = slurp_of(name);
    for (std::size_t size = 13; size < bytes.size(); size += 1 + bytes.size() / 60) {
      test::spill(folder / "walk.bag", bytes.substr(0, size));
      expect_parts(rejection(folder / "walk.bag"), {"walk.bag"});
    }
  }
}

}  // namespace
}  // namespace chasles
