#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/base/error.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {
struct BatchTerms;
}

namespace chasles::python {

/// A run in memory, of this process or read from a folder.
struct PythonRun {
  Run run;
  std::string summary;  ///< JSON
  std::vector<std::shared_ptr<const BatchTerms>> batch = {};
  std::optional<Error> unsaved = {};  ///< why its map was not saved
  /// Of the recording, on the clock of its cameras [ns]; empty for a run that was read.
  std::vector<std::int64_t> frame_times = {};
};

}  // namespace chasles::python
