#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/foxglove/testing.hpp>

namespace chasles {
namespace {

using test::foxglove_start;
using test::synthetic_drive;
using test::Watcher;

const std::vector<std::string> kOfStates = {"/tf", "/pose", "/odometry", "/state"};

std::vector<RunState> part(const ReportRun& drive, std::size_t from, std::size_t to) {
  const auto at = [&](std::size_t i) {
    return drive.run.states.begin() + static_cast<std::ptrdiff_t>(i);
  };
  return {at(from), at(to)};
}

/// A client that has heard all that there was to hear before it subscribed.
struct Seen {
  explicit Seen(FoxgloveChannels& channels) : session(channels, "chasles 0: drive", "id") {
    watcher.drain(session);
  }
  void subscribe(const std::vector<std::string>& topics) {
    EXPECT_TRUE(session.take(watcher.subscription(topics), false));
  }
  std::size_t count(const std::string& topic) const { return watcher.count(topic); }
  std::string last_status() const {
    return watcher.statuses.empty() ? "" : watcher.statuses.back().at("message");
  }

  FoxgloveSession session;
  Watcher watcher;
};

TEST(FoxgloveSession, TheServerIntroducesItselfAndItsChannels) {
  FoxgloveChannels channels;
  FoxgloveSession session(channels, "chasles 0", "id");
  Watcher watcher;
  watcher.drain(session);
  EXPECT_EQ(watcher.info.at("name"), "chasles 0");
  EXPECT_EQ(watcher.info.at("sessionId"), "id");
  EXPECT_TRUE(watcher.channels.empty()) << "the run has not started";
  channels.begin(foxglove_start(synthetic_drive({.states = 10, .landmarks = 3}), 2, true));
  watcher.drain(session);
  for (const char* topic : {"/tf", "/tf_cameras", "/pose", "/odometry", "/state", "/errors",
                            "/truth/pose", "/ways", "/map", "/map/ellipsoids", "/cam0/image",
                            "/cam0/annotations", "/cam1/image", "/cam1/annotations"}) {
    EXPECT_TRUE(watcher.channels.contains(topic)) << topic;
  }
  EXPECT_EQ(watcher.channels.size(), 14u);
  const ReportRun blind = synthetic_drive({.states = 10, .landmarks = 3, .truth = false});
  FoxgloveChannels fewer;
  fewer.begin(foxglove_start(blind, 1, false));
  Seen seen(fewer);
  EXPECT_FALSE(seen.watcher.channels.contains("/errors"));
  EXPECT_FALSE(seen.watcher.channels.contains("/cam0/image")) << "a recording of tracks";
  EXPECT_TRUE(seen.watcher.channels.contains("/cam0/annotations"));
}

TEST(FoxgloveSession, StatesComeOnceInOrderAndOnlyToThoseWhoSubscribed) {
  const ReportRun drive = synthetic_drive({.states = 300, .landmarks = 3});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  Seen seen(channels), other(channels);
  seen.subscribe({"/pose", "/state", "/errors", "/truth/pose"});
  for (std::size_t i = 0; i < 300; i += 50) {
    channels.add(part(drive, i, i + 50));
    seen.watcher.drain(seen.session);
    other.watcher.drain(other.session);
  }
  EXPECT_EQ(seen.count("/pose"), 300u);
  EXPECT_EQ(seen.count("/state"), 300u);
  EXPECT_EQ(seen.count("/errors"), 300u);
  EXPECT_EQ(seen.count("/truth/pose"), 300u);
  EXPECT_TRUE(std::ranges::is_sorted(seen.watcher.times)) << "those of one time come together";
  EXPECT_EQ(seen.watcher.clock.size(), 300u);
  EXPECT_TRUE(other.watcher.messages.empty());
  EXPECT_EQ(other.watcher.clock.back(), drive.run.states.back().time) << "but it hears the time";
}

TEST(FoxgloveSession, ALateClientGetsTheLastStatesAndTheWholePath) {
  const ReportRun drive = synthetic_drive({.states = 5000, .landmarks = 30});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  channels.add(drive.run.states);
  channels.map({.landmarks = drive.run.landmarks});
  channels.show();
  Seen late(channels);
  late.subscribe({"/pose", "/ways", "/map"});
  late.watcher.drain(late.session);
  EXPECT_EQ(late.count("/pose"), StateChannel::kMostBehind);
  EXPECT_EQ(late.watcher.times.back(), drive.run.states.back().time);
  // The beginning, ten pieces of 500 states, and the truth.
  EXPECT_EQ(late.count("/ways"), 12u);
  EXPECT_EQ(late.count("/map"), 1u);
}

TEST(FoxgloveSession, ASlowClientMissesStatesAndHoldsNothingUp) {
  const ReportRun drive = synthetic_drive({.states = 5000, .landmarks = 3});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  Seen slow(channels);
  slow.subscribe({"/pose"});
  for (std::size_t i = 0; i < 5000; i += 10) {
    channels.add(part(drive, i, i + 10));
    // It takes one message while ten states come.
    if (const LiveMessage message = slow.session.next()) {
      slow.watcher.take(*message.bytes, message.binary);
    }
  }
  slow.watcher.drain(slow.session);
  EXPECT_LT(slow.count("/pose"), StateChannel::kMostBehind + 500);
  EXPECT_GE(slow.count("/pose"), StateChannel::kMostBehind);
  EXPECT_EQ(slow.watcher.times.back(), drive.run.states.back().time);
}

TEST(FoxgloveSession, OfMapsAndFramesOnlyTheLatestIsSent) {
  ReportRun drive = synthetic_drive({.states = 50, .landmarks = 30});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive, 1, true));
  channels.add(drive.run.states);
  Seen seen(channels);
  EXPECT_FALSE(channels.shows_frames());
  seen.subscribe({"/map", "/map/ellipsoids", "/cam0/image", "/cam0/annotations"});
  EXPECT_TRUE(channels.shows_frames());
  const GrayImage picture{.width = 64, .height = 48, .pixels = std::vector<std::uint8_t>(64 * 48)};
  for (int k = 0; k < 5; ++k) {
    drive.run.landmarks.pop_back();
    channels.map({.landmarks = drive.run.landmarks});
    ShownImage image{
        .time = Time(k), .camera = 0, .width = 64, .height = 48, .jpeg = {}, .features = {}};
    channels.frame({.images = {image}, .pictures = {picture}});
  }
  seen.watcher.drain(seen.session);
  for (const char* topic : {"/map", "/map/ellipsoids", "/cam0/image", "/cam0/annotations"}) {
    EXPECT_EQ(seen.count(topic), 1u) << topic;
  }
  EXPECT_GT(seen.watcher.messages[seen.watcher.id("/map")][0].size(), 25u * 20);
  EXPECT_LT(seen.watcher.messages[seen.watcher.id("/map")][0].size(), 25u * 20 + 300);
  EXPECT_NE(seen.watcher.messages[seen.watcher.id("/cam0/image")][0].find("\xff\xd8\xff"),
            std::string::npos)
      << "a JPEG";
  EXPECT_EQ(seen.watcher.times.front(), Time(4));
}

TEST(FoxgloveSession, WhoeverUnsubscribesGetsNoMoreAndMaySubscribeAgain) {
  const ReportRun drive = synthetic_drive({.states = 40, .landmarks = 3});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive, 1, true));
  Seen seen(channels);
  seen.subscribe({"/pose", "/cam0/image"});
  channels.add(part(drive, 0, 10));
  seen.watcher.drain(seen.session);
  const std::uint32_t pose = seen.watcher.id("/pose"), image = seen.watcher.id("/cam0/image");
  const std::string end =
      fmt::format(R"({{"op": "unsubscribe", "subscriptionIds": [{}, {}]}})", pose, image);
  EXPECT_TRUE(seen.session.take(end, false));
  EXPECT_FALSE(channels.shows_frames());
  channels.add(part(drive, 10, 20));
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/pose"), 10u);
  seen.subscribe({"/pose"});
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/pose"), 30u) << "with those that it has missed";
  EXPECT_TRUE(seen.watcher.statuses.empty());
}

TEST(FoxgloveSession, AClientThatLeavesIsNoSubscriberAnyMore) {
  FoxgloveChannels channels;
  channels.begin(foxglove_start(synthetic_drive({.states = 5, .landmarks = 3}), 1, true));
  {
    Seen seen(channels);
    seen.subscribe({"/cam0/image"});
    EXPECT_TRUE(channels.shows_frames());
  }
  EXPECT_FALSE(channels.shows_frames());
}

TEST(FoxgloveSession, AnEstimateThatReplacesAllStatesIsSentAnew) {
  const ReportRun drive = synthetic_drive({.states = 100, .landmarks = 20});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  channels.add(drive.run.states);
  Seen seen(channels);
  seen.subscribe({"/pose", "/ways", "/map"});
  seen.watcher.drain(seen.session);
  auto smoothed = drive.run;
  channels.finish(smoothed, "{}");
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/pose"), 100u) << "the same states are not sent again";
  for (RunState& s : smoothed.states) s.world_T_imu.p.x() += 0.1;
  channels.finish(smoothed, "{}");
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/pose"), 200u);
  EXPECT_EQ(seen.watcher.clock.size(), 1u + 100) << "the time begins again";
}

TEST(FoxgloveSession, ClosuresAndTheSavedMapComeWhenTheyAreThere) {
  const ReportRun drive = synthetic_drive({.states = 50, .landmarks = 30, .prior_map = true});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  channels.add(drive.run.states);
  Seen seen(channels);
  EXPECT_FALSE(seen.watcher.channels.contains("/closures"));
  EXPECT_FALSE(seen.watcher.channels.contains("/tf_map"));
  const auto closure = [&](std::size_t state) {
    return fmt::format(R"({{"time_ns": {}, "landmarks": 6, "moved_m": 0.25}})",
                       drive.run.states[state].time.count());
  };
  channels.map({.landmarks = drive.run.landmarks,
                .known = "{\"closures\": [" + closure(20) + "]}",
                .prior_map = drive.run.prior_map});
  seen.watcher.drain(seen.session);
  seen.subscribe({"/closures", "/map/prior", "/tf_map"});
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/closures"), 1u);
  EXPECT_EQ(seen.count("/map/prior"), 1u);
  EXPECT_EQ(seen.count("/tf_map"), 1u);
  channels.map({.landmarks = drive.run.landmarks,
                .known = "{\"closures\": [" + closure(20) + "," + closure(40) + "]}"});
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.count("/closures"), 2u) << "the new one alone";
}

TEST(FoxgloveSession, TimesBefore1970AreLeftOutWithAWarning) {
  ReportRun drive = synthetic_drive({.states = 20, .landmarks = 3, .truth = false});
  const Time first = drive.run.states.front().time;
  for (RunState& s : drive.run.states) s.time -= first + std::chrono::seconds(1);
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  channels.add(drive.run.states);
  channels.finish(drive.run, "{}");
  Seen seen(channels);
  seen.subscribe({"/pose"});
  seen.watcher.drain(seen.session);
  const auto late = std::ranges::count_if(drive.run.states,
                                          [](const RunState& s) { return s.time.count() >= 0; });
  ASSERT_GT(late, 0);
  EXPECT_EQ(seen.count("/pose"), static_cast<std::size_t>(late));
  ASSERT_EQ(seen.watcher.statuses.size(), 1u);
  EXPECT_EQ(seen.watcher.statuses[0].at("level"), 1);
}

TEST(FoxgloveSession, FaultsAreAnsweredAndTheClientGoesOn) {
  const ReportRun drive = synthetic_drive({.states = 10, .landmarks = 3});
  FoxgloveChannels channels;
  channels.begin(foxglove_start(drive));
  channels.add(drive.run.states);
  Seen seen(channels);
  const auto answered = [&](const std::string& text, bool binary = false) {
    EXPECT_TRUE(seen.session.take(text, binary)) << text;
    seen.watcher.drain(seen.session);
    return seen.last_status();
  };
  EXPECT_EQ(answered("nonsense"), "expected a json object with 'op'");
  EXPECT_EQ(answered("\x01\x01", true),
            "found a binary message: this server only sends, it takes no data");
  EXPECT_EQ(answered(R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 77}]})"),
            "subscribe: there is no channel 77");
  EXPECT_EQ(answered(R"({"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 0}]})"),
            "subscribe: there is no channel 0");
  EXPECT_EQ(answered(R"({"op": "unsubscribe", "subscriptionIds": [5]})"),
            "unsubscribe: there is no subscription 5");
  seen.subscribe({"/pose"});
  const std::uint32_t pose = seen.watcher.channels.at("/pose");
  EXPECT_EQ(answered(seen.watcher.subscription({"/pose"})),
            fmt::format("subscribe: subscription {} exists already", pose + 100));
  EXPECT_EQ(answered(fmt::format(
                R"({{"op": "subscribe", "subscriptions": [{{"id": 1, "channelId": {}}}]}})", pose)),
            fmt::format("subscribe: channel {} has a subscription already", pose));
  EXPECT_EQ(seen.count("/pose"), 10u);
}

TEST(FoxgloveSession, AFloodOfFaultsEndsTheConnectionAndFillsNoMemory) {
  FoxgloveChannels channels;
  Seen seen(channels);
  int taken = 0;
  while (seen.session.take("nonsense", false)) ++taken;
  EXPECT_EQ(taken, FoxgloveSession::kMostFaults);
  seen.watcher.drain(seen.session);
  EXPECT_EQ(seen.watcher.statuses.size(), FoxgloveSession::kMostReplies);
  // A single message may have many faults.
  Seen other(channels);
  std::string list = R"({"id": 1, "channelId": 99})";
  for (int k = 0; k < 1000; ++k) list += R"(,{"id": 1, "channelId": 99})";
  EXPECT_FALSE(
      other.session.take(R"({"op": "subscribe", "subscriptions": [)" + list + "]}", false));
}

}  // namespace
}  // namespace chasles
