#pragma once

#include <functional>

#include "options.hpp"

namespace chasles::bridge {

/// Runs visual-inertial SLAM on the messages of a DDS domain, and publishes its estimates, until
/// `stop` returns true or nothing comes for the time that the options state. Then it processes
/// what has come, writes the outputs of the options, and returns. An error ends it in the same way,
/// and is thrown then.
///
/// Throws UsageError for options, InputError for a calibration that cannot be used and where the
/// first image of a camera cannot be decoded and there is no estimate yet, Error(kNotInitialised)
/// with the reason where there was no estimate, and Error for DDS.
void run_bridge(const BridgeOptions& options, const std::function<bool()>& stop);

}  // namespace chasles::bridge
