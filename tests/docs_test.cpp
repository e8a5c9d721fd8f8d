#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/camera/lenses/lens_model.hpp>

// Consistency of the pages: link targets and commands exist, and the example is the one that the
// tests build (installed_package).
namespace chasles {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = CHASLES_SOURCE_DIR;

std::string slurp(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::vector<fs::path> pages() {
  std::vector<fs::path> pages;
  for (const fs::path& folder : {kRoot, kRoot / "docs", kRoot / "studies"}) {
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".md") pages.push_back(entry.path());
    }
  }
  return pages;
}

/// The first group of every match.
std::set<std::string> all_matches(const std::string& text, const std::regex& pattern) {
  std::set<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), pattern), end; it != end; ++it) {
    found.insert((*it)[1].str());
  }
  return found;
}

TEST(Docs, LinksLeadToFiles) {
  static const std::regex link(R"(\]\(([^)#:]+)(#[^)]*)?\))");
  int links = 0;
  for (const fs::path& page : pages()) {
    for (const std::string& target : all_matches(slurp(page), link)) {
      ++links;
      EXPECT_TRUE(fs::exists(page.parent_path() / target))
          << fs::relative(page, kRoot) << " links to " << target;
    }
  }
  EXPECT_GT(links, 10);
}

TEST(Docs, CommentsReferToPagesThatExist) {
  static const std::regex reference(R"((docs/[a-z-]+\.md))");
  for (const char* folder : {"src", "app"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string path = entry.path();
      if (!entry.is_regular_file() || path.find("/node_modules/") != std::string::npos) continue;
      for (const std::string& page : all_matches(slurp(path), reference)) {
        EXPECT_TRUE(fs::exists(kRoot / page))
            << fs::relative(entry.path(), kRoot) << " refers to " << page;
      }
    }
  }
}

TEST(Docs, TheIndexNamesEveryPage) {
  const std::string index = slurp(kRoot / "docs" / "README.md");
  for (const auto& entry : fs::directory_iterator(kRoot / "docs")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".md" || name == "README.md") continue;
    EXPECT_NE(index.find("](" + name + ")"), std::string::npos) << "docs/README.md lacks " << name;
  }
}

// The table of lens models is the list of the library.
TEST(Docs, TheLensModelsAreThoseOfTheList) {
  const std::string page = slurp(kRoot / "docs" / "calibration-conventions.md");
  for (const LensModel& model : kLensModels) {
    std::string others;
    std::istringstream words{std::string(model.other_names)};
    for (std::string word; words >> word;) others += (others.empty() ? "`" : ", `") + word + "`";
    const auto cell = [](const std::string& text) {
      return text.empty() ? " |" : " " + text + " |";
    };
    std::string names(model.coefficients);
    names.append(static_cast<std::size_t>(std::ranges::count(names, '[')), ']');
    const std::string row = "\n| `" + std::string(model.name) + "` |" + cell(others) + cell(names) +
                            " " + std::string(model.title);
    EXPECT_NE(page.find(row), std::string::npos) << row;
  }
}

TEST(Docs, EveryMakeCommandIsATarget) {
  static const std::regex command(R"(make ([a-z0-9-]+))");
  static const std::regex target(R"((?:^|\n)([a-z0-9-]+):)");
  const auto targets = all_matches(slurp(kRoot / "Makefile"), target);
  ASSERT_TRUE(targets.contains("demo"));
  for (const char* page : {"README.md", "docs/CONTRIBUTING.md"}) {
    // Only code: `make test`, or a line of a code block.
    static const std::regex code(R"((?:`|\n)(make [a-z0-9-]+))");
    for (const std::string& line : all_matches(slurp(kRoot / page), code)) {
      for (const std::string& name : all_matches(line, command)) {
        EXPECT_TRUE(targets.contains(name)) << page << ": make " << name;
      }
    }
  }
}

TEST(Docs, TheExamplesOfFirstStepsAreThoseThatAreTested) {
  const std::string page = slurp(kRoot / "docs" / "start.md");
  const std::string opening = "```cpp\n";
  for (const char* program : {"velocity.cpp", "run.cpp"}) {
    const std::string tested = slurp(kRoot / "tests" / "consumer" / program);
    bool shown = false;
    for (auto at = page.find(opening); at != std::string::npos; at = page.find(opening, at)) {
      at += opening.size();
      const std::string example = page.substr(at, page.find("```", at) - at);
      shown = shown || (example.size() > 200 && tested.find(example) != std::string::npos);
    }
    EXPECT_TRUE(shown) << "docs/start.md shows nothing of tests/consumer/" << program;
  }
}

}  // namespace
}  // namespace chasles
