#pragma once

#include <string>

#include <chasles/data/run.hpp>

namespace chasles {

/// The ways on the Earth as KML 2.2: the estimate as a line and, with its times, as a track, the
/// truth and dead reckoning as lines. The run's world is placed on the truth's by the best fit
/// (truth_T_world), the truth's on the Earth by the run's georeference. Lines lie on the ground;
/// their coordinates have the altitude. Whatever the run is called, the file is well-formed XML in
/// UTF-8; positions that are not finite are left out. Throws InputError for a run without a
/// georeference or whose truth cannot be compared.
std::string run_kml(const Run& run);

}  // namespace chasles
