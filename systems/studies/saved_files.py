"""Save and load: systems, rigs, schedules and inputs of studies as project files, results and studies as archives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ropeway.components.argument_checks import checked
from ropeway.components.errors import UnknownNameError
from ropeway.systems.dynamics.simulation import simulate
from ropeway.systems.exchange.project_file import load_file, save_file
from ropeway.systems.exchange.study_inputs import StudyInputs
from ropeway.systems.statics.equilibrium_solver import equilibrium
from ropeway.systems.studies.control.optimise_schedule import optimise_schedule
from ropeway.systems.studies.control.receding_horizon import RecedingHorizon
from ropeway.systems.studies.control.scheduling.limits import ScheduleLimits
from ropeway.systems.studies.control.scheduling.plan_data import Gap, PlanHistory, Round
from ropeway.systems.studies.control.scheduling.robustness import Disturbance
from ropeway.systems.studies.control.scheduling.schedule_plan import SchedulePlan
from ropeway.systems.studies.control.tune_response import TunedResponse
from ropeway.systems.studies.load_cases.load_case import LoadCase
from ropeway.systems.studies.load_cases.study import LoadCases, load_cases
from ropeway.systems.studies.skyline.inhaul.study import Inhaul, inhaul
from ropeway.systems.studies.skyline.load_path import load_path
from ropeway.systems.studies.skyline.payload.study import PayloadStudy, payload
from ropeway.systems.studies.skyline.pretension import SetUp, set_up
from ropeway.systems.studies.skyline.support_layout import Candidate, SupportPlan, optimise_supports

_CLASSES: Mapping[str, type] = {
    cls.__name__: cls
    for cls in (
        Candidate, Disturbance, Gap, Inhaul, LoadCase, LoadCases, PayloadStudy, RecedingHorizon, PlanHistory, Round,
        ScheduleLimits, SchedulePlan, SetUp, SupportPlan, TunedResponse,
    )
}  # fmt: skip

STUDIES: Mapping[str, Callable[..., Any]] = {
    study.__name__: study
    for study in (
        equilibrium,
        inhaul,
        load_cases,
        load_path,
        optimise_schedule,
        optimise_supports,
        payload,
        set_up,
        simulate,
    )
}
"""Studies that `run_study` knows, by the name of their function."""


@checked
def save(value: Any, path: str | Path) -> Path:
    """Save a system, rig, schedule, result or study.

    A system, a rig, a schedule and inputs of a study are saved as a readable project file; a result and a finished
    study as an archive.

    Parameters
    ----------
    value : System, SkylineRig, Schedule, StudyInputs, Result, Equilibrium, PayloadStudy, Inhaul, SchedulePlan, ...
        Components of your own are named in the file as module:class.
    path : str or Path
        A project file is JSON (`docs/projects.md`), an archive a zip file with the tables as Parquet, which needs the
        extra `parquet`.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        The value, or a part of it, cannot be saved.
    WriteError
        The file could not be written.

    Examples
    --------
    >>> import tempfile
    >>> path = rw.save(rw.Schedule([0.0, 10.0], [0.5, 1.0]), f"{tempfile.mkdtemp()}/start.json")
    >>> rw.load(path).at(5.0)
    0.75
    """
    return save_file(value, path, _CLASSES)


@checked
def load(path: str | Path, *, components: Sequence[type] = ()) -> Any:
    """What `save` has written, or a project file written by hand.

    Parameters
    ----------
    path : str or Path
        The file.
    components : sequence of type, optional
        Classes of your own that the file names. A file never makes Python import anything.

    Returns
    -------
    System, SkylineRig, Schedule, StudyInputs, Result, ...

    Raises
    ------
    InputError
        With file, line and field: what is no project file, one of a newer version, a value that is not valid, or a
        component of your own that is not supplied.

    Examples
    --------
    >>> rw.save(rw.Schedule([0.0, 10.0], [0.5, 1.0]), "start.json").name
    'start.json'
    >>> rw.load("start.json").at(5.0)
    0.75
    """
    return load_file(path, _CLASSES, components)


@checked
def run_study(inputs: StudyInputs) -> Any:
    """Run a study with its inputs.

    Parameters
    ----------
    inputs : StudyInputs
        The study, its subject and its arguments.

    Returns
    -------
    PayloadStudy, Inhaul, Result, DataFrame, ...
        What the study's function returns.

    Raises
    ------
    UnknownNameError
        There is no such study.

    Examples
    --------
    >>> rw.save(rw.StudyInputs("payload", rig, {"stations": [150.0]}), "question.json").name
    'question.json'
    >>> rw.run_study(rw.load("question.json")).frame["station"].tolist()
    [150.0]
    """
    if inputs.study not in STUDIES:
        raise UnknownNameError(f"No study {inputs.study!r}", f"Studies are {', '.join(STUDIES)}")
    return STUDIES[inputs.study](inputs.of, **inputs.arguments)
