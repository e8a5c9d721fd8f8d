#pragma once

#include <filesystem>
#include <string>

namespace chasles::app {

enum class Form { kText, kJson, kMarkdown };

/// Two run folders of one recording, compared with each other (chasles evaluate --pair). Warns of
/// runs that may share tracks or start apart. Throws UsageError for runs of different recordings or
/// kinds, InputError for what is no run folder, and as pair_difference().
std::string evaluated_pair(const std::filesystem::path& first, const std::filesystem::path& second,
                           Form form);

}  // namespace chasles::app
