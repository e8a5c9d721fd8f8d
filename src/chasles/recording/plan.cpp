#include <cstdint>
#include <iterator>
#include <string>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/plan.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kPlanColumns = {"line", "kind", "x", "y"};
constexpr const char* kFile = "plan.csv";

const char* name(PlanLine::Kind kind) {
  return kind == PlanLine::Kind::kWall ? "wall" : "furniture";
}

PlanLine::Kind kind_of(const CsvReader& csv) {
  for (const PlanLine::Kind kind : {PlanLine::Kind::kWall, PlanLine::Kind::kFurniture}) {
    if (csv.text(1) == name(kind)) return kind;
  }
  throw InputError(
      fmt::format("{}: found '{:.40}', expected wall or furniture", csv.where(1), csv.text(1)));
}

// A line of one point is detected at its end: `where` is then the row after it.
void check_over(const std::string& where, const Plan& plan) {
  if (plan.empty() || plan.back().points.size() >= 2) return;
  throw InputError(
      fmt::format("{}: line {} ends with one point, expected two or more", where, plan.size() - 1));
}

// The line of the row: the last one, or a new one.
PlanLine& line_of(const CsvReader& csv, Plan& plan) {
  const std::int64_t line = csv.integer(0);
  const auto last = static_cast<std::int64_t>(plan.size()) - 1;
  const bool follows = plan.empty() ? line == 0 : line == last || line == last + 1;
  if (!follows) {
    throw InputError(
        plan.empty()
            ? fmt::format("{}: found {}, expected 0: lines are numbered from 0", csv.where(0), line)
            : fmt::format(
                  "{}: found {}, expected {} or {}: the points of a line follow each other, "
                  "lines are numbered from 0",
                  csv.where(0), line, last, last + 1));
  }
  if (line > last) {
    check_over(csv.where(), plan);
    plan.push_back({.kind = kind_of(csv), .points = {}});
  } else if (kind_of(csv) != plan.back().kind) {
    throw InputError(fmt::format("{}: found '{}', expected '{}' as the rest of line {}",
                                 csv.where(1), csv.text(1), name(plan.back().kind), line));
  }
  return plan.back();
}

}  // namespace

Plan read_plan(const fs::path& file) {
  CsvReader csv(file, kPlanColumns);
  Plan plan;
  while (csv.next()) {
    PlanLine& line = line_of(csv, plan);
    line.points.emplace_back(csv.finite(2), csv.finite(3));
  }
  csv.require_whole();
  check_over(file.string(), plan);
  return plan;
}

Plan read_plan_of(const fs::path& folder) {
  const fs::path file = folder / kFile;
  std::error_code ignored;
  return fs::exists(file, ignored) ? read_plan(file) : Plan{};
}

void write_plan_of(const Plan& plan, const fs::path& folder) {
  if (plan.empty()) return remove_file(folder / kFile);
  fmt::memory_buffer rows;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    for (const Eigen::Vector2d& p : plan[i].points) {
      fmt::format_to(std::back_inserter(rows), "{},{},{},{}\n", i, name(plan[i].kind), p.x(),
                     p.y());
    }
  }
  write_table(folder / kFile, kPlanColumns, {rows.data(), rows.size()});
}

}  // namespace chasles
