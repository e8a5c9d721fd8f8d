#pragma once

#include <algorithm>
#include <cctype>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <chasles/base/error.hpp>

namespace chasles {

/// What a program registers by name at run time, beside what the library has. Nothing in it ends
/// or moves, as filters and settings keep references. Any thread.
template <typename Entry>
class RegisteredNames {
 public:
  /// `kind` of thing, for messages; `of_library`: names that are taken.
  RegisteredNames(std::string kind, std::vector<std::string_view> of_library)
      : kind_(std::move(kind)), taken_(of_library.size()) {
    names_.push_back(std::move(of_library));
  }

  /// Throws UsageError for a name of the library, and for one that is empty or has other characters
  /// than letters, digits, '-' and '_'.
  void check(const std::string& name) const {
    const bool usable = !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
      return std::isalnum(c) || c == '-' || c == '_';
    });
    if (!usable) {
      throw UsageError(kind_ + ": found the name '" + name +
                       "', expected letters, digits, '-' and '_'");
    }
    const auto of_library = std::span(names_.front()).first(taken_);
    if (std::ranges::find(of_library, name) != of_library.end()) {
      throw UsageError(kind_ + ": '" + name + "' is one of the library; choose another name");
    }
  }

  /// Replaces an earlier entry of the same name, which stays valid for those who have it.
  const Entry& add(std::string name, Entry entry) {
    check(name);
    const std::scoped_lock lock(mutex_);
    const bool is_new = !found(name);
    const Named& added = entries_.emplace_back(std::move(name), std::move(entry));
    if (is_new) {
      std::vector<std::string_view> names = names_.back();
      names.push_back(added.first);
      names_.push_back(std::move(names));
    }
    return added.second;
  }

  const Entry* find(std::string_view name) const {
    const std::scoped_lock lock(mutex_);
    return found(name);
  }

  /// Those of the library, then the registered ones. Stays valid.
  std::span<const std::string_view> names() const {
    const std::scoped_lock lock(mutex_);
    return names_.back();
  }

  [[noreturn]] void throw_unknown(std::string_view name) const {
    std::string known;
    for (const std::string_view one : names()) {
      known += (known.empty() ? "" : ", ") + std::string(one);
    }
    throw UsageError("unknown " + kind_ + " '" + std::string(name) +
                     "'; expected one of: " + known);
  }

 private:
  using Named = std::pair<const std::string, Entry>;

  const Entry* found(std::string_view name) const {
    const auto at = std::find_if(entries_.rbegin(), entries_.rend(),
                                 [&](const Named& one) { return one.first == name; });
    return at == entries_.rend() ? nullptr : &at->second;
  }

  const std::string kind_;
  const std::size_t taken_;
  mutable std::mutex mutex_;
  std::deque<Named> entries_;
  std::deque<std::vector<std::string_view>> names_;  ///< the last one holds
};

}  // namespace chasles
