"""Helpers for tests of FMUs: lines to export, and slaves that are opened and closed."""

import re
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pandas as pd
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

import ropeway as rw
from ropeway.components.component import Component
from support.drives import hydraulic_drive

ROPE = rw.Rope(mass_per_length=3.48, axial_stiffness=34.8e6, breaking_load=576.6e3)
SUPPORTS = Path(__file__).resolve().parents[2] / "examples" / "line.csv"


def example_line(**more: Any) -> rw.System:
    """The example line."""
    return rw.monocable(
        ROPE, supports=SUPPORTS, tension=45e3, speed=1.0, load_mass=300.0, load_spacing=50.0, name="line", **more
    )


def first_supports() -> pd.DataFrame:
    """The first seven supports of the example line, and a drum: one control sheave."""
    table = pd.read_csv(SUPPORTS)
    first = table.iloc[:8].copy()
    first.loc[first.index[-1], "kind"] = "drum"
    return first


def short_line(**more: Any) -> rw.System:
    """The line of the first supports."""
    return rw.monocable(
        ROPE,
        supports=first_supports(),
        tension=45e3,
        load_mass=(300.0, 200.0),
        load_spacing=40.0,
        name="short line",
        **{"speed": 1.0, **more},
    )


def one_span() -> rw.System:
    """A span between anchors with one load."""
    s = rw.System("one span")
    (span,) = s.string(ROPE, rw.Anchor("a", at=(0.0, 0.0)), rw.Anchor("b", at=(400.0, -60.0)), length=408.0)
    s.hang(rw.Load("turn", mass=6000.0), span, at=190.0)
    return s


def skyline() -> rw.System:
    """A standing skyline whose mainline drum can haul the carriage."""
    rig = rw.standing_skyline(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 0.0)),
        tailspar=rw.TailSpar("tail", at=(200.0, -20.0)),
        skyline=ROPE,
        length=207.0,
        carriage=rw.Carriage("carriage", mass=450.0),
        mainline=rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3),
    )
    return rig.system(0, 110.0, payload=2500.0)


MAIN = rw.Rope(mass_per_length=0.73, axial_stiffness=8e6, breaking_load=120e3)


def corridor(make: Any = rw.standing_skyline, **how: Any) -> rw.SkylineRig:
    """A skyline over two supports with shoes."""
    supports = [
        rw.IntermediateSupport("s1", at=(160.0, 40.0), radius=3.0),
        rw.IntermediateSupport("s2", at=(330.0, -20.0), radius=3.0),
    ]
    parts = {"supports": supports, "mainline": MAIN, "haulback": MAIN, "haulback_tension": 6e3, "tension": 70e3}
    rig: rw.SkylineRig = make(
        None,
        headspar=rw.HeadSpar("head", at=(0.0, 100.0)),
        tailspar=rw.TailSpar("tail", at=(480.0, -70.0)),
        skyline=ROPE,
        carriage=rw.Carriage("carriage", mass=450.0),
        **{**parts, **how},
    )
    return rig


def valley(speed: float, at: float, friction: float = 0.0) -> rw.System:
    """A hold-down sheave in a valley: a load is pushed back there from both sides."""
    s = rw.System("valley")
    h, m = rw.Sheave("h", at=(100.0, 0.0), hold_down=True, friction=friction), rw.Sheave("m", at=(200.0, 15.0))
    ends = rw.Drum("d0", at=(0.0, 20.0), speed=speed), rw.Drum("d1", at=(300.0, 0.0), tension=60e3)
    spans = s.string(ROPE, ends[0], h, m, ends[1], tension=60e3)
    s.hang(rw.Load("l1", mass=400.0), spans, at=at)
    return s


HYDRAULIC = hydraulic_drive(displacement=1e-4, relief_pressure=350e5, pump_flow=0.02, inertia=500.0)


def open_line() -> rw.System:
    """The short line with a drive whose pressure and flow are open inputs."""
    return short_line(drive=replace(HYDRAULIC, relief_pressure=None, pump_flow=None, brake_force=1e5))


def fed_line(unit: Component, prefix: str = "") -> rw.System:
    """The short line with a drive that a power unit feeds; `prefix` of the unit's variables."""
    s = open_line()
    unit, c1 = s.add(unit), s.components["c1"]
    s.connect(unit.output(f"{prefix}flow"), c1.input("pump_flow"))
    s.connect(unit.output(f"{prefix}pressure"), c1.input("relief_pressure"))
    s.connect(c1.output("hydraulic_power"), unit.input(f"{prefix}load_power"))
    return s


WEAK_UNIT = rw.DieselHydraulicUnit(
    "unit", rated_power=20e3, rated_speed=200.0, inertia=1.0, displacement=25e-6, relief_pressure=350e5
)
RESPONSE = rw.ThresholdResponse(low=44e3, high=46e3, increment=0.02, period=1.0, delay=1.4)


def rewritten(source: Path, path: Path, change: Callable[[str], str]) -> Path:
    """The FMU with another description."""
    with zipfile.ZipFile(source) as given, zipfile.ZipFile(path, "w") as target:
        for item in given.namelist():
            data = given.read(item)
            target.writestr(item, change(data.decode()).encode() if item == "modelDescription.xml" else data)
    return path


def with_units(mass: Path, path: Path, units: dict[str, str], definitions: str = "") -> Path:
    """The FMU of a mass with units at some of its variables."""

    def change(text: str) -> str:
        for name, unit in units.items():
            text = re.sub(rf'(name="{re.escape(name)}" [^>]*>\s*<Real )(?:unit="[^"]*")?', rf'\1unit="{unit}" ', text)
        defined = f"<UnitDefinitions>{definitions}</UnitDefinitions><ModelVariables>"
        return text.replace("<ModelVariables>", defined) if definitions else text

    return rewritten(mass, path, change)


class Opened:
    """An instance of an FMU with its variables by name, and what it has logged."""

    def __init__(self, path: Path, folder: Path, *, kind: str = "CoSimulation", start: float = 0.0) -> None:
        self.description = fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.references.setdefault("time", 0)
        self.log: list[str] = []
        self.kind, self.three = kind, self.description.fmiVersion.startswith("3")
        section = self.description.coSimulation if kind == "CoSimulation" else self.description.modelExchange
        if not (folder / "modelDescription.xml").exists():
            fmpy.extract(str(path), unzipdir=str(folder))
        classes = {
            ("CoSimulation", False): FMU2Slave,
            ("ModelExchange", False): FMU2Model,
            ("CoSimulation", True): FMU3Slave,
            ("ModelExchange", True): FMU3Model,
        }
        self.fmu = classes[kind, self.three](
            guid=self.description.guid or self.description.instantiationToken,
            unzipDirectory=str(folder),
            modelIdentifier=section.modelIdentifier,
            instanceName="one",
        )
        self._instantiate()
        self.setup(start)

    def _instantiate(self) -> None:
        if self.three:
            self.fmu.instantiate(logMessage=self._log3)
        else:
            from fmpy.fmi2 import (
                calloc,
                fmi2CallbackAllocateMemoryTYPE as Allocate,
                fmi2CallbackFreeMemoryTYPE as Free,
                fmi2CallbackFunctions,
                fmi2CallbackLoggerTYPE as Logger,
                free,
            )

            self._callbacks = fmi2CallbackFunctions()
            self._callbacks.logger = Logger(lambda env, name, status, category, text: self.log.append(text.decode()))
            self._callbacks.allocateMemory = Allocate(calloc)
            self._callbacks.freeMemory = Free(free)
            self.fmu.instantiate(callbacks=self._callbacks)

    def _log3(self, environment: Any, status: int, category: bytes, text: bytes) -> None:
        self.log.append(text.decode())

    def setup(self, start: float = 0.0) -> None:
        """Starts at a time."""
        self._start = start
        if not self.three:
            self.fmu.setupExperiment(startTime=start)

    def initialize(self) -> None:
        """Initialises."""
        if self.three:
            self.fmu.enterInitializationMode(startTime=self._start)
        else:
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def get(self, *names: str) -> list[float]:
        """Values of real variables."""
        references = [self.references[n] for n in names]
        return list(self.fmu.getFloat64(references) if self.three else self.fmu.getReal(references))

    def set(self, **values: float) -> None:
        """Sets real variables; a double underscore stands for the dot."""
        references = [self.references[n.replace("__", ".")] for n in values]
        write = self.fmu.setFloat64 if self.three else self.fmu.setReal
        write(references, list(values.values()))

    def switch(self, name: str, on: bool) -> None:
        """Sets a Boolean variable."""
        self.fmu.setBoolean([self.references[name]], [on])

    def step(self, time: float, size: float) -> None:
        """One step."""
        self.fmu.doStep(currentCommunicationPoint=time, communicationStepSize=size)

    def run(self, start: float, end: float, size: float, names: Sequence[str]) -> np.ndarray:
        """Values after each step, shape (steps, names)."""
        steps = round((end - start) / size)
        rows = []
        for i in range(steps):
            self.step(start + i * size, size)
            rows.append(self.get(*names))
        return np.array(rows)

    def save(self) -> Any:
        """The state."""
        return self.fmu.getFMUState() if self.three else self.fmu.getFMUstate()

    def restore(self, state: Any) -> None:
        """Restores a state."""
        (self.fmu.setFMUState if self.three else self.fmu.setFMUstate)(state)

    def close(self) -> None:
        """Closes it."""
        self.fmu.freeInstance()


Opener = Callable[..., Opened]


@contextmanager
def opening(folder: Path) -> Iterator[Opener]:
    """A function that opens FMUs; all are closed at the end."""
    opened: list[Opened] = []

    def open_fmu(path: Path, **more: Any) -> Opened:
        opened.append(Opened(path, folder / path.stem, **more))
        return opened[-1]

    yield open_fmu
    for one in opened:
        one.close()
