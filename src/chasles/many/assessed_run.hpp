#pragma once

#include <filesystem>
#include <functional>

#include <nlohmann/json.hpp>

#include <chasles/many/batch_list.hpp>
#include <chasles/many/verdict.hpp>
#include <chasles/session/session_options.hpp>

namespace chasles {

/// What one recording of a batch is asked for.
struct AssessedRunOptions {
  SessionOptions session;  ///< of all recordings; its input is replaced by that of the item
  VerdictLimits limits = {};
  bool check = true;  ///< examines the recording as `chasles check` does
};

/// The options of a run of that item.
SessionOptions session_of(const SessionOptions& all, const BatchItem& item);

/// The record of a recording that has no run, by the reason.
nlohmann::ordered_json record_without_run(const BatchItem& item, const Reason& reason);

/// The only entry of what assessed_run() returns where the run folder cannot be written, which says
/// nothing of the recording: the sentence.
inline constexpr const char* kOutputError = "output_error";

/// Runs a recording, writes the run folder, and returns the record of the batch about it
/// (docs/many.md). `known`: called with the length of the recording [min] before the run. What is
/// wrong is a reason in the record: it throws nothing.
nlohmann::ordered_json assessed_run(const AssessedRunOptions& options, const BatchItem& item,
                                    const std::filesystem::path& folder,
                                    const std::function<void(double)>& known);

}  // namespace chasles
