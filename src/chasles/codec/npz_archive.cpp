#include <algorithm>
#include <zip.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/npz_archive.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr std::size_t kPiece = 32768;  // numbers

using ZipFile = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

// Reads exactly `size` bytes.
void read_exactly(const ZipFile& entry, char* bytes, std::size_t size, const std::string& where) {
  for (std::size_t done = 0; done < size;) {
    const zip_int64_t got = zip_fread(entry.get(), bytes + done, size - done);
    if (got < 0) {
      throw InputError(fmt::format("{}: cannot be decompressed: {} (is the file damaged?)", where,
                                   zip_file_strerror(entry.get())));
    }
    if (got == 0) {
      throw InputError(fmt::format("{}: ends early, {} bytes are missing (is the file truncated?)",
                                   where, size - done));
    }
    done += static_cast<std::size_t>(got);
  }
}

// libzip compares the check sum only at the end.
void check_end(const ZipFile& entry, const std::string& where) {
  char byte = 0;
  const zip_int64_t got = zip_fread(entry.get(), &byte, 1);
  if (got > 0) throw InputError(where + ": has bytes after the last number");
  if (got < 0) {
    throw InputError(fmt::format("{}: is damaged: {}", where, zip_file_strerror(entry.get())));
  }
}

NpyHeader read_header(const ZipFile& entry, std::uint64_t entry_size, const std::string& where) {
  std::string header(kNpyPreamble, '\0');
  if (entry_size < header.size()) throw InputError(where + ": is too short for an .npy array");
  read_exactly(entry, header.data(), header.size(), where);
  const std::size_t header_size = npy_header_size(header, where);
  if (entry_size < header_size || header_size < header.size()) {
    throw InputError(where + ": ends within its .npy header");
  }
  header.resize(header_size);
  read_exactly(entry, header.data() + kNpyPreamble, header_size - kNpyPreamble, where);
  const NpyHeader result = parse_npy_header(header, where);
  const std::uint64_t wanted = header_size + result.count * npy_size(result.type);
  if (wanted != entry_size) {
    throw InputError(fmt::format("{}: has {} bytes, expected {} for its shape {}", where,
                                 entry_size, wanted, shape_text(result.shape)));
  }
  return result;
}

void read_values(const ZipFile& entry, const NpyHeader& header, const std::string& where,
                 const std::function<void(std::span<const double>)>& values) {
  const std::size_t size = npy_size(header.type);
  std::string bytes(kPiece * size, '\0');
  std::vector<double> numbers(kPiece);
  for (std::size_t left = header.count; left > 0;) {
    const std::size_t now = std::min(left, kPiece);
    read_exactly(entry, bytes.data(), now * size, where);
    npy_to_double(header.type, std::string_view(bytes).substr(0, now * size), numbers.data());
    values(std::span<const double>(numbers.data(), now));
    left -= now;
  }
}

// The size of an entry in the archive's directory, if the file can hold it.
std::uint64_t claimed_size(zip* archive, zip_uint64_t index, std::uint64_t file_size,
                           const std::string& where) {
  zip_stat_t stat;
  if (zip_stat_index(archive, index, 0, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE) ||
      !(stat.valid & ZIP_STAT_COMP_SIZE)) {
    throw InputError(where + ": its entry in the archive is damaged");
  }
  if (stat.comp_size <= file_size && stat.size / kMostInflation <= stat.comp_size) return stat.size;
  throw InputError(fmt::format(
      "{}: claims {} bytes from {} compressed ones in a file of {}: the archive is damaged", where,
      stat.size, stat.comp_size, file_size));
}

// Reorders numbers with the first index fastest to the last index fastest.
std::vector<double> last_index_fastest(const std::vector<double>& values,
                                       const std::vector<std::size_t>& shape) {
  std::vector<double> result(values.size());
  std::vector<std::size_t> index(shape.size(), 0);
  for (const double value : values) {
    std::size_t flat = 0;
    for (std::size_t axis = 0; axis < shape.size(); ++axis) flat = flat * shape[axis] + index[axis];
    result[flat] = value;
    for (std::size_t axis = 0; axis < shape.size() && ++index[axis] == shape[axis]; ++axis) {
      index[axis] = 0;
    }
  }
  return result;
}

zip* open_archive(const std::filesystem::path& file) {
  check_regular_file(file);
  int code = 0;
  if (zip* archive = zip_open(file.c_str(), ZIP_RDONLY, &code)) return archive;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  const std::string reason = zip_error_strerror(&error);
  zip_error_fini(&error);
  throw InputError(fmt::format(
      "{}: cannot be opened as a zip archive ({}), expected an .npz file; a truncated copy gives "
      "the same error",
      file.string(), reason));
}

}  // namespace

NpzArchive::NpzArchive(const std::filesystem::path& file)
    : file_(file), archive_(open_archive(file), [](zip* archive) { zip_discard(archive); }) {
  const zip_int64_t entries = zip_get_num_entries(archive_.get(), 0);
  for (zip_int64_t i = 0; i < entries; ++i) {
    const char* name = zip_get_name(archive_.get(), static_cast<zip_uint64_t>(i), 0);
    std::string_view field = name ? name : "";
    if (field.ends_with(".npy")) field.remove_suffix(4);
    fields_.emplace_back(field);
  }
}

NpzArchive::~NpzArchive() = default;

bool NpzArchive::has(const std::string& field) const {
  return std::find(fields_.begin(), fields_.end(), field) != fields_.end();
}

std::string NpzArchive::where(const std::string& field) const {
  return fmt::format("{}: field '{}'", file_.string(), field);
}

void NpzArchive::stream(const std::string& field,
                        const std::function<void(const NpyHeader&)>& begin,
                        const std::function<void(std::span<const double>)>& values) const {
  const auto found = std::find(fields_.begin(), fields_.end(), field);
  if (found == fields_.end()) {
    throw InputError(fmt::format("{}: is missing; the file holds {}{}", where(field),
                                 quoted_list(fields_), did_you_mean(field, fields_)));
  }
  const auto index = static_cast<zip_uint64_t>(found - fields_.begin());
  const std::uint64_t entry_size =
      claimed_size(archive_.get(), index, std::filesystem::file_size(file_), where(field));
  const ZipFile entry(zip_fopen_index(archive_.get(), index, 0), &zip_fclose);
  if (!entry) {
    throw InputError(
        fmt::format("{}: cannot be opened: {}", where(field), zip_strerror(archive_.get())));
  }
  const NpyHeader header = read_header(entry, entry_size, where(field));
  begin(header);
  read_values(entry, header, where(field), values);
  check_end(entry, where(field));
}

NumberArray NpzArchive::read(const std::string& field) const {
  NumberArray array{.where = where(field), .shape = {}, .values = {}};
  bool transpose = false;
  stream(
      field,
      [&](const NpyHeader& header) {
        if (header.count > kLargestField) {
          throw InputError(fmt::format("{}: has shape {}, expected at most {} numbers",
                                       where(field), shape_text(header.shape), kLargestField));
        }
        array.shape = header.shape;
        transpose = header.fortran_order && header.shape.size() > 1;
      },
      [&](std::span<const double> piece) {
        array.values.insert(array.values.end(), piece.begin(), piece.end());
      });
  if (transpose) array.values = last_index_fastest(array.values, array.shape);
  return array;
}

}  // namespace chasles
