#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// A line of a floor plan seen from above. A closed one ends where it begins.
struct PlanLine {
  enum class Kind { kWall, kFurniture };
  Kind kind = Kind::kWall;
  std::vector<Eigen::Vector2d> points;  ///< x and y in the world of the true trajectory [m]
};

/// A floor plan: what a trajectory is drawn over, nothing that is estimated from. Empty: unknown.
using Plan = std::vector<PlanLine>;

/// Reads plan.csv (docs/formats.md). Throws InputError with file, line and column: for a kind that
/// is not known, for a line of fewer than two points, for the points of a line that do not follow
/// each other, and as CsvReader does.
Plan read_plan(const std::filesystem::path& file);

/// The plan of a folder: that of its plan.csv, or none where there is no such file.
Plan read_plan_of(const std::filesystem::path& folder);

/// Writes the folder's plan.csv, or removes it where the plan is empty. Throws UsageError if that
/// is not possible.
void write_plan_of(const Plan& plan, const std::filesystem::path& folder);

}  // namespace chasles
