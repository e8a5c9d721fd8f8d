#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/column_names.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/image_decode.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/recording/image_names.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/imu_columns.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// The rows of a list as texts.
struct ListRows {
  std::vector<std::vector<std::string>> rows;  // of the same length
  std::vector<int> lines;
  std::optional<std::size_t> time;  // as the names of the columns state it
  std::vector<std::size_t> files;   // columns that may have the files' names, the better ones first
  std::optional<TimeScale> scale;
  std::string names;  // of the columns; empty without them
};

std::optional<long> whole_number(std::string_view text) {
  long value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || stop != text.data() + text.size()) return std::nullopt;
  return value;
}

bool is_number(const std::string& text) {
  return written_time(text, {.name = "", .digits = 0}).has_value();
}

// A line of names has neither a number nor the file of an image.
bool is_line_of_names(const CsvHeading& heading) {
  std::vector<std::string_view> values;
  split_names(heading.names, {.separator = heading.names_separator, .quotes = true}, values);
  return !heading.names.empty() && std::ranges::none_of(values, [](std::string_view value) {
    return is_number(std::string(value)) || is_image_name(std::string(value));
  });
}

CsvReader open_list(const std::string& file, std::string bytes, bool& named) {
  const CsvHeading heading = find_heading(bytes);
  named = is_line_of_names(heading);
  if (named) return {file, std::move(bytes)};
  std::vector<std::string_view> values;
  split_values(heading.first, heading.dialect, values);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < values.size(); ++i) names.push_back(fmt::format("{}", i + 1));
  return {file, std::move(bytes), CsvReader::NoHeading{heading.dialect}, names};
}

ListRows read_rows(const fs::path& list) {
  bool named = false;
  CsvReader csv = open_list(list.string(), read_plain_or_gzip(list), named);
  ListRows result;
  if (named) {
    result.names = fmt::format("{}", fmt::join(csv.headings(), ","));
    result.files = columns_named(csv, {"file", "filename", "file_name", "image_file", "image_name",
                                       "image_path", "path", "image", "name"});
    try {
      const TimeColumn time = find_time_column(csv);
      if (!time.fraction) {
        result.time = time.column;
        result.scale = time.scale;
      }
    } catch (const InputError&) {  // the rows decide
    }
  }
  while (csv.next()) {
    auto& row = result.rows.emplace_back();
    for (std::size_t i = 0; i < csv.columns().size(); ++i) row.emplace_back(csv.text(i));
    result.lines.push_back(csv.line());
  }
  return result;
}

// Whether the numbers of a column rise by one from row to row.
bool counts(const ListRows& list, std::size_t column) {
  for (std::size_t i = 0; i < list.rows.size(); ++i) {
    const auto value = whole_number(list.rows[i][column]);
    const auto first = whole_number(list.rows[0][column]);
    if (!value || !first || *value != *first + static_cast<long>(i)) return false;
  }
  return true;
}

std::string stem_of(const std::string& name) {
  const std::size_t slash = name.find_last_of("/\\");
  const std::string plain = slash == std::string::npos ? name : name.substr(slash + 1);
  return is_image_name(plain) ? fs::path(plain).stem().string() : plain;
}

// The column with the images' names: files, or their names without ending.
std::optional<std::size_t> column_of_names(const ListRows& list,
                                           const std::set<std::string>& stems) {
  const std::vector<std::string>& first = list.rows.front();
  const auto known = [&](std::size_t i) {
    return std::ranges::all_of(list.rows,
                               [&](const auto& row) { return stems.contains(stem_of(row[i])); });
  };
  // A column `name` may be that of the camera.
  for (const std::size_t i : list.files) {
    if (i != list.time && (is_image_name(first[i]) || known(i))) return i;
  }
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (is_image_name(first[i])) return i;
  }
  if (!list.files.empty()) return list.files.front();
  if (first.size() < 2) return std::nullopt;
  for (std::size_t i = 0; i < first.size(); ++i) {
    if (i != list.time && known(i)) return i;
  }
  return std::nullopt;
}

[[noreturn]] void no_column_of_times(const fs::path& list, const ListRows& rows) {
  throw InputError(
      fmt::format("{}:{}: found '{}'{}, expected a time and the file of an image, as "
                  "`1403636584763555584 0.png`, or times alone",
                  list.string(), rows.lines.front(), fmt::join(rows.rows.front(), " "),
                  rows.names.empty() ? "" : fmt::format(" below the names {}", rows.names)));
}

std::size_t column_of_times(const fs::path& list, const ListRows& rows,
                            const std::optional<std::size_t>& names) {
  if (rows.time) return *rows.time;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < rows.rows.front().size(); ++i) {
    if (i != names && is_number(rows.rows.front()[i])) numbers.push_back(i);
  }
  if (numbers.size() > 1) std::erase_if(numbers, [&](std::size_t i) { return counts(rows, i); });
  if (numbers.size() != 1) no_column_of_times(list, rows);
  return numbers.front();
}

// The column that numbers the images; none without one.
std::optional<std::size_t> column_of_numbers(const ListRows& list, std::size_t time) {
  for (std::size_t i = 0; i < list.rows.front().size(); ++i) {
    if (i != time && counts(list, i)) return i;
  }
  return std::nullopt;
}

std::vector<Time> times_of(const fs::path& list, const ListRows& rows, std::size_t column,
                           const std::string& camera, std::vector<std::string>& remarks) {
  const auto where = [&](std::size_t i) {
    return fmt::format("{}:{}", list.string(), rows.lines[i]);
  };
  std::vector<Time> times;
  if (!rows.scale || rows.scale->digits == 0) {
    std::vector<std::string_view> texts;
    for (const auto& row : rows.rows) texts.emplace_back(row[column]);
    ColumnTimes read =
        rows.scale ? read_nanoseconds(texts, where) : read_unscaled_times(texts, where);
    std::string remark =
        times_remark(fmt::format("{} of {}", list.filename().string(), camera), read);
    if (!remark.empty()) remarks.push_back(std::move(remark));
    return std::move(read.times);
  }
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const auto time = written_time(rows.rows[i][column], *rows.scale);
    if (!time) {
      throw InputError(fmt::format("{}: found '{}', expected a time in {} up to the year 2115",
                                   where(i), rows.rows[i][column], rows.scale->name));
    }
    times.push_back(time->time);
  }
  return times;
}

// Which number the first line is for, where no column states it: 0, or 1 if the last image has the
// number of lines. Throws where the numbers leave both open.
long first_number(const fs::path& list, std::size_t lines,
                  const std::map<long, std::string>& files) {
  if (files.empty() || files.begin()->first != 1) return 0;
  const long last = files.rbegin()->first;
  if (last >= static_cast<long>(lines)) return 1;
  throw InputError(fmt::format(
      "{}: has {} times, and the images are numbered from 1 to {} ({} to {}): is the first time "
      "that of {}, or that of an image 0 which is missing? Expected a time for each image, with "
      "the "
      "file's name beside it",
      list.string(), lines, last, files.begin()->second, files.rbegin()->second,
      files.begin()->second));
}

// By number: line i, or the line that states i, is for the image of that number. In order if there
// are as many lines as images.
std::vector<StampedFile> by_number(const fs::path& list, const ListRows& rows,
                                   const std::vector<Time>& times,
                                   const std::optional<std::size_t>& numbers,
                                   const std::vector<NumberedImage>& images,
                                   std::vector<std::string>& remarks) {
  std::map<long, std::string> files;
  for (const NumberedImage& image : images) {
    if (image.ordinal) files.emplace(*image.ordinal, image.file);
  }
  const bool in_order = times.size() == images.size();
  const long first = numbers || in_order ? 0 : first_number(list, times.size(), files);
  std::vector<StampedFile> found;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto stated = numbers ? whole_number(rows.rows[i][*numbers]) : std::nullopt;
    const auto file = files.find(stated.value_or(first + static_cast<long>(i)));
    if (file != files.end()) found.push_back({.time = times[i], .file = file->second});
  }
  if (in_order && found.size() < images.size()) {  // from 1, or by time
    found.clear();
    for (std::size_t i = 0; i < times.size(); ++i) {
      found.push_back({.time = times[i], .file = images[i].file});
    }
  }
  if (found.size() < images.size()) {
    throw InputError(fmt::format(
        "{}: has {} times, and the folder {} images ({} to {}): expected a time for each, with the "
        "file's name beside it",
        list.string(), times.size(), images.size(), images.front().file, images.back().file));
  }
  if (found.size() < times.size()) {
    remarks.push_back(fmt::format("{} of {} times of {} have no image: left out",
                                  times.size() - found.size(), times.size(),
                                  list.filename().string()));
  }
  return found;
}

}  // namespace

std::vector<Time> read_time_list(const fs::path& list, std::vector<std::string>& remarks) {
  const ListRows rows = read_rows(list);
  if (rows.rows.empty()) {
    throw InputError(
        fmt::format("{}: lists no time, expected one for each picture", list.string()));
  }
  return times_of(list, rows, column_of_times(list, rows, std::nullopt), "the video", remarks);
}

CameraFiles read_image_list(const fs::path& list, const CameraPlace& place,
                            std::vector<std::string>& remarks) {
  const ListRows rows = read_rows(list);
  CameraFiles files{.folder = place.images, .images = {}};
  if (rows.rows.empty()) {
    throw InputError(fmt::format("{}: lists no image, expected rows `time,file`", list.string()));
  }
  const std::vector<NumberedImage> images = images_in(place.images);
  std::map<std::string, std::string> by_stem;
  std::set<std::string> stems;
  for (const NumberedImage& image : images) {
    by_stem.emplace(stem_of(image.file), image.file);
    stems.insert(stem_of(image.file));
  }
  const auto names = column_of_names(rows, stems);
  const std::size_t time = column_of_times(list, rows, names);
  const std::vector<Time> times = times_of(list, rows, time, place.name, remarks);
  if (!names) {
    files.images = by_number(list, rows, times, column_of_numbers(rows, time), images, remarks);
    return files;
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    const std::string& name = rows.rows[i][*names];
    const auto known = by_stem.find(name);
    const bool ending = is_image_name(fs::path(name).filename().string());
    files.images.push_back(
        {.time = times[i], .file = ending || known == by_stem.end() ? name : known->second});
  }
  return files;
}

}  // namespace chasles
