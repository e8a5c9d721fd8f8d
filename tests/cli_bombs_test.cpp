#include <chrono>

#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include <chasles/codec/bomb_testing.hpp>

#include "cli_test.hpp"

// Files of a few bytes that claim gigabytes, nest without end, or never end: the program says what
// is wrong with exit code 2. With at most 4 GB of address space, a bomb that goes off ends it.
namespace chasles::test {
namespace {

constexpr const char* kLittleMemory = "ulimit -v 4000000; ";

void expect_rejected(const Scratch& folder, const std::string& arguments, const std::string& part) {
  SCOPED_TRACE(arguments);
  const auto started = std::chrono::steady_clock::now();
  expect_error(chasles(folder, arguments, kLittleMemory), 2, part);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - started;
  EXPECT_LT(took.count(), 20);  // 0.1 s on an idle machine
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

TEST(Bombs, OfRecordingsAreRejected) {
  const Scratch folder;
  spill(folder / "struct.mat", mat_file(mat_struct_claiming(0x7ffffff8)));
  expect_rejected(folder, "run struct.mat", "struct.mat: the header of the array at byte 128");
  spill(folder / "cells.mat", mat_file(nested_mat_cells(100'000)));
  expect_rejected(folder, "run cells.mat", "cells.mat: nests more than 100 values");
  spill(folder / "zeros.tum.gz", gzip_claiming(1'000'000'000, 1'000'000));
  expect_rejected(folder, "run zeros.tum.gz", "claims 1000000000 bytes");
  ASSERT_EQ(::mkfifo((folder / "pipe.mat").c_str(), 0600), 0);
  expect_rejected(folder, "run pipe.mat", "pipe.mat: is a pipe or a device");
  expect_rejected(folder, "check pipe.mat", "pipe.mat: is a pipe or a device");
  expect_rejected(folder, "evaluate pipe.mat pipe.mat", "pipe.mat: is a pipe or a device");
  expect_rejected(folder, "run /dev/zero", "/dev/zero: is a pipe or a device");
}

TEST(Bombs, OfRunFoldersAreRejected) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet --stop 2 -o out").code, 0);
  expect_rejected(folder, "run rec --truth /dev/zero", "/dev/zero: is a pipe or a device");
  for (const std::string& bomb :
       {repeated("[", 100'000), repeated("{\"a\":", 100'000),
        "{\"a\":" + repeated("[", 100'000) + repeated("]", 100'000) + "}"}) {
    spill(folder / "out/summary.json", bomb);
    for (const char* command :
         {"report out -o page.html", "export out -o run.ply", "evaluate out"}) {
      expect_rejected(folder, command, "summary.json: nests more than 100 values");
    }
  }
  spill(folder / "out/summary.json", "{\"ate_m\": 1e999}");
  expect_rejected(folder, "report out -o page.html", "summary.json: is not valid JSON");
  spill(folder / "out/summary.json", "{}");
  spill(folder / "out/timing.json", "{\"seconds_wall\": 1e999}");
  expect_rejected(folder, "report out -o page.html", "timing.json: is not valid JSON");
}

TEST(Bombs, OfStudiesAreRejected) {
  const Scratch folder;
  for (const char* part : {"a", "b"}) std::filesystem::create_directory(folder / part);
  for (const std::string& plan :
       {repeated("[", 100'000), repeated("{\"a\":", 100'000),
        "{\"scene\":" + repeated("[", 100'000) + repeated("]", 100'000) + "}"}) {
    spill(folder / "a/plan.json", plan);
    expect_rejected(folder, "montecarlo --merge a b -o joined", "plan.json: nests more than 100");
  }
  spill(folder / "a/plan.json", "{\"version\": 1e999}");
  expect_rejected(folder, "montecarlo --merge a b -o joined", "plan.json: is not valid JSON");
  spill(folder / "a/plan.json", "{}");
  expect_rejected(folder, "montecarlo --merge a b -o joined", "plan.json: not the plan of a study");
  spill(folder / "a/summary.json", repeated("[", 100'000));
  expect_rejected(folder, "report a -o page.html", "summary.json: nests more than 100");
}

TEST(Bombs, TheBudgetIsSetByTheEnvironment) {
  const Scratch folder;
  simulate(folder);
  const std::string little = "export CHASLES_READ_MEMORY=1K; ";
  expect_error(chasles(folder, "run rec", little), 2, "set CHASLES_READ_MEMORY to more");
  expect_error(chasles(folder, "run rec", "export CHASLES_READ_MEMORY=lots; "), 1,
               "CHASLES_READ_MEMORY: found 'lots', expected bytes");
}

}  // namespace
}  // namespace chasles::test
