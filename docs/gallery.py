"""What the site shows of running code: a gallery of all examples, pictures of pages, figures of the theory.

Each script runs in a process of its own, as many at a time as there are cores, and writes to `docs/made/`. A script
that has not changed since is not run again.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import ropeway

DOCS = Path(__file__).resolve().parent
MADE = DOCS / "made"
EXAMPLES = DOCS.parent / "examples"
PAGES = ("start/forest", "start/line", "start/control", "uncertainty", "emergency_stop", "modes")
"""Pages with pictures that their own scripts make."""

TITLES = {
    "one_span": "One span with a turn",
    "idlers": "One rope over idlers",
    "standing_skyline": "Standing skyline",
    "running_skyline": "Running skyline",
    "saddle": "Over a saddle",
    "guyed_spar": "Guyed spar",
    "corridor_map": "From the map to the map",
    "monocable": "Mono-cable line",
    "load_cases": "Load cases",
    "turk_responses": "Responses of control sheaves",
    "optimise_schedule": "Optimal schedules",
    "sweep": "Ten thousand variants",
    "fit_tension_log": "Fit to a tension log",
    "own_component": "Components of your own",
    "fmu_export": "A line as an FMU",
    "fmu_cosimulation": "Co-simulation",
    "fmu_foreign": "An FMU of another tool",
    "harvey_payload": "Harvey's payloads",
    "lyons_stretch": "Lyons' cable stretch",
    "turk_solvers": "Turk's solvers",
}
"""Titles of known examples, in the order of the gallery."""

KEPT = {
    "optimise_schedule": "schedules.png",
    "turk_responses": "turk_responses.png",
    "fmu_export": "fmu_export.png",
    "fmu_cosimulation": "fmu_cosimulation.png",
}
"""Examples that take too long for the site, and run in the tests: pictures that they made, in docs/pictures."""
DOWNLOADS = ("fmu_foreign",)
"""Examples that need a network, which the site does not."""
FEWER = {"sweep": ("1000",)}
"""Arguments that make an example's work less."""
SMALLER: Mapping[str, Mapping[str, float]] = {"saddle": {"SPACING": 0.1}}
"""Constants that make an example's work less."""


@dataclass(frozen=True)
class Script:
    """A script with the folder for its pictures; `source` is its text, `code` what a new process runs."""

    source: str
    code: str
    folder: Path

    @property
    def mark(self) -> str:
        """Identifies what the folder was made from."""
        return sha256(f"{ropeway.__version__}\n{self.code}\n{self.source}".encode()).hexdigest()

    def run(self) -> None:
        """Runs it if it has changed. Raises RuntimeError with its last lines."""
        mark = self.folder / "mark"
        if mark.is_file() and mark.read_text() == self.mark:
            return
        self.folder.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-c", self.code, str(self.folder)]
        done = subprocess.run(
            command, cwd=self.folder, env={**os.environ, "MPLBACKEND": "Agg"}, capture_output=True, text=True
        )
        if done.returncode:
            raise RuntimeError(f"{self.folder.name}: {done.stderr[-2000:]}")
        (self.folder / "printed.txt").write_text(done.stdout.replace(str(self.folder), "."))
        mark.write_text(self.mark)


def example(name: str) -> Script:
    """An example."""
    path = EXAMPLES / f"{name}.py"
    changes = "".join(f"example.{key} = {value!r}; " for key, value in SMALLER.get(name, {}).items())
    if changes:
        code = f"import sys; from pathlib import Path; import ropeway.examples.{name} as example; {changes}"
        code += "example.main(Path(sys.argv[1]))"
    else:
        arguments = [str(path), *FEWER.get(name, ())]
        code = f"import runpy, sys; sys.argv[:] = [{arguments[0]!r}, sys.argv[1], *{arguments[1:]!r}]; "
        code += f"runpy.run_path({str(path)!r}, run_name='__main__')"
    return Script(path.read_text(encoding="utf-8"), code, MADE / "gallery" / name)


def of_page(name: str) -> Script:
    """The scripts of a page, one after the other."""
    text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    source = "\n".join(re.findall(r"```python\n(.*?)```", text, re.DOTALL))
    return Script(source, source, MADE / name)


def figures() -> Script:
    """The figures of the theory."""
    path = DOCS / "theory" / "figures.py"
    code = f"import runpy; runpy.run_path({str(path)!r}, run_name='__main__')"
    return Script(path.read_text(encoding="utf-8"), code, MADE / "theory")


def make() -> None:
    """Runs all scripts and writes the pages of the gallery. Raises RuntimeError for a script that fails."""
    names = [path.stem for path in EXAMPLES.glob("[!_]*.py")]
    names.sort(key=lambda name: (list(TITLES).index(name) if name in TITLES else len(TITLES), name))
    scripts = [example(name) for name in names if name not in (*KEPT, *DOWNLOADS)]
    scripts += [figures(), *map(of_page, PAGES)]
    tasks: list[Callable[[], None]] = [script.run for script in reversed(scripts)]  # the long ones first
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for task in [pool.submit(task) for task in tasks]:
            task.result()
    gallery = MADE / "gallery"
    gallery.mkdir(parents=True, exist_ok=True)
    for name in names:
        _write(gallery / f"{name}.md", page(name))
    _write(gallery / "index.md", index(names))


def _write(path: Path, text: str) -> None:
    """Leaves an equal file alone, which Sphinx then does not read again."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def words(name: str) -> tuple[str, str]:
    """The first sentence of an example's docstring, and the rest."""
    text = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8").split('"""')[1]
    first, _, rest = text.partition("\n\n")
    return " ".join(first.split()), rest.strip("\n")


def title(name: str) -> str:
    """Title of an example."""
    return TITLES.get(name, name.replace("_", " ").capitalize())


def pictures(name: str) -> list[str]:
    """Pictures of an example, from the gallery."""
    if name in KEPT:
        return [f"../../pictures/{KEPT[name]}"]
    return [f"{name}/{path.name}" for path in sorted((MADE / "gallery" / name).glob("*.png"))]


def page(name: str) -> str:
    """The page of an example."""
    first, rest = words(name)
    parts = [f"# {title(name)}", first, rest]
    parts += [f"![{title(name)}]({picture})" for picture in pictures(name)]
    printed = MADE / "gallery" / name / "printed.txt"
    if printed.is_file() and (text := printed.read_text().strip("\n")):
        parts.append(f":::{{dropdown}} Printed\n```text\n{text}\n```\n:::")
    less = {**SMALLER.get(name, {}), **({"variants": FEWER[name][0]} if name in FEWER else {})}
    if name in KEPT:
        parts.append("This example takes a minute or more; its picture was made before.")
    if less:
        values = ", ".join(f"{key} = {value}" for key, value in less.items())
        parts.append(f"This page was made with {values}.")
    parts.append(f"```{{literalinclude}} ../../../examples/{name}.py\n:language: python\n```")
    return "\n\n".join(part for part in parts if part) + "\n"


def index(names: list[str]) -> str:
    """The page of all examples."""
    cards = []
    for name in names:
        picture = pictures(name)
        top = f":img-top: {picture[0]}\n" if picture else ""
        cards.append(
            f":::{{grid-item-card}} {title(name)}\n:link: {name}\n:link-type: doc\n{top}\n{words(name)[0]}\n:::"
        )
    toctree = "```{toctree}\n:hidden:\n\n" + "\n".join(names) + "\n```"
    text = "Every script of the folder `examples/`, with the pictures that it makes. Most take a few seconds."
    return "\n\n".join(["# Gallery", text, "::::{grid} 1 2 2 3\n:gutter: 3\n", *cards, "::::", toctree]) + "\n"
