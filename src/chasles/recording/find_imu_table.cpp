#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/imu_columns.hpp>
#include <chasles/recording/imu_table.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The whole lines among the first bytes of a file; empty for one that is no text.
std::string first_lines(const fs::path& file) {
  constexpr std::size_t kBytes = 65536;
  std::string bytes(kBytes, '\0');
  std::ifstream stream(file, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(kBytes));
  bytes.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  if (is_gzip(bytes)) bytes = read_plain_or_gzip(file).substr(0, kBytes);
  if (bytes.find('\0') != std::string::npos) return {};
  bytes.resize(bytes.rfind('\n') + 1);  // npos + 1 is 0
  remove_byte_order_mark(bytes);
  return bytes;
}

bool is_table_name(const fs::path& file) {
  constexpr std::array<std::string_view, 3> kEndings{".csv", ".txt", ".tsv"};
  fs::path plain = file;
  if (lower_case(plain.extension().string()) == ".gz") plain.replace_extension();
  const std::string ending = lower_case(plain.extension().string());
  return !file.filename().string().starts_with(".") &&
         std::ranges::find(kEndings, std::string_view(ending)) != kEndings.end();
}

// Of a table and its compressed copy the plain one is read.
void leave_out_copies(std::vector<fs::path>& sorted) {
  std::erase_if(sorted, [all = sorted](const fs::path& file) {
    return lower_case(file.extension().string()) == ".gz" &&
           std::ranges::find(all, file.parent_path() / file.stem()) != all.end();
  });
}

void reject_packed_table(const fs::path& folder) {
  constexpr std::array<std::pair<const char*, const char*>, 4> kPackers{
      std::pair(".bz2", "bunzip2"), std::pair(".xz", "unxz"), std::pair(".zst", "unzstd"),
      std::pair(".zip", "unzip")};
  for (const char* name : {"imu.csv", "imu0.csv"}) {
    for (const auto& [ending, command] : kPackers) {
      const fs::path file = folder / (std::string(name) + ending);
      if (!fs::exists(file)) continue;
      throw InputError(
          fmt::format("{}: is compressed, expected a plain or gzip-compressed table: `{} {}`",
                      file.string(), command, file.filename().string()));
    }
  }
}

}  // namespace

bool is_imu_table(const fs::path& file) {
  try {
    std::string bytes = first_lines(file);
    if (bytes.empty()) return false;
    if (is_ros2_echo(bytes)) return true;
    find_imu_columns(CsvReader(file.string(), std::move(bytes)));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::optional<fs::path> find_imu_table(const fs::path& folder, std::vector<std::string>& remarks) {
  for (const char* name : {"imu.csv", "imu0.csv", "imu.csv.gz", "imu0.csv.gz"}) {
    if (fs::exists(folder / name)) return folder / name;
  }
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (entry.is_regular_file(ignored) && is_table_name(entry.path()) &&
        is_imu_table(entry.path())) {
      found.push_back(entry.path());
    }
  }
  if (found.empty()) {
    reject_packed_table(folder);
    return std::nullopt;
  }
  std::ranges::sort(found);
  leave_out_copies(found);
  if (found.size() > 1) {
    throw InputError(fmt::format(
        "{}: both {} and {} are tables of an IMU, expected one: name the right one imu.csv",
        folder.string(), found[0].filename().string(), found[1].filename().string()));
  }
  remarks.push_back(fmt::format("the samples of the IMU are those of {}: there is no imu.csv",
                                found[0].filename().string()));
  return found[0];
}

}  // namespace chasles
