#pragma once

#include <chasles/smooth/batch/batch_problem_detail.hpp>

namespace chasles::smooth_detail {

/// Adds motions and landmarks with their covariances, reference chart, from the problem linearised
/// at the graph's states. The problem's blocks must hold these states,
/// and all its errors must be free (BatchProblem::Considered). `factor`: by which the covariances
/// are multiplied afterwards; it is not for what considered errors add.
void add_estimates(BatchProblem& problem, const InertialBatchInput& input, const BatchGraph& graph,
                   double factor, InertialBatchResult& result, const StopRequest& stop);

}  // namespace chasles::smooth_detail
