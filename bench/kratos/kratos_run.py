"""Runs one case in Kratos and writes what compare.py reads. Started by compare.py in the Python that has Kratos.

    python kratos_run.py ProjectParameters.json RESULT.json FRAMES

FRAMES points of time, evenly spaced, get the positions of all material points, in the order of Kratos. The seconds are
the processor's, of the steps alone: import, reading, set-up and the taking of positions are not in them.
"""

import json
import sys
import time

import KratosMultiphysics as kratos
import KratosMultiphysics.MPMApplication as mpm
from KratosMultiphysics.MPMApplication.mpm_analysis import MpmAnalysis


def read(part, variable):
    """A vector of every material point, without the third component."""
    info = part.ProcessInfo
    return [list(e.CalculateOnIntegrationPoints(variable, info)[0])[:2] for e in part.Elements]


class Analysis(MpmAnalysis):
    """Kratos's own loop with a stop-watch around a step."""

    def RunSolutionLoop(self):
        frames = int(sys.argv[3])
        solver = self._GetSolver()
        part = solver.GetComputingModelPart()
        steps = round(self.end_time / solver.settings["time_stepping"]["time_step"].GetDouble())
        result = {"points": part.NumberOfElements(), "start": read(part, mpm.MP_COORD), "frames": []}
        seconds, iterations, failed, dofs = [], [], 0, 0
        for step in range(1, steps + 1):
            start = time.process_time()
            self.time = solver.AdvanceInTime(self.time)
            self.InitializeSolutionStep()
            solver.Predict()
            converged = solver.SolveSolutionStep()
            dofs = max(dofs, solver._GetBuilderAndSolver().GetEquationSystemSize())
            self.FinalizeSolutionStep()
            seconds.append(time.process_time() - start)
            iterations.append(part.ProcessInfo[kratos.NL_ITERATION_NUMBER])
            failed += not converged
            if step * frames // steps > (step - 1) * frames // steps:
                result["frames"].append({"time": self.time, "position": read(part, mpm.MP_COORD)})
        result.update(dofs=dofs, steps=steps, not_converged=failed, iterations=iterations, seconds=seconds,
                      lost=result["points"] - part.NumberOfElements())
        with open(sys.argv[2], "w") as file:
            json.dump(result, file)


if __name__ == "__main__":
    with open(sys.argv[1]) as file:
        Analysis(kratos.Model(), kratos.Parameters(file.read())).Run()
