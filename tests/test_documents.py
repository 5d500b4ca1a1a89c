"""The documents: their scripts run, their list of names is complete, their language is plain."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path

import pytest

import ropeway as rw
from support.fmus import rewritten
from support.kinds import kinds_fmu

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize(
    "document",
    [
        "README.md",
        "docs/skylines.md",
        "docs/load_cases.md",
        "docs/weather.md",
        "docs/inertia.md",
        "docs/fitting.md",
        "docs/components.md",
        "docs/projects.md",
        "docs/catalogue.md",
        "docs/reports.md",
        "docs/gis.md",
        "docs/index.md",
        "docs/uncertainty.md",
        "docs/errors.md",
        "docs/modes.md",
        "docs/emergency_stop.md",
        "docs/faq.md",
        "docs/theory/assumptions.md",
        pytest.param("docs/schedules.md", marks=pytest.mark.slow),
        *(
            pytest.param(f"docs/{name}.md", marks=pytest.mark.slow)
            for name in ("sweeps", "fmus", "cosimulation", "ssp")
        ),
        *(pytest.param(f"docs/start/{name}.md", marks=pytest.mark.slow) for name in ("forest", "line", "control")),
    ],
)
def test_scripts_run(document: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    import_module("ropeway.examples.corridor_map").make_raster(tmp_path / "dem.tif")
    if document == "docs/fmus.md":
        carriage(tmp_path / "carriage.fmu")
    monkeypatch.chdir(tmp_path)
    scripts = re.findall(r"```python\n(.*?)```", (ROOT / document).read_text(), re.DOTALL)
    assert scripts
    names: dict[str, object] = {"__name__": "__main__"}
    for script in scripts:
        exec(compile(script, document, "exec"), names)
    assert list(tmp_path.glob("*.png")) or ".plot(" not in "".join(scripts)


def carriage(path: Path) -> None:
    """The FMU of another tool in docs/fmus.md: that of all kinds of variables, with other names."""
    names = {"text": "name", "gear": "mode", "v": "lengths", "brake": "released", "limit": "at_limit"}

    def renamed(text: str) -> str:
        for name, other in names.items():
            text = text.replace(f'name="{name}"', f'name="{other}"')
        return text.replace('Item name="high"', 'Item name="manual"')

    rewritten(kinds_fmu(path.with_name("kinds.fmu"), "3.0"), path, renamed)


def test_every_script_of_the_site_runs() -> None:
    """Each page with a script is among those above, or its script runs in another test."""
    pages = [p for p in (ROOT / "docs").rglob("*.md") if {"made", "api"}.isdisjoint(p.relative_to(ROOT / "docs").parts)]
    scripts = {str(p.relative_to(ROOT)) for p in pages if re.search(r"```(\{code-block\} )?python\n", p.read_text())}
    (marked,) = (m for m in test_scripts_run.pytestmark if m.name == "parametrize")
    run = {value if isinstance(value, str) else value.values[0] for value in marked.args[1]}
    assert scripts - run == {"docs/api.md"}
    assert not any("{code-block} python" in p.read_text() for p in pages)


def test_every_public_name_is_listed() -> None:
    listed = set(re.findall(r"`(\w+)`", (ROOT / "docs" / "names.md").read_text()))
    assert set(rw.__all__) <= listed
    named = re.findall(r"`rw\.(\w+)", "".join(p.read_text() for p in (ROOT / "docs").rglob("*.md")))
    assert all(hasattr(rw, name) for name in named)


def test_every_error_is_explained() -> None:
    explained = set(re.findall(r"`rw\.([\w.]+)`", (ROOT / "docs" / "errors.md").read_text()))
    for prefix, module in (("", rw), ("fmu.", rw.fmu)):
        errors = (
            n
            for n in module.__all__
            if issubclass(type(kind := getattr(module, n)), type) and issubclass(kind, BaseException)
        )
        assert {prefix + name for name in errors} <= explained


TASKS = {
    "payload and report": r"study\.report\(",
    "emergency stop": r"emergency stop",
    "component of your own": r"rw\.check_component",
    "FMU into FMPy": r"fmpy\.simulate_fmu",
    "rope of your own": r"rw\.Rope\(mass_per_length",
}


def test_a_newcomers_tasks_are_two_clicks_from_the_front_page() -> None:
    """Clicks on links of the text; the sidebar has all pages anyway."""
    docs = ROOT / "docs"
    front, reached = {docs / "index.md"}, {docs / "index.md"}
    for _ in range(2):
        links = {(page.parent / to).resolve() for page in front for to in _links(page.read_text())}
        front = {page for page in links if page.is_file() and page.suffix == ".md"}
        reached |= front
    texts = [page.read_text() for page in reached]
    assert [task for task, words in TASKS.items() if not any(re.search(words, text) for text in texts)] == []


def _links(text: str) -> list[str]:
    return re.findall(r"\]\(([\w./-]+\.md)", text) + [f"{to}.md" for to in re.findall(r":link: ([\w/]+)", text)]


BANNED = (
    "comes to an end", "find no place", "finds no place", "find a place", "is asked of", "to and fro", "makes an end",
    "have not come together", "what there is", "no less", "is told", "are told", "told of", "that there is",
    "gone wrong",
    "does not get over", "gives in exchange", "in exchange for a freed", "too much said", "keeps together", "bears out",
    "what cannot be", "of its own accord", "said to be", "has come to", "at hand", "as it stands", "is left alone",
    "are left alone", "lets go", "cannot take down", "somebody", "no more good", "way of the empty carriage",
    "a freed one", "taut branch (", "because fmi wants", "grip lost: nowhere", "is a root, taken",
    "take both neighbouring", "loads held at a hold-down", "any quantity can be given", "runs over at once",
    "stands inside the rope", "without one an ideal hold", "giving way", "is given in exchange",
)  # fmt: skip
"""Literary phrases for which technical words exist."""


def test_prose_is_plain() -> None:
    found = []
    for file in (p for suffix in ("py", "md", "c", "h") for p in ROOT.rglob(f"*.{suffix}")):
        if file == Path(__file__).resolve() or not {".venv", "build"}.isdisjoint(file.relative_to(ROOT).parts):
            continue
        text = " ".join(file.read_text().lower().split())
        found += [(str(file.relative_to(ROOT)), phrase) for phrase in BANNED if phrase in text]
    assert found == []
