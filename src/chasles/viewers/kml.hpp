#pragma once

#include <string>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The trajectories on the Earth as KML 2.2: the estimate as a line and, with its times, as a
/// track; the truth and dead reckoning as lines. The best fit (truth_T_world) aligns the run's
/// world with the truth's; the run's georeference places the truth's world on the Earth. Lines are
/// drawn on the ground; their coordinates include the altitude. The file is well-formed XML in
/// UTF-8 whatever the run's name; positions that are not finite are left out. Throws InputError for
/// a run without a georeference or whose truth cannot be compared.
std::string run_kml(const Run& run);

}  // namespace chasles
