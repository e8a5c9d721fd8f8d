#include "cli_test.hpp"

#include <nlohmann/json.hpp>

#include <chasles/velocity/velocity_settings.hpp>

#include "cli_process.hpp"

// Help, errors and exit codes of the command.
namespace chasles::test {
namespace {

TEST(Command, ShowsItsVersion) {
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
  expect_error(chasles(folder, "calibrate"), 1, "(see chasles calibrate --help)");
  expect_error(chasles(folder, "calibrate nose"), 1, "did you mean 'noise'?");
  expect_error(chasles(folder, "calibrate noise"), 1, "(see chasles calibrate noise --help)");
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

TEST(Command, AFullStdoutIsAnErrorOfEveryCommand) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  for (const char* words :
       {"run rec --quiet --json", "check rec", "evaluate out --json", "export out -o out.ply",
        "report out -o page.html", "--help", "run --help", "--version", "completion bash",
        "view out --port 0", "compare turntable --charts standard --scene-set revolutions=0.05"}) {
    const std::string command = "cd '" + folder.string() + "' && timeout 60 '" + CHASLES_BINARY +
                                "' " + words + " >/dev/full 2>e";
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << words;
    expect_part(slurp(folder / "e"), "chasles: error: stdout cannot be written: No space left");
  }
}

TEST(Command, ALimitOfFileSizesIsAnErrorAndLeavesNoPart) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  const std::string limit = "ulimit -f 16 && ";
  for (const char* words : {"run rec --quiet -o limited", "report out -o page.html",
                            "export out -o out.mcap", "simulate street -o r --set route=R"}) {
    const Outcome outcome = chasles(folder, words, limit);
    EXPECT_EQ(outcome.code, 1) << words;
    expect_part(outcome.err, "cannot be written: File too large");
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder / "")) {
    EXPECT_NE(entry.path().extension(), ".part") << entry.path();
  }
}

// OpenBLAS asks for ever where it gets no memory. Limits in kB.
TEST(Command, TooLittleMemoryEndsItAtOnce) {
  const Scratch folder;
  simulate(folder);
  simulate_turntable(folder);
  for (const int limit : {60'000, 100'000, 130'000, 160'000, 190'000, 220'000, 260'000}) {
    for (const char* words : {"run rec --quiet", "compare turntable --charts standard --quiet"}) {
      const std::string before = "ulimit -v " + std::to_string(limit) + " && timeout -k 1 20 ";
      const Outcome outcome = chasles(folder, words, before);
      if (outcome.code == 0 || outcome.code == 127) continue;  // enough; or not even the libraries
      EXPECT_EQ(outcome.code, 70) << limit << " " << words << outcome.err;
      expect_part(outcome.err, "chasles: error: out of ");
    }
  }
}

TEST(Command, FewDescriptorsAreSaid) {
  const Scratch folder;
  simulate(folder);
  ASSERT_EQ(chasles(folder, "run rec --quiet -o out").code, 0);
  for (int limit = 5; limit <= 7; ++limit) {
    const std::string few = "prlimit --nofile=" + std::to_string(limit) + " ";
    for (const char* words : {"run rec --quiet -o limited", "report out -o page.html"}) {
      const Outcome outcome = chasles(folder, words, few + "timeout -k 1 20 ");
      if (outcome.code == 0) continue;
      EXPECT_LE(outcome.code, 2) << limit << " " << words;
      expect_part(outcome.err, "Too many open files");
    }
    const Outcome view = chasles(folder, "view out --port 0", few + "timeout -s INT 2 ");
    if (view.code == 1) expect_part(view.err, "ulimit -n");
    EXPECT_NE(view.code, 70);
  }
}

TEST(Command, ARemovedWorkingFolderIsSaid) {
  const Scratch folder;
  std::filesystem::create_directory(folder / "gone");
  const std::string command = "cd '" + (folder / "gone").string() + "' && rmdir ../gone && '" +
                              CHASLES_BINARY + "' simulate street -o x 2>'" +
                              (folder / "e").string() + "'";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 1);
  expect_part(slurp(folder / "e"), "the working folder was removed: change to another folder");
}

// A name with control characters would command the terminal.
TEST(Command, NamesOfFilesCommandNoTerminal) {
  const Scratch folder;
  simulate(folder);
  std::filesystem::rename(folder / "rec", folder / "r\x1b]0;x\x07\xc2\x9b");
  const Outcome run = chasles(folder, "run r* -o \"$(printf 'o\\033[31m')\"");
  EXPECT_EQ(run.code, 0) << run.err;
  const Outcome check = chasles(folder, "check r*");
  const Outcome none = chasles(folder, "run \"$(printf 'none\\033[31m')\"");
  for (const std::string& text : {run.out, run.err, check.out, check.err, none.out, none.err}) {
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << text;
    EXPECT_EQ(text.find('\x07'), std::string::npos) << text;
    EXPECT_EQ(text.find("\xc2\x9b"), std::string::npos) << text;
  }
  expect_part(run.out, "run folder: o\\u001b[31m\n");
}

TEST(Command, TwoProcessesDoNotWriteIntoOneFolder) {
  const Scratch folder;
  Process first(folder, {"montecarlo", "turntable", "--runs", "40", "--charts", "standard", "-o",
                         (folder / "study").string(), "--workers", "1", "--quiet"});
  while (slurp(folder / "study/plan.json").empty()) ::usleep(1000);
  expect_error(
      chasles(folder, "montecarlo turntable --runs 40 --charts standard -o study --resume"), 1,
      "study: another process is writing into it");
  EXPECT_EQ(first.code_after(SIGINT), 130) << first.output();
  EXPECT_EQ(chasles(folder, "montecarlo turntable --runs 2 --charts standard -o other").code, 0);
}

TEST(Command, AnInterruptedComparisonSaysSoAndLeavesNoFolder) {
  const Scratch folder;
  Process compare(folder, {"compare", "hallway", "-o", (folder / "new/deep").string()});
  while (!std::filesystem::exists(folder / "new/deep")) ::usleep(1000);
  EXPECT_EQ(compare.code_after(SIGINT), 130);
  expect_part(compare.output(), "chasles: error: interrupted: nothing was written");
  EXPECT_FALSE(std::filesystem::exists(folder / "new"));
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

TEST(Command, SimulateRejectsSettingsOutOfRange) {
  const Scratch folder;
  expect_error(chasles(folder, "simulate street -o r --set cruise_speed=-3"), 1, "cruise_speed");
  expect_error(chasles(folder, "simulate street -o r --set seed=-3"), 1, "--set: seed: found '-3'");
  expect_error(chasles(folder, "simulate street -o r --set pixel_sgima=1"), 1,
               "did you mean 'pixel_sigma'?");
  EXPECT_FALSE(std::filesystem::exists(folder / "r"));
}

}  // namespace
}  // namespace chasles::test
