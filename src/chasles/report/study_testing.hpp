#pragma once

#include <filesystem>
#include <string>

#include <chasles/report/study.hpp>

/// Shared by the tests of studies.
namespace chasles::test {

struct StudyOptions {
  int filters = 3;
  int frames = 400;  ///< rows of each filter
  int runs = 0;      ///< 0: one run, as `chasles compare` writes it
  std::string name = "synthetic";
  std::string filter_name = "filter";
};

/// A synthetic study, without a filter: a walk around a block with estimates that drift from it.
/// The first filter is consistent, each further one more overconfident. Of several runs, run 0 of
/// the last filter diverged.
Study synthetic_study(const StudyOptions& options = {});

/// Writes a study as the program's commands do.
void write_study(const Study& study, const std::filesystem::path& folder);

}  // namespace chasles::test
