#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace chasles::test {

/// A folder's name with the folders, or the libraries, that it may use.
using Arrows = std::map<std::string, std::set<std::string>>;

/// What the chasles_module(...) lines of a CMake file say.
struct LinkLines {
  Arrows uses;       ///< folder: the folders of its USES
  Arrows links;      ///< folder: its LINKS, which are handed on with its headers
  Arrows privately;  ///< folder: its PRIVATE ones
};
LinkLines read_link_lines(const std::filesystem::path& cmake_file);

/// An `#include <header>` of a source file; `folder` is the file's own (src/chasles/FOLDER).
struct Include {
  std::filesystem::path file;  ///< relative to the tree's root
  int line = 0;
  std::string folder;  ///< empty for a file of src/chasles itself
  std::string header;
};

/// All includes of the .hpp and .cpp files below root/src/chasles.
std::vector<Include> read_includes(const std::filesystem::path& root);

/// The arrows and what is reached by following them.
Arrows closure(const Arrows& arrows);

/// A sentence for each include that the link lines do not allow.
std::vector<std::string> violations(const std::vector<Include>& includes, const LinkLines& lines);

/// A sentence for each installed header that includes one which is not installed.
std::vector<std::string> missing_in_package(const std::vector<Include>& includes);

}  // namespace chasles::test
