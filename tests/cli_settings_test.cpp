#include <filesystem>

#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/settings_io.hpp>
#include <chasles/session/velocity_settings_io.hpp>

#include "cli_test.hpp"
#include "scene_options.hpp"

namespace chasles::app {
namespace {

using test::expect_part;
using test::Scratch;
using test::spill;

std::string rejection(const std::string& assignment) {
  VelocitySlamSettings settings;
  try {
    set(setting_list(settings), assignment);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "nothing was rejected";
}

std::string rejection_of_file(const std::string& yaml) {
  const Scratch folder;
  spill(folder / "c.yaml", yaml);
  VelocitySlamSettings settings;
  try {
    set_from_file(setting_list(settings), folder / "c.yaml");
  } catch (const UsageError& error) {
    return error.what();
  }
  return "nothing was rejected";
}

TEST(Settings, EveryDefaultIsAcceptedAsItIsPrinted) {
  VelocitySlamSettings settings;
  const SettingList list = setting_list(settings);
  const auto before = to_json(list);
  for (const Setting& s : list) EXPECT_NO_THROW(set(list, s.name + "=" + value_text(s))) << s.name;
  EXPECT_EQ(to_json(list), before);
}

TEST(Settings, AreReadInEveryNotationOfANumber) {
  VelocitySlamSettings settings;
  const SettingList list = setting_list(settings);
  for (const char* text : {"2e-3", "0.002", ".002", "+2E-3", " 0.002 "}) {
    settings.velocity_sigma.reset();
    set(list, std::string("velocity_sigma=") + text);
    EXPECT_EQ(settings.velocity_sigma, 2e-3) << text;
  }
  set(list, "velocity_sigma=auto");
  EXPECT_FALSE(settings.velocity_sigma);
  set(list, "gyro_bias=false");
  EXPECT_FALSE(settings.gyro_bias);
}

TEST(Settings, ThatAreNotNumbersAreRejected) {
  for (const char* text : {"nan", "inf", "-inf", "1e999", "", "1.5x", "0x10", "1,5", "eins"}) {
    expect_part(rejection(std::string("velocity_sigma=") + text),
                std::string("--set: velocity_sigma: found '") + text +
                    "', expected a finite number not below 0 [m/s], or auto");
  }
}

TEST(Settings, OutOfRangeAreRejected) {
  expect_part(rejection("gate=0"), "found '0', expected a finite number above 0 and not above 1");
  expect_part(rejection("gate=1.01"), "not above 1");
  expect_part(rejection("waiting_landmarks=-1"), "expected a whole number not below 0");
  expect_part(rejection("waiting_landmarks=2.5"), "expected a whole number not below 0");
  expect_part(rejection("waiting_landmarks=99999999999"), "expected a whole number not below 0");
  expect_part(rejection("pixel_sigma=0"), "expected a finite number above 0");
  expect_part(rejection("gyro_bias=1"), "found '1', expected true or false");
}

TEST(Settings, WithChoicesListThem) {
  expect_part(rejection("chart=left"),
              "found 'left', expected one of standard, left-se3, right-se3, right-sen3");
}

TEST(Settings, NeedAKeyAndAValue) {
  expect_part(rejection("gate"), "--set: found 'gate', expected key=value");
  expect_part(rejection("=1"), "expected key=value");
  expect_part(rejection("gaet=1"), "--set: unknown key 'gaet'; did you mean 'gate'? (known keys: ");
}

TEST(Settings, OfAGroupAreSuggestedForTheirNameAlone) {
  const auto rejection_of = [](const std::string& assignment) -> std::string {
    SettingSources sources;
    sources.sets = {assignment};
    try {
      inertial_run_settings_from(sources);
    } catch (const UsageError& error) {
      return error.what();
    }
    return "nothing was rejected";
  };
  const std::string message = rejection_of("predicted_levels=1");
  expect_part(message, "; did you mean 'frontend.predicted_levels'? (--help lists the ");
  EXPECT_LT(message.size(), 120U);  // not a list of a hundred names
  expect_part(rejection_of("predicted_level=1"), "did you mean 'frontend.predicted_levels'?");
  expect_part(rejection_of("frontend.max_track=1"), "did you mean 'frontend.max_tracks'?");
  expect_part(rejection_of("max_tracks=1"), "'start.max_tracks' or 'frontend.max_tracks'?");
}

TEST(SettingsFile, NamesTheLineOfAnUnknownKey) {
  const std::string message = rejection_of_file("# a comment\n\ngate: 0.9\nchrat: standard\n");
  expect_part(message, "c.yaml:4: unknown key 'chrat'; did you mean 'chart'? (known keys: mode, ");
}

TEST(SettingsFile, NamesTheLineOfAMalformedValue) {
  expect_part(rejection_of_file("gate: .nan\n"), "c.yaml:1: gate: found '.nan'");
  expect_part(rejection_of_file("gate: 0.9\npixel_sigma: wide\n"), "c.yaml:2: pixel_sigma: found");
  expect_part(rejection_of_file("gate:\n"), "c.yaml:1: gate: found '', expected");
  expect_part(rejection_of_file("gate: [0.9, 1]\n"), "c.yaml:1: gate: found 'a list or a map'");
}

TEST(SettingsFile, ThatIsNoListOfSettingsIsRejected) {
  expect_part(rejection_of_file("- gate\n"), "c.yaml:1: expected lines of `key: value`");
  expect_part(rejection_of_file("gate: 0.9\n  chart: {\n"), "c.yaml:2: not YAML: ");
  expect_part(rejection_of_file("gate: 0.9\nmode: slam\ngate: 0.8\n"),
              "c.yaml:3: key 'gate' is repeated");
  expect_part(rejection_of_file("just words\n"), "c.yaml:1: expected lines of `key: value`");
}

TEST(SettingsFile, MayBeEmpty) {
  EXPECT_EQ(rejection_of_file("# nothing but a comment\n"), "nothing was rejected");
  EXPECT_EQ(rejection_of_file(""), "nothing was rejected");
}

TEST(SettingsFile, ThatIsMissingIsABadInput) {
  VelocitySlamSettings settings;
  EXPECT_THROW(set_from_file(setting_list(settings), "/nonexistent/c.yaml"), InputError);
}

TEST(SettingsSources, LaterOnesWin) {
  const Scratch folder;
  spill(folder / "c.yaml", "gate: 0.5\nchart: standard\nmin_disparity: 3\nmode: localize\n");
  const VelocitySlamSettings settings =
      velocity_run_settings_from({.config = (folder / "c.yaml").string(),
                                  .sets = {"gate=0.6", "chart=right-se3", "gate=0.7"},
                                  .chart = "left-se3",
                                  .mode = ""})
          .filter;
  EXPECT_EQ(settings.waiting_landmarks, VelocitySlamSettings{}.waiting_landmarks);
  EXPECT_EQ(settings.min_disparity, 3);
  EXPECT_EQ(settings.gate, 0.7);
  EXPECT_EQ(settings.chart, "left-se3");
  EXPECT_EQ(settings.mode, SlamMode::kLocalize);
}

TEST(SettingsSources, ThePapersParameterSetsAreRead) {
  const std::string configs = CHASLES_SOURCE_DIR "/studies/configs/";
  const VelocitySlamSettings one =
      velocity_run_settings_from(
          {.config = configs + "du-set1.yaml", .sets = {}, .chart = "", .mode = ""})
          .filter;
  const VelocitySlamSettings two =
      velocity_run_settings_from(
          {.config = configs + "du-set2.yaml", .sets = {}, .chart = "", .mode = ""})
          .filter;
  EXPECT_NEAR(*one.pixel_sigma * *one.pixel_sigma, 1e5, 1e-9);  // Du, Table 1
  EXPECT_NEAR(*two.pixel_sigma * *two.pixel_sigma, 1e3, 1e-9);  // Du, Table 2
  for (const VelocitySlamSettings& s : {one, two}) {
    EXPECT_NEAR(*s.velocity_sigma * *s.velocity_sigma, 1e-6, 1e-18);
    EXPECT_NEAR(*s.rate_sigma * *s.rate_sigma, 1e-6, 1e-18);
    EXPECT_NEAR(s.initial_pose_sigma * s.initial_pose_sigma, 1e-2, 1e-12);
    EXPECT_NEAR(*s.initial_landmark_sigma * *s.initial_landmark_sigma, 1e-2, 1e-12);
  }
}

// The settings of stereo-velocity runs, of visual-inertial runs and of the simulator.
TEST(SettingsSources, EveryFileOfTheRepositoryIsReadByWhomItIsFor) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(CHASLES_SOURCE_DIR "/studies/configs")) {
    const std::string name = entry.path().filename().string(), file = entry.path().string();
    if (name.starts_with("scene-")) {
      SceneChoice scene;
      scene.name = "hallway";  // it needs no path
      scene.config = file;
      EXPECT_NO_THROW(scene_from(scene)) << name;
    } else if (name.starts_with("du-")) {
      EXPECT_NO_THROW(
          velocity_run_settings_from({.config = file, .sets = {}, .chart = "", .mode = ""}))
          << name;
    } else {
      EXPECT_NO_THROW(
          inertial_run_settings_from({.config = file, .sets = {}, .chart = "", .mode = ""}))
          << name;
    }
    ++files;
  }
  EXPECT_GE(files, 8);
}

TEST(SettingsSources, ThatDoNotGoTogetherAreRejectedBeforeTheRecordingIsRead) {
  const auto rejected = [](auto read, const std::vector<std::string>& sets) -> std::string {
    try {
      read({.config = "", .sets = sets, .chart = "", .mode = ""});
    } catch (const UsageError& error) {
      return error.what();
    }
    return "nothing was rejected";
  };
  expect_part(rejected(velocity_run_settings_from, {"velocity_axes=level", "mode=map"}),
              "velocity_axes=level");
  expect_part(rejected(inertial_run_settings_from, {"composition_interval=1"}),
              "composition_interval: found 1, expected 0 without nav_attitude");
  expect_part(rejected(inertial_run_settings_from, {"start.max_window=0.5"}),
              "start.max_window: found 0.5");
  expect_part(rejected(inertial_run_settings_from, {"frontend.window=14"}),
              "frontend.window: found 14, expected an odd number");
  expect_part(rejected(inertial_run_settings_from, {"init=multiview"}),
              "--set: init: found 'multiview', expected one of multi-view, fixed-depth");
}

}  // namespace
}  // namespace chasles::app
