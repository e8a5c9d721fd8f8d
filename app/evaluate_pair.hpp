#pragma once

#include <filesystem>
#include <string>

namespace chasles::app {

enum class Form { kText, kJson, kMarkdown };

/// Two run folders of one recording, compared with each other (chasles evaluate --pair). Throws
/// UsageError unless both are run folders with covariances, and InputError as pair_difference().
std::string evaluated_pair(const std::filesystem::path& first, const std::filesystem::path& second,
                           Form form);

}  // namespace chasles::app
