#include <csignal>
#include <map>
#include <stdexcept>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lab/workers.hpp>

namespace chasles {
namespace {

using Results = std::map<std::uint64_t, std::string>;

std::string square(std::uint64_t item) {
  // Longer than a pipe's buffer, so that messages arrive in pieces.
  return std::to_string(item * item) + std::string(70000 + item, 'x');
}

Results collect(std::span<const std::uint64_t> items, int workers,
                const std::function<std::string(std::uint64_t)>& work) {
  Results results;
  work_in_processes(items, workers, work, [&](std::uint64_t item, const std::string& result) {
    EXPECT_TRUE(results.emplace(item, result).second) << item << " came twice";
  });
  return results;
}

Error error_of(int workers, const std::function<std::string(std::uint64_t)>& work) {
  const std::vector<std::uint64_t> items{1, 2, 3, 4, 5};
  try {
    collect(items, workers, work);
  } catch (const Error& error) {
    return error;
  }
  return {ExitCode::kOk, "nothing was thrown"};
}

TEST(Workers, DoEveryItemOnceWhateverTheirNumber) {
  const std::vector<std::uint64_t> items{7, 3, 1u << 20, 0, 12, 5, 6};
  Results expected;
  for (const std::uint64_t item : items) expected[item] = square(item);
  for (const int workers : {0, 1, 2, 3, 20}) EXPECT_EQ(collect(items, workers, square), expected);
}

TEST(Workers, HaveNothingToDoWithoutItems) {
  const auto never = [](std::uint64_t) -> std::string { throw std::logic_error("called"); };
  EXPECT_TRUE(collect({}, 3, never).empty());
}

TEST(Workers, WorkInOtherProcesses) {
  const std::vector<std::uint64_t> items{1, 2, 3};
  const auto process = [](std::uint64_t) { return std::to_string(getpid()); };
  for (const auto& [item, result] : collect(items, 2, process)) {
    EXPECT_NE(result, std::to_string(getpid()));
  }
}

TEST(Workers, HandOnAnErrorWithItsMessageAndCode) {
  const auto work = [](std::uint64_t item) -> std::string {
    if (item == 3) throw UsageError("three is too much");
    return "";
  };
  for (const int workers : {1, 2}) {
    const Error error = error_of(workers, work);
    EXPECT_STREQ(error.what(), "three is too much");
    EXPECT_EQ(error.code(), ExitCode::kUsage);
  }
}

TEST(Workers, MakeAnErrorOfAnyException) {
  const auto work = [](std::uint64_t) -> std::string { throw std::logic_error("a fault"); };
  EXPECT_STREQ(error_of(2, work).what(), "a fault");
}

TEST(Workers, OfThisProcessLeaveAnExceptionAsItIs) {
  const auto work = [](std::uint64_t) -> std::string { throw std::logic_error("a fault"); };
  EXPECT_THROW(error_of(1, work), std::logic_error);
}

TEST(Workers, ThatDieAreAnError) {
  const auto work = [](std::uint64_t item) -> std::string {
    if (item == 4) raise(SIGKILL);
    return "";
  };
  const Error error = error_of(2, work);
  EXPECT_EQ(error.code(), ExitCode::kBadInput);
  EXPECT_NE(std::string(error.what()).find("died by signal 9"), std::string::npos) << error.what();
}

TEST(Workers, StopWhereTheReceiverThrows) {
  const std::vector<std::uint64_t> items(1000, 1);
  int received = 0;
  const auto stop = [&](std::uint64_t, const std::string&) {
    ++received;
    throw std::runtime_error("enough");
  };
  EXPECT_THROW(work_in_processes(items, 2, square, stop), std::runtime_error);
  EXPECT_EQ(received, 1);
}

}  // namespace
}  // namespace chasles
