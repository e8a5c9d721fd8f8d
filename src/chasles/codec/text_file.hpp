#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// Throws InputError unless this is a regular file: it is missing, a folder, or a pipe or device,
/// which may never end.
void check_regular_file(const std::filesystem::path& file);

/// The bytes of a regular file. Throws InputError if it cannot be read, or is larger than the
/// budget (read_budget.hpp).
std::string read_file(const std::filesystem::path& file);

/// The text of a file, without the byte-order mark of UTF-8 that some programs write first. Throws
/// as read_file().
std::string read_text(const std::filesystem::path& file);

/// Removes that mark, if there is one.
void remove_byte_order_mark(std::string& text);

/// Writes the bytes, replacing the file. Throws UsageError if that is not possible; never waits for
/// the reader of a pipe (output_file.hpp).
void write_file(const std::filesystem::path& file, std::string_view bytes);

/// The same of parts: `next` fills in the next one, and returns false where there is none. The text
/// of a long run would need more memory than the run.
void write_parts(const std::filesystem::path& file,
                 const std::function<bool(std::string& part)>& next);

/// Writes a table: one line with the names of the columns, then the rows.
void write_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                 std::string_view rows);

/// Removes a file if it exists. Throws UsageError if that is not possible.
void remove_file(const std::filesystem::path& file);

/// Creates a folder with its parents. Throws UsageError if that is not possible.
void make_folder(const std::filesystem::path& folder);

/// `; did you mean 'K'?` for the known name most similar to `name`; empty if none is similar. For
/// `group.name` the part after the dot is compared as well; the result then lists the name in every
/// group that has it.
std::string did_you_mean(std::string_view name, const std::vector<std::string>& known);

/// `'a', 'b', 'c'`; of more than 30 names the first ones, and how many are left out.
std::string quoted_list(const std::vector<std::string>& names);

/// Removes the next line from the front of `text` and returns it without its end (\n or \r\n).
std::string_view take_line(std::string_view& text);

/// The text without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// The text in small letters (ASCII).
std::string lower_case(std::string_view text);

/// The words between blanks.
std::vector<std::string_view> split_words(std::string_view line);

}  // namespace chasles
