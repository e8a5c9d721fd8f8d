#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace chasles::test {

/// The folders or libraries that each folder may use, by name.
using Arrows = std::map<std::string, std::set<std::string>>;

/// Content of the chasles_module(...) lines of a CMake file.
struct LinkLines {
  Arrows uses;       ///< folder: the folders of its USES
  Arrows links;      ///< folder: its LINKS, which users of its headers also get
  Arrows privately;  ///< folder: its PRIVATE libraries
  Arrows tests_use;  ///< folder: its TESTS_USE, the folders that its tests alone may include
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

/// The transitive closure of the arrows.
Arrows closure(const Arrows& arrows);

/// A sentence for each include that the link lines do not allow.
std::vector<std::string> violations(const std::vector<Include>& includes, const LinkLines& lines);

/// A sentence for each installed header that includes one which is not installed.
std::vector<std::string> missing_in_package(const std::vector<Include>& includes);

}  // namespace chasles::test
