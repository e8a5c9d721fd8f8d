#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/observer_list.hpp>

namespace chasles {
namespace {

using Calls = std::vector<std::string>;

// Writes down each call, with its name before it.
class Writer : public RunObserver {
 public:
  Writer(std::string name, Calls& calls) : name_(std::move(name)), calls_(calls) {}

  bool stop() override { return stops; }
  void on_images(const ImageFrame&) override { write("images"); }
  void on_unreadable(const InputError&) override { write("unreadable"); }
  void on_frame(const FeatureFrame&) override { write("frame"); }
  void on_outcomes(const FeatureFrame&, std::span<const PixelOutcome>) override {
    write("outcomes");
  }
  void on_estimate(const Estimate&, const EstimateTiming&) override { write("estimate"); }
  void on_progress(std::size_t frames, Time) override {
    write("progress " + std::to_string(frames));
  }
  void on_smoothing() override { write("smoothing"); }
  void on_smoothed(std::span<const Estimate>, double) override { write("smoothed"); }

  bool stops = false;

 private:
  void write(const std::string& call) { calls_.push_back(name_ + " " + call); }
  std::string name_;
  Calls& calls_;
};

TEST(ObserverList, EachCallReachesAllInTheirOrder) {
  Calls calls;
  Writer a("a", calls), b("b", calls);
  ObserverList list{a, b};
  list.on_images({});
  list.on_unreadable(InputError("torn"));
  list.on_frame({});
  list.on_outcomes({}, {});
  list.on_estimate({}, {});
  list.on_progress(7, Time{});
  list.on_smoothing();
  list.on_smoothed({}, 1);
  Calls expected;
  for (const char* call : {"images", "unreadable", "frame", "outcomes", "estimate", "progress 7",
                           "smoothing", "smoothed"}) {
    for (const char* name : {"a ", "b "}) expected.push_back(std::string(name) + call);
  }
  EXPECT_EQ(calls, expected);
}

TEST(ObserverList, StopsWhereOneStops) {
  Calls calls;
  Writer a("a", calls), b("b", calls);
  ObserverList list{a, b};
  EXPECT_FALSE(list.stop());
  b.stops = true;
  EXPECT_TRUE(list.stop());
  std::swap(a.stops, b.stops);
  EXPECT_TRUE(list.stop());
}

}  // namespace
}  // namespace chasles
