#pragma once

#include <string>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// The reliability of an estimate.
enum class Health {
  kOk,
  kDegraded,  ///< see Degradation
  kLost,  ///< not finite, or an invalid covariance: this and all later estimates are meaningless
};
std::string name(Health health);

/// Why an estimate is degraded.
enum class Degradation {
  kNone,
  kFewObservations,  ///< in the last second fewer than 3 observations were used
  kRejections,       ///< in the last second more were rejected than used
  kInnovations,      ///< in the last second the innovations contradict their covariance
  kUnknownSpeed,     ///< many observations, and the speed is as uncertain as unknown
  kLens,             ///< the tracks of the recording contradict the stated lens
};

std::string name(Degradation degradation);  ///< "few_observations"; of kNone "none"

/// Above this NIS per degree of freedom, over a second, innovations contradict their covariance:
/// the errors are more than 1.4 times as large as the covariance states, or the noise is stated
/// wrongly. The recordings of docs/results.md and docs/pixels.md have 0.2 to 0.9 over a whole run,
/// and flights with a real IMU and rendered images up to 1.2 (docs/inertial-results.md).
inline constexpr double kMostNisPerDof = 2;

/// The innovations of the last second.
class RecentInnovations {
 public:
  /// Adds a frame. Whether the NIS of the last second is above kMostNisPerDof and above its 99.9 %
  /// bound. Times rise.
  bool contradict(Time time, double nis, int dof);

 private:
  struct Frame {
    Time time{};
    double nis = 0;
    int dof = 0;
  };
  std::vector<Frame> last_second_;
};

/// What speaks against an estimate: the observations of the last second, used and rejected, and
/// their innovations.
class RecentUse {
 public:
  /// Adds this frame. Times rise. `nis`, `dof`: of a filter's innovations, or of a window's
  /// residuals.
  Degradation assess(Time time, int used, int rejected, double nis, int dof);

 private:
  struct Use {
    Time time{};
    int used = 0, rejected = 0;
  };
  std::vector<Use> last_second_;
  RecentInnovations innovations_;
};

}  // namespace chasles
