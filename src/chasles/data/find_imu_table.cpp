#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include <chasles/data/gzip.hpp>
#include <chasles/data/imu_columns.hpp>
#include <chasles/data/imu_table.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

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
  if (bytes.find('\0') != std::string::npos) return {};
  bytes.resize(bytes.rfind('\n') + 1);  // npos + 1 is 0
  remove_byte_order_mark(bytes);
  return bytes;
}

bool is_table_name(const fs::path& file) {
  constexpr std::array<std::string_view, 3> kEndings{".csv", ".txt", ".tsv"};
  const std::string ending = lower_case(file.extension().string());
  return !file.filename().string().starts_with(".") &&
         std::ranges::find(kEndings, std::string_view(ending)) != kEndings.end();
}

}  // namespace

bool is_imu_table(const fs::path& file) {
  std::string bytes = first_lines(file);
  if (bytes.empty()) return false;
  if (is_ros2_echo(bytes)) return true;
  try {
    find_imu_columns(CsvReader(file.string(), std::move(bytes)));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::optional<fs::path> find_imu_table(const fs::path& folder, std::vector<std::string>& remarks) {
  for (const char* name : {"imu.csv", "imu0.csv"}) {
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
  if (found.empty()) return std::nullopt;
  std::ranges::sort(found);
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
