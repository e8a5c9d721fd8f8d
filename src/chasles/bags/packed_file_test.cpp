#include <bzlib.h>
#include <zlib.h>
#include <zstd.h>

#include <lz4frame.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/bag_paths.hpp>
#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;
using test::written_bag;

std::string packed_whole(const std::string& text, const std::string& ending) {
  std::string bytes(text.size() + text.size() / 50 + 10'000, '\0');
  std::size_t size = 0;
  if (ending == ".bz2") {
    auto length = static_cast<unsigned>(bytes.size());
    std::string source = text;
    BZ2_bzBuffToBuffCompress(bytes.data(), &length, source.data(),
                             static_cast<unsigned>(source.size()), 9, 0, 0);
    size = length;
  } else if (ending == ".lz4") {
    size = LZ4F_compressFrame(bytes.data(), bytes.size(), text.data(), text.size(), nullptr);
  } else if (ending == ".gz") {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, MAX_WBITS + 16, 8, Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<unsigned>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<unsigned>(bytes.size());
    deflate(&stream, Z_FINISH);
    size = stream.total_out;
    deflateEnd(&stream);
  } else {
    size = ZSTD_compress(bytes.data(), bytes.size(), text.data(), text.size(), 3);
  }
  return bytes.substr(0, size);
}

const std::vector<std::string> kPackings{".zstd", ".zst", ".gz", ".bz2", ".lz4"};

/// Temporary files go into a folder of their own, which must be empty in the end.
class PackedBag : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(temporary);
    fs::create_directories(folder);
    ::setenv("TMPDIR", temporary.c_str(), 1);
    test::write_kalibr(folder);
  }
  void TearDown() override {
    ::unsetenv("TMPDIR");
    EXPECT_TRUE(fs::is_empty(temporary)) << "a temporary file was left";
  }
  std::string rejection(const fs::path& path) {
    return input_error([&] { read_recording(path); });
  }
  fs::path put(const std::string& name, const std::string& bytes) {
    fs::create_directories((folder / name).parent_path());
    test::spill(folder / name, bytes);
    return folder / name;
  }
  static std::string content(const std::string& bag) { return test::slurp(written_bag(bag)); }

  fs::path scratch = test::scratch(), folder = scratch / "walk", temporary = scratch / "tmp";
};

void expect_read(const Recording& r) {
  ASSERT_EQ(r.imu.size(), 5u);
  EXPECT_EQ(r.imu[3].angular_rate_imu, Eigen::Vector3d(0.1, -0.2, 3.3));
  ASSERT_EQ(r.images->size(), 3u);
  EXPECT_EQ(r.images->read(2).images[0].pixels[3], test::shade_of(0, 2) + 3);
}

TEST_F(PackedBag, IsReadInEveryPacking) {
  for (const char* bag : {"none.bag", "none.mcap", "db3/db3.db3"}) {
    const fs::path name = fs::path(bag).filename();
    for (const std::string& ending : kPackings) {
      const fs::path file = put(name.string() + ending, packed_whole(content(bag), ending));
      const Recording r = read_recording(file);
      EXPECT_TRUE(fs::is_empty(temporary)) << "it is gone before the bag is closed";
      EXPECT_EQ(r.name, name.stem().string());
      expect_read(r);
      expect_parts(r.remarks.at(0), {file.string(), "compressed as a whole", "temporary file"});
      fs::remove(file);
    }
  }
}

TEST_F(PackedBag, OfSeveralStreamsIsReadWhole) {
  const std::string bag = content("none.bag");
  for (const std::string& ending : kPackings) {
    std::string parts;
    for (std::size_t i = 0; i < bag.size(); i += 3000) {
      parts += packed_whole(bag.substr(i, 3000), ending);
    }
    expect_read(read_recording(put("walk.bag" + ending, parts)));
    fs::remove(folder / ("walk.bag" + ending));
  }
}

// gzip itself ignores zeros behind the last stream.
TEST_F(PackedBag, MayBePaddedWithZeros) {
  for (const std::string& ending : kPackings) {
    const std::string bytes = packed_whole(content("none.bag"), ending);
    for (const std::size_t zeros : {std::size_t{1}, std::size_t{512}, std::size_t{300'000}}) {
      expect_read(read_recording(put("walk.bag" + ending, bytes + std::string(zeros, '\0'))));
    }
    for (const std::string& behind : {std::string("x"), bytes}) {
      const fs::path file = put("walk.bag" + ending, bytes + std::string(200'000, '\0') + behind);
      expect_parts(rejection(file), {"walk.bag" + ending, "further bytes come after zeros"});
    }
    fs::remove(folder / ("walk.bag" + ending));
  }
}

TEST_F(PackedBag, ThatIsTruncatedOrDamagedIsRejected) {
  for (const std::string& ending : kPackings) {
    const std::string bytes = packed_whole(content("none.bag"), ending);
    for (std::size_t size = 12; size < bytes.size(); size += 1 + bytes.size() / 20) {
      const fs::path file = put("walk.bag" + ending, bytes.substr(0, size));
      expect_parts(input_error([&] { read_bag_recording(file); }),
                   {"walk.bag" + ending, "cannot be unpacked", "truncated"});
    }
    std::string damaged = bytes;
    for (std::size_t i = bytes.size() / 3; i < bytes.size() / 3 + 40; ++i) damaged[i] = '\x7f';
    expect_parts(input_error([&] { read_bag_recording(put("walk.bag" + ending, damaged)); }),
                 {"walk.bag" + ending, "damaged"});
    fs::remove(folder / ("walk.bag" + ending));
  }
}

// Gigabytes of zeros in a few kilobytes.
TEST_F(PackedBag, OfMoreThanTheBudgetIsRejected) {
  ::setenv("CHASLES_READ_MEMORY", "100K", 1);
  const std::string bag = content("none.bag") + std::string(20'000'000, '\0');
  const fs::path file = put("walk.bag.zst", packed_whole(bag, ".zst"));
  expect_parts(input_error([&] { read_bag_recording(file); }),
               {"walk.bag.zst", "come out of it, expected at most"});
  ::unsetenv("CHASLES_READ_MEMORY");
}

TEST_F(PackedBag, NeedsAFolderForTemporaryFiles) {
  const fs::path file = put("walk.bag.gz", packed_whole(content("none.bag"), ".gz"));
  ::setenv("TMPDIR", "/proc/sys", 1);
  expect_parts(rejection(file), {"walk.bag.gz", "temporary file", "/proc/sys", "set TMPDIR"});
}

TEST_F(PackedBag, WhatIsNoBagIsNamed) {
  expect_parts(rejection(put("walk.zst", packed_whole("abc", ".zst"))),
               {"walk.zst", "compressed as a whole (zstd)", "of no known kind"});
  expect_parts(rejection(put("walk.gz", packed_whole("ULog\x01 of a flight", ".gz"))),
               {"walk.gz", "flight log of PX4"});
  const fs::path bag = put("walk.bag.gz", packed_whole("abc", ".gz"));
  expect_parts(input_error([&] { read_bag_recording(bag); }),
               {"walk.bag.gz: unpacked (gz as a whole) is no bag by its first bytes"});
}

void write_metadata(const fs::path& folder, const std::string& listed) {
  test::spill(folder / "metadata.yaml",
              "rosbag2_bagfile_information:\n  relative_file_paths: [" + listed + "]\n");
}

// After `zstd -d` metadata.yaml still names the compressed file.
TEST_F(PackedBag, ThePlainFileHasPrecedence) {
  const std::string bytes = content("none.mcap"), packed = packed_whole(bytes, ".zstd");
  put("walk_0.mcap.zstd", packed);
  write_metadata(folder, "walk_0.mcap.zstd");
  EXPECT_EQ(find_bag_files(folder).files, std::vector<fs::path>{folder / "walk_0.mcap.zstd"});
  expect_read(read_recording(folder));
  put("walk_0.mcap", bytes);
  BagPaths both = find_bag_files(folder);
  EXPECT_EQ(both.files, std::vector<fs::path>{folder / "walk_0.mcap"});
  expect_parts(both.remarks.at(0), {"lists walk_0.mcap.zstd; walk_0.mcap is there"});
  fs::remove(folder / "walk_0.mcap.zstd");
  EXPECT_EQ(find_bag_files(folder).files, std::vector<fs::path>{folder / "walk_0.mcap"});
  expect_read(read_recording(folder));
  // Packed by hand.
  write_metadata(folder, "walk_0.mcap");
  fs::rename(folder / "walk_0.mcap", folder / "plain");
  put("walk_0.mcap.zst", packed);
  EXPECT_EQ(find_bag_files(folder).files, std::vector<fs::path>{folder / "walk_0.mcap.zst"});
}

TEST_F(PackedBag, AFolderWithoutMetadataIsRead) {
  fs::remove(folder / "imu.yaml");
  fs::remove(folder / "camchain-imucam.yaml");
  put("walk_0.mcap.zstd", packed_whole(content("none.mcap"), ".zstd"));
  EXPECT_TRUE(is_bag_folder(folder));
  expect_parts(rejection(folder), {"neither camchain-imucam.yaml nor imu.yaml"});
  test::write_kalibr(scratch);
  for (const fs::path& given : {folder, folder / "walk_0.mcap.zstd"}) {
    const Recording r = read_recording(given);
    expect_read(r);
    expect_parts(r.remarks.at(0), {"walk has no calibration: that of the folder above"});
  }
  put("walk_0.mcap", content("none.mcap"));
  const BagPaths both = find_bag_files(folder);
  EXPECT_EQ(both.files, std::vector<fs::path>{folder / "walk_0.mcap"});
  expect_parts(both.remarks.at(0), {"walk_0.mcap is there beside walk_0.mcap.zstd"});
  // A file of another name may lie anywhere, and what is above it is not its own.
  const fs::path other = put("other.bag", content("none.bag"));
  expect_parts(rejection(other), {"neither camchain-imucam.yaml nor imu.yaml"});
}

}  // namespace
}  // namespace chasles
