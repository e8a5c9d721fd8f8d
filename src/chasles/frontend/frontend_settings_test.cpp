#include <set>
#include <type_traits>

#include <gtest/gtest.h>

#include <chasles/error.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles::test {
namespace {

// The one that may be any text: a file.
constexpr const char* kFree = "mask";

TEST(FrontendSettings, DefaultsAreUsableAndEachNameIsListedOnce) {
  FrontendSettings settings;
  EXPECT_NO_THROW(check(settings));
  std::set<std::string> names;
  for_each_setting(settings, [&](const char* name, auto&, const char* unit, const char* meaning) {
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_EQ(std::string(unit).empty(), std::string(name) == kFree);
    EXPECT_NE(std::string(meaning), "");
  });
  EXPECT_EQ(names.size(), 24U);
}

TEST(FrontendSettings, EachOneOutOfItsRangeIsNamed) {
  const FrontendSettings good;
  for_each_setting(good, [](const char* name, const auto& value, const char*, const char*) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (!std::is_same_v<Value, bool>) {
      if (std::string(name) == kFree) return;
      FrontendSettings bad;
      for_each_setting(bad, [&](const char* other, auto& field, const char*, const char*) {
        if (std::string(other) != name) return;
        using Field = std::decay_t<decltype(field)>;
        if constexpr (std::is_same_v<Field, std::string>) {
          field = "none of these";
        } else if constexpr (!std::is_same_v<Field, bool>) {
          field = static_cast<Field>(-5);
        }
      });
      try {
        check(bad);
        ADD_FAILURE() << name;
      } catch (const UsageError& error) {
        EXPECT_NE(std::string(error.what()).find(std::string("setting ") + name + ": found"),
                  std::string::npos)
            << error.what();
      }
    }
  });
}

TEST(FrontendSettings, AWindowHasAMiddleAndPredictedLevelsAreAmongTheLevels) {
  EXPECT_THROW(check({.window = 14}), UsageError);
  EXPECT_THROW(check({.levels = 2, .predicted_levels = 3}), UsageError);
  EXPECT_THROW(check({.corners = "harris|shi-tomasi"}), UsageError);
}

}  // namespace
}  // namespace chasles::test
