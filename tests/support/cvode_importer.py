"""An importer for Model Exchange on CVODE of SUNDIALS 7 (scikit-sundae), as the C program `fmusim` calls it.

BDF without a limit on its steps, its root finding for state events, and a restart only if the FMU reports changed
states: so it tries states far beyond an event, and meets jumps of the rates without one.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from sksundae.cvode import CVODE

from support.fmus import Opened


@dataclass
class Importer:
    """Runs an opened FMU; `failures`: of calls in the solver's functions; `calls`, `events`: their numbers."""

    one: Opened
    tolerance: float
    failures: list[Exception] = field(default_factory=list)
    calls: int = 0
    events: int = 0

    def run(self, until: float) -> None:
        """From the initialisation to a time. Raises RuntimeError if CVODE fails."""
        fmu = self.one.fmu
        coming, _ = self._update()
        fmu.enterContinuousTimeMode()
        time, solver = 0.0, self._solver(0.0)
        while time < until:
            stop = min(until, coming)
            found = solver.step(stop, tstop=stop)
            if not found.success:
                raise RuntimeError(found.message)
            time = float(found.t)
            self._put(time, found.y)
            fmu.completedIntegratorStep()
            if time < stop or time >= coming:  # it stops early at a root only
                fmu.enterEventMode()
                coming, changed = self._update()
                fmu.enterContinuousTimeMode()
                solver = self._solver(time) if changed else solver
                self.events += 1

    def _update(self) -> tuple[float, bool]:
        """Time of the next time event, and whether states changed."""
        fmu = self.one.fmu
        update = fmu.updateDiscreteStates if self.one.three else fmu.newDiscreteStates
        again, changed, coming = True, False, np.inf
        while again:
            again, _, _, values, defined, at = update()
            changed, coming = changed or bool(values), at if defined else np.inf
        return coming, changed

    def _solver(self, time: float) -> CVODE:
        description = self.one.description
        states, nominals = (np.zeros(description.numberOfContinuousStates) for _ in range(2))
        self._read(self.one.fmu.getContinuousStates, states)
        self._read(self.one.fmu.getNominalsOfContinuousStates, nominals)
        count = description.numberOfEventIndicators
        how: dict[str, Any] = {"rtol": self.tolerance, "atol": self.tolerance * nominals, "max_num_steps": 100_000}

        def indicators(time: float, states: np.ndarray, values: np.ndarray) -> None:  # it gets attributes
            self._evaluate(time, states, "getEventIndicators", values)

        solver = CVODE(self._rates, eventsfn=indicators, num_events=count, **how)
        solver.init_step(time, states)
        return solver

    def _rates(self, time: float, states: np.ndarray, rates: np.ndarray) -> None:
        three = self.one.three
        self._evaluate(time, states, "getContinuousStateDerivatives" if three else "getDerivatives", rates)

    def _evaluate(self, time: float, states: np.ndarray, name: str, values: np.ndarray) -> None:
        self.calls += 1
        try:
            self._put(time, states)
            self._read(getattr(self.one.fmu, name), values)
        except Exception as error:  # noqa: BLE001 - in a callback of C it would be lost
            self.failures.append(error)

    def _put(self, time: float, states: np.ndarray) -> None:
        self.one.fmu.setTime(time)
        given = np.array(states, dtype=float)  # those of the solver are read-only
        self.one.fmu.setContinuousStates(np.ctypeslib.as_ctypes(given), len(given))

    def _read(self, call: Any, values: np.ndarray) -> None:
        read = np.zeros(len(values))
        call(np.ctypeslib.as_ctypes(read), len(read))
        values[:] = read
