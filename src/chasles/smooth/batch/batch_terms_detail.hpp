#pragma once

#include <chasles/smooth/batch/batch_graph_detail.hpp>
#include <chasles/smooth/batch/batch_terms.hpp>

namespace chasles::smooth_detail {

/// The graph's terms and states, for users of the library. `cost`: at these states.
BatchTerms terms_of(const InertialBatchInput& input, const BatchSettings& settings,
                    const BatchGraph& graph, double cost);

}  // namespace chasles::smooth_detail
