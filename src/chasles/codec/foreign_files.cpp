#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>

#include <chasles/codec/foreign_files.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

using std::string_view_literals::operator""sv;

/// What a file is by bytes at a place of it.
struct Signature {
  std::size_t at;
  std::string_view bytes;
  std::string_view what;
};

constexpr std::string_view kVideo =
    "a video that is no MP4: copy its pictures into one with `ffmpeg -i FILE -c copy NEW.mp4`, and "
    "put the samples of the IMU and a calibration beside it (docs/videos.md)";
constexpr std::string_view kPicture =
    "a single image: give the folder of a recording (docs/your-recording.md)";
constexpr std::string_view kArchive = "an archive: unpack it, and give the folder";
constexpr std::string_view kHdf5 =
    "an HDF5 file, which may hold anything: write its images into images/cam0 and its samples into "
    "imu.csv (docs/your-recording.md)";

constexpr std::string_view kColmap =
    "a part of a model of COLMAP, which has poses and points but neither times nor an IMU: give "
    "the "
    "recording that its images come from";

constexpr std::array kSignatures{
    Signature{8, "AVI ", kVideo},
    Signature{0, "\x1a\x45\xdf\xa3", kVideo},
    Signature{0, "\x89PNG", kPicture},
    Signature{0, "\xff\xd8\xff", kPicture},
    Signature{0, "7z\xbc\xaf\x27\x1c", kArchive},
    Signature{0, "Rar!", kArchive},
    Signature{0,
              "\xfd"sv
              "7zXZ",
              "a file compressed with xz: unpack it (unxz), and give what it holds"},
    Signature{257, "ustar", kArchive},
    Signature{0, "ULog\x01",
              "a flight log of PX4 (ULog), which has no images: a run needs the images of a camera "
              "beside; `ulog2csv` (pip install pyulog) writes the samples of its IMU as tables"},
    Signature{
        0, "\xa3\x95",
        "a flight log of ArduPilot (DataFlash), which has no images: a run needs the images "
        "of a camera beside; `mavlogdump.py --format csv --types IMU` (pip install pymavlink) "
        "writes the samples of its IMU"},
    Signature{0, "VisionRe",
              "a VRS recording, as of Project Aria: `vrs extract-all FILE --to FOLDER` writes its "
              "images and samples; put them into images/cam0 and imu.csv, with a calibration "
              "(docs/your-recording.md)"},
    Signature{0, "RRF",
              "a recording of the Rerun viewer (.rrd): give the recording that was logged; what it "
              "shows, chasles does not read"},
    Signature{0, "PAR1",
              "a Parquet table: write it as CSV, as by pandas.read_parquet(FILE).to_csv('imu.csv', "
              "index=False), with the column names of docs/formats.md"},
    Signature{0, "\x93NUMPY",
              "a single NumPy array, whose columns have no names: write it as a table, as by "
              "numpy.savetxt('imu.csv', a, delimiter=',', comments='', "
              "header='time_ns,wx,wy,wz,ax,ay,az')"},
    Signature{0, "#!AER-DAT",
              "a recording of an event camera (AEDAT): export its frames into images/cam0 and its "
              "samples into imu.csv (docs/your-recording.md)"},
    Signature{0, "\xd4\xc3\xb2\xa1", "a capture of network packets (pcap), no recording of images"},
    Signature{0, "\x0a\x0d\x0d\x0a", "a capture of network packets (pcap), no recording of images"},
    Signature{0, "ply\n", "a point cloud or a mesh (PLY), no recording"},
    Signature{0, "# .PCD", "a point cloud (PCD), no recording"},
    Signature{0, "# Image list with", kColmap},
    Signature{0, "# Camera list with", kColmap},
    Signature{0, "# 3D point list with", kColmap},
    Signature{0, "%PDF", "a PDF document, no recording"},
    Signature{0, "\x00\x05\x16\x07"sv,
              "a file that macOS writes beside another (._NAME): give the one without ._"}};

/// What a file is by the end of its name, in small letters.
struct NameEnding {
  std::string_view ending;
  std::string_view what;
};

constexpr std::array kNameEndings{
    NameEnding{".insv",
               "a video of a 360-degree camera (Insta360): export the images of each lens into "
               "images/cam0 and images/cam1 and the samples of its IMU into imu.csv "
               "(docs/your-recording.md)"},
    NameEnding{".svo",
               "a recording of a ZED camera (SVO): play it with the ZED wrapper of ROS 2 "
               "(svo_path:=FILE), record images and IMU as a bag, and give the bag"},
    NameEnding{".svo2",
               "a recording of a ZED camera (SVO2): play it with the ZED wrapper of ROS 2 "
               "(svo_path:=FILE), record images and IMU as a bag, and give the bag"},
    NameEnding{".tar", kArchive},
    NameEnding{".tar.gz", kArchive},
    NameEnding{".tgz", kArchive},
    NameEnding{".tar.bz2", kArchive},
    NameEnding{".tar.zst", kArchive},
    NameEnding{".tar.xz", kArchive},
    NameEnding{".h5", kHdf5},
    NameEnding{".hdf5", kHdf5},
    NameEnding{".yaml", "a calibration or a configuration: give the folder of the recording"},
    NameEnding{".yml", "a calibration or a configuration: give the folder of the recording"}};

std::string text_of_bytes(std::string_view bytes) {
  return lower_case(bytes.substr(std::min(bytes.find_first_not_of(" \t\r\n"), bytes.size())));
}

std::string_view by_json(std::string_view bytes) {
  const std::string text = text_of_bytes(bytes);
  const std::size_t next = text.find_first_not_of(" \t\r\n", 1);
  const char after = next == std::string::npos ? '\0' : text[next];
  if ((text.starts_with('{') && (after == '"' || after == '}')) ||
      (text.starts_with('[') && (after == '{' || after == '['))) {
    return "a file of JSON, whose fields have no agreed names: write its samples into imu.csv and "
           "its images into images/cam0 (docs/your-recording.md)";
  }
  return {};
}

// The name of the first file in a zip archive.
std::string_view first_in_zip(std::string_view bytes) {
  constexpr std::size_t kHeader = 30, kLength = 26;
  if (!bytes.starts_with("PK\x03\x04") || bytes.size() < kHeader) return {};
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i]));
  };
  return bytes.substr(kHeader, byte(kLength) + 256 * byte(kLength + 1));
}

std::optional<std::string> by_zip(std::string_view bytes) {
  const std::string_view packed = first_in_zip(bytes);
  if (packed.empty() || packed.find(".npy") != std::string_view::npos) return std::nullopt;
  if (packed == "[Content_Types].xml") {
    return "looks like a spreadsheet or a document of an office program: save the table as CSV, "
           "with all digits of the times";
  }
  return fmt::format("looks like a zip archive of {}: unzip it, and give the folder", packed);
}

}  // namespace

std::string_view stand_in(std::string_view bytes) {
  if (bytes.starts_with("version https://git-lfs.github.com/spec/")) {
    return "a pointer of Git LFS, not the file itself: `git lfs pull` in its repository gets the "
           "file";
  }
  if (bytes.starts_with("/annex/objects/")) {
    return "a pointer of git-annex, not the file itself: `git annex get FILE` gets it";
  }
  const std::string text = text_of_bytes(bytes);
  for (const std::string_view page : {"<!doctype html", "<html", "<?xml", "<head", "<!--"}) {
    if (!text.starts_with(page)) continue;
    return "a web page, not the file itself: the download needed a login or a confirmation; "
           "download it in a browser, and compare the size with the page's";
  }
  return {};
}

std::optional<std::string> foreign_file(const std::filesystem::path& file,
                                        const std::string& first_bytes) {
  if (first_bytes.empty()) {
    return "is empty: the recording or the copy of it broke off before its first byte";
  }
  const auto resembles = [](std::string_view what) { return fmt::format("looks like {}", what); };
  if (const std::string_view what = stand_in(first_bytes); !what.empty()) return resembles(what);
  const std::string name = lower_case(file.filename().string());
  const bool hdf5 = first_bytes.starts_with("\x89HDF");
  for (const NameEnding& known : kNameEndings) {
    // A .mat file of MATLAB 7.3 is one too.
    if (name.ends_with(known.ending) && (hdf5 || known.what != kHdf5)) return resembles(known.what);
  }
  for (const Signature& known : kSignatures) {
    if (std::string_view(first_bytes)
            .substr(std::min(known.at, first_bytes.size()))
            .starts_with(known.bytes)) {
      return resembles(known.what);
    }
  }
  if (const std::string_view what = by_json(first_bytes); !what.empty()) return resembles(what);
  return by_zip(first_bytes);
}

}  // namespace chasles
