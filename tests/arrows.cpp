#include "arrows.hpp"

#include <array>
#include <fstream>
#include <regex>
#include <sstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

/// Prefix of an external library's headers, and its CMake target.
constexpr std::array<std::pair<std::string_view, std::string_view>, 26> kLibraries = {{
    {"Eigen/", "Eigen3::Eigen"},
    {"unsupported/Eigen/", "Eigen3::Eigen"},
    {"fmt/", "fmt::fmt"},
    {"nlohmann/", "nlohmann_json::nlohmann_json"},
    {"yaml-cpp/", "yaml-cpp"},
    {"spdlog/", "spdlog::spdlog"},
    {"CLI/", "CLI11::CLI11"},
    {"zip.h", "PkgConfig::libzip"},
    {"matio.h", "matio::at_run_time"},
    {"libav", "libav::at_run_time"},
    {"libdeflate.h", "PkgConfig::libdeflate"},
    {"jpeglib.h", "JPEG::JPEG"},
    {"jerror.h", "JPEG::JPEG"},
    {"tiffio.h", "TIFF::TIFF"},
    {"bzlib.h", "BZip2::BZip2"},
    {"lz4frame.h", "PkgConfig::liblz4"},
    {"webp/", "PkgConfig::libwebp"},
    {"zstd.h", "PkgConfig::libzstd"},
    {"zstd_errors.h", "PkgConfig::libzstd"},
    {"sqlite3.h", "PkgConfig::sqlite3"},
    {"opencv2/", "opencv::core"},  // which no folder links but for its tests
    {"ceres/", "Ceres::ceres"},
    {"zlib.h", "ZLIB::ZLIB"},
    {"boost/", "Boost::headers"},
    {"cblas", "PkgConfig::openblas"},
    {"lapack", "PkgConfig::openblas"},
}};

std::string slurp(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

bool is_test(const fs::path& file) {
  static const std::regex test(R"((.*_)?(test|testing)\.[ch]pp|test_.*\.[ch]pp)");
  return std::regex_match(file.filename().string(), test);
}

bool is_internal(const fs::path& file) {
  static const std::regex internal(R"(series\.hpp|.*_detail\.hpp)");
  return is_test(file) || std::regex_match(file.filename().string(), internal);
}

bool is_standard(const std::string& header) {
  static const std::regex standard("[a-z_0-9]+");
  static const std::regex posix(
      R"(((sys|arpa|netinet)/[a-z]+|dlfcn|fcntl|ifaddrs|malloc|pthread|unistd)\.h)");
  return std::regex_match(header, standard) || std::regex_match(header, posix);
}

/// The folder of "chasles/FOLDER/file.hpp"; empty for "chasles/file.hpp".
std::string folder_of(const std::string& header) {
  static const std::regex own("chasles/([^/]+)/.*");
  std::smatch match;
  return std::regex_match(header, match, own) ? match[1].str() : "";
}

/// All external targets that the folder may include: its own ones, and the LINKS of the folders
/// that it reaches.
std::set<std::string> libraries_of(const std::string& folder, const LinkLines& lines,
                                   const Arrows& reached) {
  std::set<std::string> all = lines.links.at(folder);
  all.insert(lines.privately.at(folder).begin(), lines.privately.at(folder).end());
  for (const std::string& other : reached.at(folder)) {
    const auto handed_on = lines.links.find(other);
    if (handed_on != lines.links.end()) {
      all.insert(handed_on->second.begin(), handed_on->second.end());
    }
  }
  return all;
}

/// Reason why an external header is not allowed; empty if it is.
std::string objection_to_library(const Include& include, const std::set<std::string>& libraries) {
  const std::string& header = include.header;
  if (is_standard(header)) return "";
  const bool of_tests = header.starts_with("gtest/") || header.starts_with("gmock/");
  if (of_tests) return is_test(include.file) ? "" : "only tests use GoogleTest";
  for (const auto& [prefix, target] : kLibraries) {
    if (!header.starts_with(prefix)) continue;
    // Tests may use the private libraries of their folder to inspect files.
    if (is_test(include.file) || libraries.contains(std::string(target))) return "";
    return fmt::format("its link line does not have {}", target);
  }
  return "no known library has this header";
}

std::string objection(const Include& include, const LinkLines& lines, const Arrows& reached) {
  if (!include.header.starts_with("chasles/")) {
    return objection_to_library(include, libraries_of(include.folder, lines, reached));
  }
  const std::string target = folder_of(include.header);
  if (target == include.folder) return "";
  if (reached.at(include.folder).contains(target)) return "";
  if (is_test(include.file)) {
    for (const std::string& more : lines.tests_use.at(include.folder)) {
      if (more == target || reached.at(more).contains(target)) return "";
    }
  }
  return fmt::format("there is no arrow from {} to {}", include.folder, target);
}

}  // namespace

LinkLines read_link_lines(const fs::path& cmake_file) {
  static const std::regex module(R"(chasles_module\(([^)]*)\))");
  LinkLines lines;
  const std::string text = slurp(cmake_file);
  for (std::sregex_iterator it(text.begin(), text.end(), module), end; it != end; ++it) {
    std::istringstream words((*it)[1].str());
    std::string name, word;
    words >> name;
    lines.uses[name], lines.links[name], lines.privately[name], lines.tests_use[name];
    Arrows* list = nullptr;
    while (words >> word) {
      if (word == "USES") {
        list = &lines.uses;
      } else if (word == "LINKS") {
        list = &lines.links;
      } else if (word == "PRIVATE") {
        list = &lines.privately;
      } else if (word == "TESTS_USE") {
        list = &lines.tests_use;
      } else if (list != nullptr) {
        (*list)[name].insert(word);
      }
    }
  }
  return lines;
}

std::vector<Include> read_includes(const fs::path& root) {
  static const std::regex include(R"(\s*#\s*include\s*[<"]([^>"]+)[>"].*)");
  const fs::path source = root / "src" / "chasles";
  std::vector<Include> includes;
  for (const auto& entry : fs::recursive_directory_iterator(source)) {
    const fs::path& file = entry.path();
    if (file.extension() != ".hpp" && file.extension() != ".cpp") continue;
    const fs::path inside = fs::relative(file, source);
    const std::string folder = inside.has_parent_path() ? inside.begin()->string() : "";
    std::ifstream stream(file);
    std::string text;
    std::smatch match;
    for (int line = 1; std::getline(stream, text); ++line) {
      if (!std::regex_match(text, match, include)) continue;
      includes.push_back({fs::relative(file, root), line, folder, match[1].str()});
    }
  }
  return includes;
}

Arrows closure(const Arrows& arrows) {
  Arrows all = arrows;
  for (bool grown = true; grown;) {
    grown = false;
    for (auto& [from, reached] : all) {
      std::set<std::string> wider = reached;
      for (const std::string& to : reached) {
        if (all.contains(to)) wider.insert(all.at(to).begin(), all.at(to).end());
      }
      grown = grown || wider.size() > reached.size();
      reached = std::move(wider);
    }
  }
  return all;
}

std::vector<std::string> violations(const std::vector<Include>& includes, const LinkLines& lines) {
  const Arrows reached = closure(lines.uses);
  std::vector<std::string> found;
  for (const Include& include : includes) {
    const std::string why = reached.contains(include.folder)
                                ? objection(include, lines, reached)
                                : "this folder has no chasles_module line";
    if (why.empty()) continue;
    found.push_back(fmt::format("{}:{}: #include <{}>: {}", include.file.string(), include.line,
                                include.header, why));
  }
  return found;
}

std::vector<std::string> missing_in_package(const std::vector<Include>& includes) {
  std::vector<std::string> found;
  for (const Include& include : includes) {
    if (include.file.extension() != ".hpp" || is_internal(include.file)) continue;
    if (!include.header.starts_with("chasles/") || !is_internal(include.header)) continue;
    found.push_back(fmt::format("{}:{}: #include <{}>: it is not installed", include.file.string(),
                                include.line, include.header));
  }
  return found;
}

}  // namespace chasles::test
