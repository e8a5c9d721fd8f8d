#include "arrows.hpp"

#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

// The allowed dependencies between the folders (docs/CONTRIBUTING.md). They are listed here and in
// src/chasles/CMakeLists.txt, so that a new one needs two deliberate changes.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

const Arrows kArrows = {
    // Small headers of all folders: errors, times, settings.
    {"base", {}},
    {"lie", {"base"}},
    // Random numbers, splines.
    {"numeric", {"lie"}},
    {"imu", {"lie"}},
    {"camera", {"lie"}},
    {"filter", {"imu", "camera"}},
    {"frontend", {"camera"}},
    {"eval", {"lie"}},
    // What every estimator returns. Its gates are quantiles of chi2.
    {"estimate", {"filter", "eval"}},
    // The filter with body velocities.
    {"velocity", {"estimate"}},
    {"initialise", {"estimate"}},
    // The appearance of landmarks, matches by it, saved maps. Counts closures as estimates do.
    {"loop", {"estimate"}},
    {"slam", {"initialise", "loop"}},
    // The same start, frames and noise as the filters.
    {"smooth", {"slam", "velocity"}},
    // Files by their form. It knows the units of IMUs and the lenses of images, but no recording.
    {"codec", {"imu", "camera"}},
    // Calibration files of all programs, for recordings and for drivers.
    {"calibration", {"codec"}},
    // Calibration targets: their files, their corners in images, their print.
    {"target", {"codec"}},
    // Bags of ROS, their messages and topics. Their images and samples become a Recording above.
    {"bags", {"calibration"}},
    // Videos and the telemetry in them: when pictures and samples are, and the pictures.
    {"video", {"codec"}},
    {"recording", {"bags", "video"}},
    {"run_folder", {"recording"}},
    // Diagnoses a recording; estimates nothing but the clock of body velocities.
    {"check", {"recording", "velocity"}},
    // Measures sensors from recordings that are made for it.
    {"calibrate", {"check", "smooth", "target"}},
    // The main loop: sensors in, estimates out.
    {"pipeline", {"smooth", "frontend", "check", "run_folder", "numeric"}},
    // The simulator returns the same type as the readers.
    {"sim", {"recording", "numeric"}},
    // Experiments: estimators over simulated scenes.
    {"lab", {"pipeline", "sim"}},
    {"report", {"run_folder", "eval"}},
    {"live", {"report"}},
    // The content of a run's page for other programs.
    {"viewers", {"report"}},
    // The messages of viewers, by the server of live.
    {"foxglove", {"live", "viewers"}},
    // A run with its folder, without a command line.
    {"session", {"pipeline", "live", "calibrate"}},
    // What a run gives with its recording: models for photogrammetry, its path at the IMU's rate.
    {"reconstruct", {"session", "viewers"}},
    // What a robot's middleware needs, without its messages.
    {"robot", {"session"}},
    // Many runs, each with a verdict.
    {"many", {"session"}},
};

std::string joined(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += "\n  " + sentence;
  return text;
}

LinkLines real_lines() {
  return read_link_lines(fs::path(CHASLES_SOURCE_DIR) / "src" / "chasles" / "CMakeLists.txt");
}

TEST(Arrows, TheLinkLinesAreTheArrowsOfThePlan) { EXPECT_EQ(real_lines().uses, kArrows); }

// Tests have the simulator's motion for truth, whole drives, and the readers of what they write.
TEST(Arrows, OnlySomeTestsUseMore) {
  Arrows more;
  for (const auto& [folder, used] : real_lines().tests_use) {
    if (!used.empty()) more[folder] = used;
  }
  EXPECT_EQ(more, (Arrows{{"filter", {"velocity"}},
                          {"initialise", {"lab"}},
                          {"slam", {"lab"}},
                          {"pipeline", {"lab"}},
                          {"codec", {"run_folder"}},
                          {"calibration", {"recording"}},
                          {"bags", {"recording"}},
                          {"video", {"recording"}},
                          {"recording", {"run_folder"}},
                          {"target", {"numeric"}},
                          {"calibrate", {"sim"}},
                          {"target", {"numeric"}},
                          {"session", {"sim"}},
                          {"robot", {"sim"}}}));
}

TEST(Arrows, NoArrowLeadsBack) {
  for (const auto& [folder, reached] : closure(real_lines().uses)) {
    EXPECT_FALSE(reached.contains(folder)) << folder << " uses itself in the end";
  }
}

TEST(Arrows, TheIncludesFollowTheLinkLines) {
  const auto includes = read_includes(CHASLES_SOURCE_DIR);
  EXPECT_GT(includes.size(), 200u) << "the sources were not found";
  const auto found = violations(includes, real_lines());
  EXPECT_TRUE(found.empty()) << joined(found);
}

TEST(Arrows, AnInstalledHeaderIncludesOnlyInstalledOnes) {
  const auto found = missing_in_package(read_includes(CHASLES_SOURCE_DIR));
  EXPECT_TRUE(found.empty()) << joined(found);
}

/// A test tree with two folders; top uses bottom.
class MadeUpTree : public ::testing::Test {
 public:
  // One tree for each test, because ctest runs them in parallel.
  MadeUpTree()
      : root(fs::path(::testing::TempDir()) /
             (std::string("chasles_made_up_tree_") +
              ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(root);
    write("CMakeLists.txt",
          "chasles_module(base)\n"
          "chasles_module(bottom USES base LINKS Eigen3::Eigen PRIVATE fmt::fmt)\n"
          "chasles_module(top USES bottom)\n");
  }
  ~MadeUpTree() override { fs::remove_all(root); }

 protected:
  void write(const std::string& file, const std::string& text) const {
    const fs::path path = root / "src" / "chasles" / file;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  std::vector<std::string> found() const {
    return violations(read_includes(root), read_link_lines(root / "src/chasles/CMakeLists.txt"));
  }

  fs::path root;
};

TEST_F(MadeUpTree, MayIncludeDownwardsAndWhatIsHandedOn) {
  write("base/time.hpp", "#include <chrono>\n");
  write("bottom/a.hpp", "#include <Eigen/Core>\n#include <chasles/base/time.hpp>\n");
  write("bottom/a.cpp", "#include <chasles/bottom/a.hpp>\n#include <fmt/format.h>\n");
  write("top/b.hpp", "#include <Eigen/Core>\n#include <vector>\n#include <chasles/bottom/a.hpp>\n");
  write("top/b_test.cpp", "#include <gtest/gtest.h>\n#include <chasles/top/b.hpp>\n");
  EXPECT_TRUE(found().empty()) << joined(found());
}

TEST_F(MadeUpTree, MayNotIncludeUpwards) {
  write("bottom/a.cpp", "#include <vector>\n  #  include <chasles/top/b.hpp>  // why not\n");
  ASSERT_EQ(found().size(), 1u);
  EXPECT_EQ(found().front(),
            "src/chasles/bottom/a.cpp:2: #include <chasles/top/b.hpp>: there is no arrow from "
            "bottom to top");
}

TEST_F(MadeUpTree, TestsKeepTheArrowsToo) {
  write("bottom/a_test.cpp", "#include <chasles/top/b.hpp>\n");
  EXPECT_EQ(found().size(), 1u);
}

TEST_F(MadeUpTree, TestsMayUseTheFoldersOfTestsUse) {
  write("CMakeLists.txt",
        "chasles_module(bottom LINKS Eigen3::Eigen TESTS_USE top)\n"
        "chasles_module(top USES bottom)\n");
  write("bottom/a_test.cpp", "#include <chasles/top/b.hpp>\n");
  write("bottom/a_testing.hpp", "#include <chasles/top/b.hpp>\n");
  EXPECT_TRUE(found().empty()) << joined(found());
  write("bottom/a.cpp", "#include <chasles/top/b.hpp>\n");
  EXPECT_EQ(found().size(), 1u);
}

TEST_F(MadeUpTree, MayNotUseALibraryThatItDoesNotLink) {
  write("top/b.cpp", "#include <fmt/format.h>\n");        // bottom has it for itself alone
  write("top/c.cpp", "#include <opencv2/core.hpp>\n");    // only tests use OpenCV
  write("top/d.cpp", "#include <gtest/gtest.h>\n");       // not a test
  write("top/e.cpp", "#include <boost/optional.hpp>\n");  // unknown
  write("error.hpp", "#include <chasles/bottom/a.hpp>\n");
  EXPECT_EQ(found().size(), 5u) << joined(found());
}

TEST_F(MadeUpTree, EveryFolderNeedsALinkLine) {
  write("stray/a.hpp", "#include <vector>\n");
  ASSERT_EQ(found().size(), 1u);
  EXPECT_NE(found().front().find("no chasles_module line"), std::string::npos);
}

TEST_F(MadeUpTree, AnInstalledHeaderMayNotNeedATestHeader) {
  write("bottom/a.hpp", "#include <chasles/bottom/testing.hpp>\n");
  write("bottom/series_test.cpp", "#include <chasles/bottom/testing.hpp>\n");
  EXPECT_EQ(missing_in_package(read_includes(root)).size(), 1u);
}

}  // namespace
}  // namespace chasles::test
