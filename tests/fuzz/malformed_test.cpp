#include <algorithm>
#include <optional>
#include <ostream>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>

#include "kinds.hpp"
#include "mutate.hpp"

// Valid recordings with small damages, the same in every run: a reader either reads them or throws
// InputError. The long search is `make fuzz`.
namespace chasles::fuzz {

void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

namespace {

namespace fs = std::filesystem;

class Malformed : public ::testing::TestWithParam<Kind> {
 public:
  ~Malformed() override { fs::remove_all(scratch); }

 protected:
  /// The message if the bytes were rejected; nothing if they were read. The test fails on any
  /// exception but InputError.
  std::optional<std::string> rejection(const std::string& bytes) const {
    try {
      GetParam().read(scratch, bytes);
      return std::nullopt;
    } catch (const InputError& error) {
      return error.what();
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not an InputError: " << error.what();
      return error.what();
    }
  }

  fs::path scratch = make_scratch();
};

TEST_P(Malformed, TheSeedItselfIsRead) {
  EXPECT_EQ(rejection(GetParam().seed(scratch)), std::nullopt);
}

TEST_P(Malformed, DamagedBytesAreReadOrRejectedAndNothingElse) {
  constexpr int kTries = 1000;
  const std::string seed = GetParam().seed(scratch);
  Dice dice(20240607);
  int rejected = 0;
  for (int i = 0; i < kTries && !HasFailure(); ++i) {
    SCOPED_TRACE("damage " + std::to_string(i));
    if (rejection(mutate(seed, dice))) ++rejected;
  }
  // If all or none were rejected, the damages would not test the intended code.
  EXPECT_GT(rejected, kTries / 5);
  EXPECT_LT(rejected, kTries);
}

TEST_P(Malformed, EveryTruncationIsReadOrRejected) {
  const std::string seed = GetParam().seed(scratch);
  const std::size_t step = std::max<std::size_t>(1, seed.size() / 300);
  for (std::size_t size = 0; size < seed.size() && !HasFailure(); size += step) {
    SCOPED_TRACE("the first " + std::to_string(size) + " bytes");
    rejection(seed.substr(0, size));
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, Malformed, ::testing::ValuesIn(kinds()),
                         [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace
}  // namespace chasles::fuzz
