#include <gtest/gtest.h>

#include <chasles/pipeline/stamp_leaps.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;
using Times = std::vector<int>;

struct Stamped {
  Time time{};
};

/// Milliseconds of what passes.
class Topic {
 public:
  Times add(int ms) {
    auto passed = leaps.add({milliseconds(ms)});
    jumped = passed.jumped_back;
    Times times;
    for (const Stamped& s : passed.messages)
      times.push_back(static_cast<int>(s.time.count() / 1000000));
    return times;
  }
  StampLeaps<Stamped> leaps;
  bool jumped = false;
};

TEST(StampLeaps, PassesOnWhatComesInOrderOrALittleLate) {
  Topic topic;
  for (const int ms : {5000, 5005, 4990, 4505, 7005}) EXPECT_EQ(topic.add(ms), Times{ms});
  EXPECT_EQ(topic.leaps.wrong(), 0);
}

TEST(StampLeaps, OneWrongStampIsLeftOut) {
  Topic topic;
  topic.add(5000);
  EXPECT_EQ(topic.add(3'600'000), Times{});
  EXPECT_EQ(topic.add(5005), Times{5005});
  EXPECT_EQ(topic.add(1), Times{});
  EXPECT_EQ(topic.add(5010), Times{5010});
  EXPECT_EQ(topic.add(1), Times{});
  EXPECT_EQ(topic.add(3'600'000), Times{});  // another one, which agrees with none
  EXPECT_EQ(topic.add(5015), Times{5015});
  EXPECT_FALSE(topic.jumped);
  EXPECT_EQ(topic.leaps.wrong(), 4);
}

TEST(StampLeaps, TwoThatAgreeAreAJump) {
  Topic topic;
  topic.add(9000);
  EXPECT_EQ(topic.add(8499), Times{});
  EXPECT_EQ(topic.add(8490), (Times{8499, 8490}));
  EXPECT_TRUE(topic.jumped);
}

TEST(StampLeaps, APauseIsNoWrongStamp) {
  Topic topic;
  topic.add(1000);
  EXPECT_EQ(topic.add(9000), Times{});
  EXPECT_EQ(topic.add(9050), (Times{9000, 9050}));
  EXPECT_FALSE(topic.jumped);
  EXPECT_EQ(topic.add(9100), Times{9100});
  topic.add(20'000);
  ASSERT_TRUE(topic.leaps.finish());
  EXPECT_FALSE(topic.leaps.finish());
  topic.add(1);
  EXPECT_FALSE(topic.leaps.finish());
}

}  // namespace
}  // namespace chasles
