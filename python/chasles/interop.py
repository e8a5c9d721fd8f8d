"""Trajectories, runs and problems of batch estimation to and from other packages (docs/interoperation.md).

    from chasles.interop import from_evo, gtsam_graph, log_to_rerun, to_evo

    estimate, truth = to_evo(run), to_evo(run.truth)      # pip install evo
    log_to_rerun(run, recording)                          # pip install rerun-sdk
    graph, values = gtsam_graph(batch_run)                # pip install 'gtsam>=4.3'

A package is imported when its function is called; without it the function raises ImportError.
"""

from ._evo import from_evo, to_evo
from ._gtsam import batch_problem, gtsam_graph
from ._rerun import log_to_rerun
from .alignment import align

__all__ = ["align", "batch_problem", "from_evo", "gtsam_graph", "log_to_rerun", "to_evo"]
