#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/monte_carlo.hpp>

namespace chasles::app {

/// The figures of a filter by name (docs/command-line.md, docs/evaluation.md), with the number of
/// runs and the band. A value that is not finite becomes null.
nlohmann::ordered_json figures_json(const FilterVariant& filter, const FilterSummary& summary);

/// Output format of a table.
enum class TableStyle { kText, kMarkdown };
/// Tables I and II of Kleinert and Stilla: average NEES and average errors, each with its title and
/// further columns. For one run, `milliseconds` has the processor time per frame [ms] of each
/// filter. For several runs `milliseconds` is empty; the tables then also have medians, bands and
/// the number of diverged runs.
std::string tables(std::span<const FilterSummary> summaries, std::span<const double> milliseconds,
                   TableStyle style);

/// Text of curves.csv: means for each second, and 95 % bands of the NEES for the runs that did not
/// diverge.
std::string curves_csv(std::span<const FilterSummary> summaries);

/// A number as JSON; null if it is not finite.
nlohmann::ordered_json number_json(double value);

}  // namespace chasles::app
