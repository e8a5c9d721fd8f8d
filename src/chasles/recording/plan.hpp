#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A line of a floor plan in top view. The last point of a closed line equals its first.
struct PlanLine {
  enum class Kind { kWall, kFurniture };
  Kind kind = Kind::kWall;
  std::vector<Eigen::Vector2d> points;  ///< x and y [m], in the truth's world, else the run's
};

/// A floor plan, drawn below a trajectory and not used for estimation. Empty: unknown.
using Plan = std::vector<PlanLine>;

/// Reads plan.csv (docs/formats.md). Throws InputError with file, line and column for an unknown
/// kind, a line of fewer than two points, points of a line that are not consecutive, and as
/// CsvReader does.
Plan read_plan(const std::filesystem::path& file);

/// The plan in a folder's plan.csv; empty if there is no such file.
Plan read_plan_of(const std::filesystem::path& folder);

/// Writes the folder's plan.csv, or removes it if the plan is empty. Throws UsageError if that is
/// not possible.
void write_plan_of(const Plan& plan, const std::filesystem::path& folder);

}  // namespace chasles
