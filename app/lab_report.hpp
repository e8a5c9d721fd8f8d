#pragma once

#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/lab/monte_carlo.hpp>

namespace chasles::app {

/// The figures of a filter by name (docs/command-line.md): those of docs/evaluation.md, with runs
/// and band. What is not finite is null.
nlohmann::ordered_json figures_json(const FilterVariant& filter, const FilterSummary& summary);

/// How a table is printed.
enum class TableStyle { kText, kMarkdown };
/// Kleinert and Stilla's tables I and II, average NEES and average errors, each with its title and
/// what else belongs there. Of one run, whose processor time is known: `milliseconds` a frame, one
/// a filter. Of several runs (`milliseconds` is empty): also medians, bands and how many diverged.
std::string tables(std::span<const FilterSummary> summaries, std::span<const double> milliseconds,
                   TableStyle style);

/// curves.csv: the means second by second, and 95 % bands of the NEES for the runs that count.
std::string curves_csv(std::span<const FilterSummary> summaries);

/// A number as JSON: null where it is not finite.
nlohmann::ordered_json number_json(double value);

}  // namespace chasles::app
