#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <numeric>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/codec/foreign_files.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr std::string_view kBlanks = " \t\r\f\v";

// Insertions, deletions and replacements that turn a into b.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

// Of a repository without its large files.
void check_no_pointer(const std::filesystem::path& file, std::string_view bytes) {
  constexpr std::size_t kLargest = 1024;  // of a pointer
  if (bytes.size() > kLargest || bytes.starts_with('<')) return;
  const std::string_view what = stand_in(bytes);
  if (what.find("pointer") == std::string_view::npos) return;
  throw InputError(fmt::format("{}: is {}", file.string(), what));
}

std::string_view without_group(std::string_view name) {
  return name.substr(name.rfind('.') + 1);  // all of it, where there is no dot
}

}  // namespace

void check_regular_file(const std::filesystem::path& file) {
  std::error_code ignored;
  const std::filesystem::file_status status = std::filesystem::status(file, ignored);
  if (std::filesystem::is_regular_file(status)) return;
  if (!std::filesystem::exists(status)) {
    throw InputError(fmt::format("{}: no such file", file.string()));
  }
  if (std::filesystem::is_directory(status)) {
    throw InputError(fmt::format("{}: is a folder, expected a file", file.string()));
  }
  throw InputError(
      fmt::format("{}: is a pipe or a device, expected a regular file", file.string()));
}

std::string read_file(const std::filesystem::path& file) {
  check_regular_file(file);
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) {
    throw InputError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  }
  const std::streamoff size = stream.tellg();
  if (size > 0) {
    const auto bytes = static_cast<std::size_t>(size);
    check_memory(fmt::format("{}: has {} bytes", file.string(), bytes), bytes);
  }
  std::string bytes(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  stream.seekg(0);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    throw InputError(fmt::format("{}: cannot be read to its end", file.string()));
  }
  check_no_pointer(file, bytes);
  return bytes;
}

std::string read_text(const std::filesystem::path& file) {
  std::string text = read_file(file);
  remove_byte_order_mark(text);
  return text;
}

void remove_byte_order_mark(std::string& text) {
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
}

namespace {

template <typename Write>
void with_file(const std::filesystem::path& file, const Write& write) {
  const int descriptor = open_to_write(file);
  try {
    write(descriptor);
  } catch (const UsageError&) {
    ::close(descriptor);
    throw;
  }
  if (::close(descriptor) == 0) return;
  throw UsageError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
}

}  // namespace

void write_file(const std::filesystem::path& file, std::string_view bytes) {
  with_file(file, [&](int descriptor) { write_all(descriptor, bytes, file); });
}

void write_parts(const std::filesystem::path& file,
                 const std::function<bool(std::string& part)>& next) {
  with_file(file, [&](int descriptor) {
    for (std::string part; next(part); part.clear()) write_all(descriptor, part, file);
  });
}

void write_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                 std::string_view rows) {
  std::string bytes = fmt::format("{}\n", fmt::join(columns, ","));
  write_file(file, bytes.append(rows));
}

void remove_file(const std::filesystem::path& file) {
  std::error_code error;
  std::filesystem::remove(file, error);
  if (error) {
    throw UsageError(fmt::format("{}: cannot be removed: {}", file.string(), error.message()));
  }
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw UsageError(fmt::format("{}: the folder cannot be made: {}", folder.string(),
                                 error ? error.message() : "a file of that name is in the way"));
  }
}

std::string did_you_mean(std::string_view name, const std::vector<std::string>& known) {
  const std::string wanted = lower_case(name);
  std::vector<std::string_view> nearest;
  std::size_t least = std::max<std::size_t>(1, name.size() / 2) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance =
        std::min(edit_distance(wanted, lower_case(candidate)),
                 edit_distance(wanted, lower_case(without_group(candidate))));
    const bool same =
        !nearest.empty() && without_group(nearest.front()) == without_group(candidate);
    if (distance < least) nearest.clear();
    if (distance < least || (distance == least && same)) nearest.push_back(candidate);
    least = std::min(least, distance);
  }
  if (nearest.empty()) return {};
  return fmt::format("; did you mean '{}'?", fmt::join(nearest, "' or '"));
}

std::string quoted_list(const std::vector<std::string>& names) {
  constexpr std::size_t kMostNames = 30;
  if (names.empty()) return "nothing";
  const std::size_t shown = std::min(names.size(), kMostNames);
  const auto end = names.begin() + static_cast<std::ptrdiff_t>(shown);
  const std::string list = fmt::format("'{}'", fmt::join(names.begin(), end, "', '"));
  return shown == names.size() ? list : fmt::format("{} and {} more", list, names.size() - shown);
}

std::string_view take_line(std::string_view& text) {
  interruption_point();
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = trimmed(line); !line.empty();) {
    const std::size_t end = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, end));
    line = trimmed(line.substr(end));
  }
  return words;
}

}  // namespace chasles
