#!/usr/bin/env bash
# pyceres 2.6 (Ceres Solver's own trust-region minimiser)
#
# Behaviour: where a step lowers the cost by less than function_tolerance of it, Ceres ends with CONVERGENCE, and
# discards that step, although it has computed it and the cost is lower there. A loose tolerance may so return the
# start itself, as converged.
#
# A good engineer would guess: the tolerance says after which step the search ends, so the best point that was
# evaluated is returned.
#
# So: where a search has stages with loose tolerances, set function_tolerance to 0 and end it by an iteration callback
# (SOLVER_TERMINATE_SUCCESSFULLY), which is called after the step was taken. A batch of Chasles has three such stages.
. "$(dirname "$0")/lib.sh"
python_with pyceres==2.6 numpy==2.2.6
"$python" - << 'PY'
import numpy as np, pyceres

class Residual(pyceres.CostFunction):  # (x - 1, 1): cost 1 at 0, 0.5 at the minimum, which is one step away
    def __init__(self):
        super().__init__()
        self.set_num_residuals(2)
        self.set_parameter_block_sizes([1])

    def Evaluate(self, parameters, residuals, jacobians):
        residuals[0], residuals[1] = parameters[0][0] - 1, 1
        if jacobians is not None and jacobians[0] is not None:
            jacobians[0][0], jacobians[0][1] = 1, 0
        return True

def solved(tolerance):
    x, problem = np.zeros(1), pyceres.Problem()
    problem.add_residual_block(Residual(), None, [x])
    options, summary = pyceres.SolverOptions(), pyceres.SolverSummary()
    options.function_tolerance = tolerance
    pyceres.solve(options, problem, summary)
    print(f"  function_tolerance {tolerance}: x = {x[0]:.4f}, cost {summary.initial_cost:.2f} -> {summary.final_cost:.2f}, "
          f"{summary.termination_type.name}")
    return x[0], summary

loose, strict = solved(0.6), solved(0.4)
assert loose[0] == 0 and loose[1].final_cost == loose[1].initial_cost and loose[1].termination_type.name == "CONVERGENCE"
assert abs(strict[0] - 1) < 1e-3
PY
