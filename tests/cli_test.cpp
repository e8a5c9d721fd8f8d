#include "cli_test.hpp"

#include <nlohmann/json.hpp>

#include <chasles/slam/velocity_settings.hpp>

// Help, errors and exit codes of the command.
namespace chasles::test {
namespace {

TEST(Command, TellsItsVersion) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "--version");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out.rfind("chasles ", 0), 0u);
}

TEST(Command, HelpNamesEverySubcommandAndExitCode) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "--help");
  EXPECT_EQ(outcome.code, 0);
  for (const char* part : {"run", "simulate", "compare", "montecarlo", "evaluate", "report",
                           "5 a requested threshold"}) {
    expect_part(outcome.out, part);
  }
}

TEST(Command, HelpOfRunListsEverySettingWithItsMeaning) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "run --help");
  EXPECT_EQ(outcome.code, 0);
  const VelocitySlamSettings settings;
  for_each_setting(settings, [&](const char* name, const auto&, const char*, const char* meaning,
                                 const Limits&) {
    expect_part(outcome.out, std::string("\n  ") + name + " ");
    expect_part(outcome.out, meaning);
  });
}

TEST(Command, HelpOfSimulateListsScenesAndSettings) {
  const Scratch folder;
  const Outcome outcome = chasles(folder, "simulate --help");
  EXPECT_EQ(outcome.code, 0);
  for (const char* part : {"street-exact", "block_length", "outlier_fraction", "m/s^2"}) {
    expect_part(outcome.out, part);
  }
}

TEST(Command, MisuseEndsWithOne) {
  const Scratch folder;
  simulate(folder);
  expect_error(chasles(folder, ""), 1, "chasles --help");
  expect_error(chasles(folder, "rum"), 1, "'rum' is not known here; did you mean 'run'?");
  expect_error(chasles(folder, "run rec --chrat x"), 1, "did you mean '--chart'?");
  expect_error(chasles(folder, "run"), 1, "RECORDING is required");
  expect_error(chasles(folder, "simulate street"), 1, "--output is required");
  expect_error(chasles(folder, "simulate stret -o x"), 1, "unknown scene 'stret'");
  expect_error(chasles(folder, "run rec --chart left"), 1, "--chart: found 'left', expected");
  expect_error(chasles(folder, "run rec --set gate=nan"), 1, "--set: gate: found 'nan'");
  expect_error(chasles(folder, "run rec --start nan"), 1, "--start");
  expect_error(chasles(folder, "run rec --start -1"), 1, "--start: found -1, expected");
  expect_error(chasles(folder, "run rec --start 500"), 1, "nothing is left of street");
  expect_error(chasles(folder, "run rec --ate-below inf"), 1, "--ate-below");
  expect_error(chasles(folder, "run rec --trajectory t.tum"), 1, "--trajectory is for --mode map");
  expect_error(chasles(folder, "evaluate a b --json --markdown"), 1, "--markdown");
  expect_error(chasles(folder, "report -o page.html"), 1, "RUN|STUDY is required");
}

TEST(Command, BadInputEndsWithTwo) {
  const Scratch folder;
  simulate(folder);
  spill(folder / "junk.npz", "this is no archive");
  spill(folder / "junk.tum", "1 2 3\n");
  spill(folder / "late.tum", "4e9 0 0 0 0 0 0 1\n4.1e9 0 0 0 0 0 0 1\n4.2e9 0 0 0 0 0 0 1\n");
  expect_error(chasles(folder, "run missing.npz"), 2, "missing.npz");
  expect_error(chasles(folder, "run junk.npz"), 2, "junk.npz");
  expect_error(chasles(folder, "run rec --config missing.yaml"), 2, "missing.yaml: no such file");
  expect_error(chasles(folder, "run rec --truth junk.tum --quiet"), 2, "junk.tum:1");
  expect_error(chasles(folder, "run rec --truth late.tum --quiet"), 2,
               "late.tum: does not fit the recording's frames");
  expect_error(chasles(folder, "run rec --mode map --trajectory late.tum --quiet"), 2,
               "no frame of street lies in the time span of the trajectory");
  expect_error(chasles(folder, "evaluate junk.tum rec"), 2, "junk.tum:1");
  expect_error(chasles(folder, "evaluate rec/truth.tum late.tum"), 2, "");
  expect_error(chasles(folder, "report rec -o page.html"), 2, "rec");
  EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

TEST(Command, ARecordingWithoutEventsEndsWithThree) {
  const Scratch folder;
  simulate(folder);
  spill(folder / "rec/frames.csv", "time_ns,observations\n");
  spill(folder / "rec/features.csv", "time_ns,landmark,u_left,v_left,u_right,v_right\n");
  expect_error(chasles(folder, "run rec -o out"), 3, "expected frames and one of the others");
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Command, FailsBeforeTheRunWhereTheOutputCannotBeWritten) {
  const Scratch folder;
  simulate(folder);
  spill(folder / "file", "");
  expect_error(chasles(folder, "run rec --quiet -o file"), 1, "file: the folder cannot be made");
  expect_error(chasles(folder, "run rec --quiet -o file/below"), 1, "file/below");
  expect_error(chasles(folder, "run rec --quiet --full-covariance nowhere/P.npy"), 1,
               "nowhere/P.npy: cannot be written: No such file or directory");
  expect_error(chasles(folder, "simulate street -o file"), 1, "file: the folder cannot be made");
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  expect_error(chasles(folder, "report out -o file/page.html"), 1,
               "file: the folder cannot be made");
  expect_error(chasles(folder, "report out -o /dev/full"), 1, "/dev/full: cannot be written");
}

TEST(Command, AFullDiskIsAnErrorNotATruncatedFile) {
  const Scratch folder;
  simulate(folder);
  // A process with a file size limit of 64 KiB gets the same errors.
  const std::string full_disk = "trap '' XFSZ && ulimit -f 64 && ";
  expect_error(chasles(folder, "run rec --quiet -o out", full_disk), 1, "cannot be written");
  expect_error(chasles(folder, "run rec --quiet --full-covariance P.npy", full_disk), 1,
               "P.npy: cannot be written");
  EXPECT_FALSE(std::filesystem::exists(folder / "P.npy"));
}

TEST(Command, AFullStdoutIsAnError) {
  const Scratch folder;
  const std::string command = std::string("'") + CHASLES_BINARY + "' simulate street --json -o '" +
                              (folder / "r").string() + "' --set route=R >/dev/full 2>'" +
                              (folder / "e").string() + "'";
  EXPECT_NE(std::system(command.c_str()), 0);
  expect_part(slurp(folder / "e"), "chasles: error: stdout cannot be written");
}

TEST(Command, SimulatesTheSameBytesForTheSameSeed) {
  const Scratch folder;
  simulate(folder, "--seed 7");
  std::filesystem::rename(folder / "rec", folder / "one");
  simulate(folder, "--seed 7");
  std::filesystem::rename(folder / "rec", folder / "two");
  simulate(folder, "--seed 8");
  for (const char* file : {"velocities.csv", "features.csv", "truth.tum", "calibration.yaml"}) {
    EXPECT_EQ(slurp(folder / "one" / file), slurp(folder / "two" / file)) << file;
  }
  EXPECT_NE(slurp(folder / "one" / "features.csv"), slurp(folder / "rec" / "features.csv"));
}

TEST(Command, SimulateRefusesSettingsOutOfRange) {
  const Scratch folder;
  expect_error(chasles(folder, "simulate street -o r --set cruise_speed=-3"), 1, "cruise_speed");
  expect_error(chasles(folder, "simulate street -o r --set seed=-3"), 1, "--set: seed: found '-3'");
  expect_error(chasles(folder, "simulate street -o r --set pixel_sgima=1"), 1,
               "did you mean 'pixel_sigma'?");
  EXPECT_FALSE(std::filesystem::exists(folder / "r"));
}

}  // namespace
}  // namespace chasles::test
