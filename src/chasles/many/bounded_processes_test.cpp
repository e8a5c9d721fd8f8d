#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <chasles/base/processor_time.hpp>
#include <chasles/many/bounded_processes.hpp>

namespace chasles {
namespace {

using How = EndedProcess::How;
using Ends = std::map<std::size_t, EndedProcess>;

bool never() { return false; }

Ends ends_of(const std::vector<std::size_t>& items, const BoundedWork& work,
             const ProcessBounds& bounds = {}, int jobs = 2) {
  Ends ends;
  EXPECT_TRUE(run_in_bounded_processes(
      items, jobs, bounds, work,
      [&](std::size_t item, const EndedProcess& end) {
        EXPECT_FALSE(ends.contains(item)) << "item " << item << " ended twice";
        ends[item] = end;
      },
      never));
  return ends;
}

TEST(BoundedProcesses, ReturnTheResultOfEachItemWhole) {
  const auto work = [](std::size_t item, const std::function<void(double)>& minutes) {
    minutes(1);
    return std::string(100'000 * item, static_cast<char>('a' + item));
  };
  const Ends ends = ends_of({0, 1, 2, 3, 4}, work);
  ASSERT_EQ(ends.size(), 5u);
  for (const auto& [item, end] : ends) {
    EXPECT_EQ(end.how, How::kDone);
    EXPECT_EQ(end.result, std::string(100'000 * item, static_cast<char>('a' + item)));
    EXPECT_EQ(end.attempts, 1);
    EXPECT_GT(end.peak_bytes, 1'000'000u);
  }
}

TEST(BoundedProcesses, TheOthersGoOnWhenOneDies) {
  const auto work = [](std::size_t item, const auto&) -> std::string {
    if (item == 1) raise(SIGSEGV);
    if (item == 2) _exit(7);
    return "done";
  };
  const Ends ends = ends_of({0, 1, 2, 3}, work);
  EXPECT_EQ(ends.at(0).result, "done");
  EXPECT_EQ(ends.at(1).how, How::kDied);
  EXPECT_EQ(ends.at(1).attempts, 2);
  EXPECT_NE(ends.at(1).result.find("signal 11"), std::string::npos) << ends.at(1).result;
  EXPECT_NE(ends.at(2).result.find("ended with 7"), std::string::npos) << ends.at(2).result;
  EXPECT_EQ(ends.at(3).result, "done");
}

// As the system kills a process when memory runs out, or a person does.
TEST(BoundedProcesses, AProcessThatDiesOnceIsTriedAgain) {
  const std::filesystem::path mark =
      std::filesystem::path(::testing::TempDir()) / ("bounded_" + std::to_string(getpid()));
  const auto work = [&](std::size_t, const auto&) -> std::string {
    if (!std::filesystem::exists(mark)) {
      std::ofstream(mark) << "x";
      raise(SIGKILL);
    }
    return "at the second attempt";
  };
  const Ends ends = ends_of({4}, work);
  std::filesystem::remove(mark);
  EXPECT_EQ(ends.at(4).how, How::kDone);
  EXPECT_EQ(ends.at(4).result, "at the second attempt");
  EXPECT_EQ(ends.at(4).attempts, 2);
}

TEST(BoundedProcesses, ABoundOnMemoryEndsAProcessAlone) {
  const auto work = [](std::size_t item, const auto&) -> std::string {
    if (item == 0) return "small";
    std::vector<char> memory(150'000'000);
    std::memset(memory.data(), 1, memory.size());
    std::this_thread::sleep_for(std::chrono::seconds(20));
    return std::to_string(memory[7]);
  };
  const Ends ends = ends_of({0, 1}, work, {.megabytes_per_minute = 50});  // 100 MB for 2 minutes
  EXPECT_EQ(ends.at(0).result, "small");
  EXPECT_EQ(ends.at(1).how, How::kMemory);
  EXPECT_EQ(ends.at(1).result, "needed more than 100 MB");
}

TEST(BoundedProcesses, ABoundOnTimeCountsTheProcessor) {
  const auto work = [](std::size_t, const auto&) -> std::string {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
    while (std::chrono::steady_clock::now() < end) {
    }
    return "";
  };
  const Ends ends = ends_of({0}, work, {.seconds_per_minute = 0.15});
  EXPECT_EQ(ends.at(0).how, How::kTime);
  EXPECT_LT(ends.at(0).cpu_seconds, 3);
}

TEST(BoundedProcesses, AProcessThatWaitsForNothingEndsByTheClock) {
  const auto work = [](std::size_t, const auto&) -> std::string {
    std::this_thread::sleep_for(std::chrono::seconds(60));
    return "";
  };
  const Ends ends = ends_of({0}, work, {.seconds_per_minute = 0.025});
  EXPECT_EQ(ends.at(0).how, How::kTime);
  EXPECT_LT(ends.at(0).wall_seconds, 30);
}

// A long recording has more time than a short one.
TEST(BoundedProcesses, TheBoundsGrowWithTheRecording) {
  const auto work = [](std::size_t item,
                       const std::function<void(double)>& minutes) -> std::string {
    minutes(item == 0 ? 1 : 1e6);
    while (process_seconds() < 1.5) {
    }
    return "done";
  };
  const Ends ends = ends_of({0, 1}, work, {.seconds_per_minute = 0.05}, 1);
  EXPECT_EQ(ends.at(0).how, How::kTime);
  EXPECT_EQ(ends.at(1).how, How::kDone);
}

TEST(BoundedProcesses, AStopKillsThoseInProgress) {
  int asked = 0;
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<std::size_t> items = {0, 1};
  EXPECT_FALSE(run_in_bounded_processes(
      items, 2, {},
      [](std::size_t, const auto&) -> std::string {
        std::this_thread::sleep_for(std::chrono::seconds(60));
        return "";
      },
      [](std::size_t, const EndedProcess&) { ADD_FAILURE() << "none may end"; },
      [&] { return ++asked > 3; }));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a process is left";
}

}  // namespace
}  // namespace chasles
