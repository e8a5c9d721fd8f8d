#pragma once

#include <string>
#include <vector>

#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// Spreads samples that came in batches. A serial line, a USB converter or a FIFO delivers several
/// samples at once, and a driver that stamps at arrival gives all of them one time. The samples of
/// a batch, which are neighbours with one time and different values, are spread evenly over the
/// time since the batch before; the last one keeps its time. After a gap, and in the first batch,
/// the median distance of samples counts instead. A remark has the numbers; `what` names the rows.
///
/// Copies of a sample (equal values, all of a batch equally often) stay copies. Nothing is changed
/// where under a tenth of the samples are in batches, of batches of more than 50, and where they
/// are more than 0.2 s apart: such stamps are rounded or were never set.
void spread_batches(std::vector<ImuSample>& imu, const std::string& what,
                    std::vector<std::string>& remarks);

}  // namespace chasles
