"""Three methods for the tension of a span: successive substitution, Newton-Raphson, Brown.

    python examples/turk_solvers.py [folder]

Turk (1988) compares them for an unstretched length of 1000 and of 1001 ft; the data of his span are lost. Here: a
span of 1000 ft that rises 45 ft, a rope of 1.42 lb/ft with EA = 3.5e6 lbf, and eight loads of 150 lbf. Draws
`turk_solvers.png` and prints the rounds and evaluations that each method takes.
"""

from __future__ import annotations

import sys
from pathlib import Path

from ropeway.systems.studies.handbook.turk_solvers import History, SpanProblem, solve_span

LOADS = 8
METHODS = {"successive substitution": "#b5482a", "Newton-Raphson": "#1b6ca8", "Brown": "#5b8c2a"}
STARTS = (1.0 / 3.0, 3.0)


def span(length: float) -> SpanProblem:
    """The span for an unstretched length [ft]."""
    distances = tuple(length * (k + 0.5) / LOADS for k in range(LOADS))
    return SpanProblem(1000.0, 45.0, length, 1.42, 3.5e6, distances, (150.0,) * LOADS)


def run(problem: SpanProblem, method: str, scale: float, damped: bool) -> History:
    """One iteration from `scale` times the parabola's horizontal tension."""
    h, v = problem.start
    start = (scale * h, v + (1.0 - scale) * h * problem.rise / problem.span)
    return solve_span(problem, method, start=start, damped=damped, limit=60)  # type: ignore[arg-type]


def main(folder: Path | None = None) -> Path:
    """Print the table and write the picture; returns its path."""
    print(f"{'rope':>8} {'start':>6}  {'method':24s} {'plain':>18} {'damped':>18}   (iterations, evaluations)")
    for length in (1000.0, 1001.0):
        problem = span(length)
        for scale in (0.1, 1.0 / 3.0, 1.0, 3.0, 10.0):
            for method in METHODS:
                words = [_words(run(problem, method, scale, damped)) for damped in (False, True)]
                print(f"{length:5.0f} ft x{scale:5.2f}  {method:24s} {words[0]:>18} {words[1]:>18}")
    return _draw(Path.cwd() if folder is None else folder)


def _words(history: History) -> str:
    if not history.converged:
        return "fails"
    return f"{history.iterations:d}, {int(history.frame['evaluations'].iloc[-1]):d}"


def _draw(folder: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.5, 7.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for row, scale in zip(panels, STARTS, strict=True):
        for panel, length in zip(row, (1000.0, 1001.0), strict=True):
            problem = span(length)
            for method, colour in METHODS.items():
                for damped in (False, True):
                    history = run(problem, method, scale, damped)
                    frame = history.frame[history.frame["horizontal"] > 0.0]
                    label = f"{method}, {'damped' if damped else 'plain'}"
                    label += "" if history.converged else ": fails at once"
                    style = "--" if damped else "-"
                    panel.plot(
                        frame["evaluations"],
                        frame["miss"],
                        style,
                        color=colour,
                        marker="o",
                        ms=3.5,
                        lw=1.4,
                        label=label,
                    )
            panel.axhline(1e-6, color="0.6", lw=1.0)
            panel.annotate("solved", (80.0, 1e-6), xytext=(0, -12), textcoords="offset points", ha="right", color="0.4")
            panel.set(yscale="log", ylim=(1e-8, 300.0), xlim=(-2.0, 106.0))
            panel.grid(alpha=0.25)
            panel.spines[["top", "right"]].set_visible(False)
            word = "a third of" if scale < 1.0 else "three times"
            panel.set_title(f"{length:.0f} ft of rope, H started at {word} the parabola's", loc="left", fontsize=10.5)
            panel.legend(fontsize=8, frameon=False, loc="upper right")
    for panel in panels[:, 0]:
        panel.set_ylabel("rope's end misses its support by [ft]")
    for panel in panels[1]:
        panel.set_xlabel("evaluations of one equation")
    figure.suptitle(
        "One foot of rope more: a 1001.01 ft chord, loaded, after Turk (1988, chapter 3; own data)", fontsize=12
    )
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "turk_solvers.png"
    figure.savefig(path, dpi=130)
    return path


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
