#pragma once

#include <cstdint>
#include <string>

#include <chasles/base/settings.hpp>

namespace chasles {

// The only list of settings: type, name, default, least, most, unit, meaning. It defines the
// struct, the command line, the help and the checks. Only numbers have a least and a most.
// clang-format off
#define CHASLES_LOOPS_FIELDS(FIELD)                                                               \
  FIELD(std::string, name, "loops", 0, 0, "", "name of the study")                                \
  FIELD(std::uint64_t, seed, 1, 0, 0, "", "chooses the landmarks and, with the run, all noise")   \
  FIELD(int, steps, 500, 1, 100000, "", "of the odometry; one takes a second")                    \
  FIELD(int, loops, 8, 1, 25000, "", "travelled in these steps")                                     \
  FIELD(double, radius, 80, 0.1, 1e5, "m", "of a loop")                                           \
  FIELD(double, undulation, 1, 0, 1e3, "m", "up and down, twice a loop")                          \
  FIELD(int, landmarks, 300, 0, 2000, "", "around the loop")                                      \
  FIELD(double, range, 20, 0.1, 1e5, "m", "a landmark is observed within this distance")                  \
  FIELD(double, field_of_view, 2.0943951023931953, 0.01, 6.3, "rad", "full angle about the forward axis") \
  FIELD(bool, retire, false, 0, 0, "", "landmarks out of view leave the state, and return with their exact covariance") \
  FIELD(double, sigma, 0.01, 0, 1, "", "noise of every component of odometry and points, relative to it")
// clang-format on

/// The simulation of Zhang, Wu, Song, Huang & Dissanayake, "Convergence and consistency analysis
/// for a 3-D invariant-EKF SLAM" (RA-L 2017, §VI), as far as it is described: a robot that moves in
/// loops, measures its own motion by odometry and observes points in its own axes. Every
/// combination that `validate` accepts can be simulated.
struct LoopsSettings {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) type field = value;
  CHASLES_LOOPS_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
};

/// Calls visit(name, value, unit, doc, limits) for every setting, in the order of the list; `value`
/// is a reference to an int, double, std::uint64_t or std::string, const where `settings` is.
template <SettingsOf<LoopsSettings> S, typename Visitor>
void for_each_setting(S& settings, Visitor&& visit) {
#define CHASLES_FIELD(type, field, value, least, most, unit, doc) \
  visit(#field, settings.field, unit, doc, limits::of<type>(least, most));
  CHASLES_LOOPS_FIELDS(CHASLES_FIELD)
#undef CHASLES_FIELD
}
#undef CHASLES_LOOPS_FIELDS

/// Throws UsageError with the field, its value and the expected one.
void validate(const LoopsSettings& settings);

}  // namespace chasles
