"""The mass matrix of an equilibrium cut at material points, and its flexibility: both by free coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse import bsr_matrix, coo_matrix, csr_matrix, diags, vstack
from scipy.sparse.linalg import LinearOperator, splu

from ropeway.components.catenary import Strain
from ropeway.components.errors import EquilibriumError
from ropeway.components.node import Node
from ropeway.components.weather import SHARED, Weather
from ropeway.systems.solvers.newton import newton_of
from ropeway.systems.studies.inertia.material_points import CutSpan, MaterialPoints


@dataclass(frozen=True)
class Motion:
    """The linearised motion of a line about its equilibrium, by small displacements of its free coordinates.

    flexibility : displacements of the coordinates by forces along them [m/N].
    mass : mass of what moves lengthwise, sideways and vertically [kg], three matrices (coordinates, coordinates).
    rows : displacement of the points of all spans, x, y and z of each, by the coordinates.
    """

    flexibility: LinearOperator
    mass: tuple[csr_matrix, csr_matrix, csr_matrix]
    rows: csr_matrix


@dataclass(frozen=True)
class _Free:
    """The free coordinates: positions and travels that ropes determine.

    index : number of each coordinate, by the name of its variable.
    forces : for each coordinate the residuals in which a force along it appears, with factors.
    masses : mass of the nodes at each coordinate [kg], (coordinates,).
    strain : strain of the rope at each travel, by the name of its variable.
    """

    index: Mapping[str, int]
    forces: tuple[Mapping[str, float], ...]
    masses: np.ndarray
    strain: Mapping[str, float]


def linear_motion(cut: MaterialPoints) -> Motion:
    """Flexibility and mass of a cut equilibrium. Raises EquilibriumError where its equations are singular."""
    free = _free(cut)
    starts, stops = (_rope_ends(cut, free, k) for k in (0, 1))
    frames = np.array([_frame(span) for span in cut.spans for _ in span.pieces]).reshape(-1, 3, 3)
    per_piece = [
        (rope_mass(cut, piece) * length, span.lumped)
        for span in cut.spans
        for piece, length in zip(span.pieces, np.diff(span.station), strict=True)
    ]
    kilograms, lumped = np.array(per_piece).reshape(-1, 2).T
    own, both = diags(kilograms * (2.0 + lumped) / 6.0), diags(kilograms * (1.0 - lumped) / 6.0)
    mass = []
    for u, v, w in zip(_turned(frames, starts), _turned(frames, stops), _nodes(cut, free), strict=True):
        shared = u.T @ both @ v
        mass.append(u.T @ own @ u + v.T @ own @ v + shared + shared.T + w.T @ w)
    last = np.cumsum([len(span.pieces) for span in cut.spans])
    rows = [
        matrix
        for before, after in zip((0, *last[:-1]), last, strict=True)
        for matrix in (starts[3 * before : 3 * after], stops[3 * after - 3 : 3 * after])
    ]
    return Motion(_flexibility(cut, free), (mass[0], mass[1], mass[2]), vstack(rows, format="csr"))


def rope_mass(cut: MaterialPoints, piece: str) -> float:
    """Mass of a piece of rope with its ice [kg/m]."""
    mass, diameter = (cut.read(f"{piece}.{name}", 0.0) for name in ("mass_per_length", "diameter"))
    if not cut.model.weather:
        return mass
    still = Weather.of([cut.read(name) for name in SHARED])._replace(pressure=0.0)
    return float(still.rope(mass, 1.0, diameter, 0.0, (1.0, 0.0, 0.0)).size)


def _frame(span: CutSpan) -> np.ndarray:
    """Unit vectors of a span, (3, 3): horizontal along its chord, sideways, up."""
    x, y, _ = span.place[-1] - span.place[0]
    level = np.hypot(x, y)
    cosine, sine = (x / level, y / level) if level > 0.0 else (1.0, 0.0)
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _turned(frames: np.ndarray, rows: csr_matrix) -> tuple[csr_matrix, csr_matrix, csr_matrix]:
    """Displacements of points by x, y, z as those lengthwise, sideways and up."""
    count = len(frames)
    frame = bsr_matrix((frames, np.arange(count), np.arange(count + 1)), shape=(3 * count, 3 * count))
    turned = frame.tocsr() @ rows
    return turned[0::3], turned[1::3], turned[2::3]


def _free(cut: MaterialPoints) -> _Free:
    """All free coordinates of a model."""
    model = cut.model
    strain = _strains(cut)
    forces: dict[str, dict[str, float]] = {}
    masses: dict[str, float] = {}
    for balance in model.balances:
        name, residual = model.z.names[balance.travel], model.r.names[balance.residual]
        forces[name] = {residual: balance.sign / (1.0 + strain.get(name, 0.0))}
    for node in model.system.components.values():
        if not isinstance(node, Node):
            continue

        def read(name: str, owner: str = node.name) -> float:
            return cut.read(f"{owner}.{name}")

        for moving in node.masses(read):
            name = f"{node.name}.{moving.place}"
            if name in model.z.index:
                masses[name] = masses.get(name, 0.0) + float(moving.mass)
                given = {f"{node.name}.{residual}": float(factor) for residual, factor in moving.forces.items()}
                forces.setdefault(name, given)
    index = {name: i for i, name in enumerate(forces)}
    return _Free(index, tuple(forces.values()), np.array([masses.get(name, 0.0) for name in index]), strain)


def _strains(cut: MaterialPoints) -> dict[str, float]:
    """Strain of the rope at each travel that is an algebraic variable, by its name."""
    model, found = cut.model, dict[str, float]()
    forces = {piece: force for span in cut.spans for piece, force in zip(span.pieces, span.force, strict=True)}
    for run, layout in zip(model.runs, model.layouts, strict=True):
        for k in np.flatnonzero(layout.travel.algebraic >= 0).tolist():
            piece = run.spans[max(k - 1, 0)].name
            tension = float(np.linalg.norm(forces[piece][1 if k else 0]))
            compliance = cut.read(f"{piece}.compliance")
            found[model.z.names[layout.travel.algebraic[k]]] = float(Strain(compliance, run.rope.strain.c2).at(tension))
    return found


def _rope_ends(cut: MaterialPoints, free: _Free, end: int) -> csr_matrix:
    """Displacement of the rope at the start (0) or the end (1) of all pieces, (3 pieces, coordinates): that of its
    node, and along the rope what runs over the node."""
    entries = list[tuple[int, int, float]]()
    seats = {
        (node.name, seat.name): seat
        for node in cut.model.system.components.values()
        if isinstance(node, Node)
        for seat in node.seats
    }
    pieces = [(piece, force[end]) for span in cut.spans for piece, force in zip(span.pieces, span.force, strict=True)]
    for i, (piece, force) in enumerate(pieces):
        owner, name = cut.model.system.connections[piece, "ab"[end]]
        travel = f"{owner}.{seats[owner, name].travel}"
        tangent = force / np.linalg.norm(force)
        for j, axis in enumerate("xyz"):
            if f"{owner}.{axis}" in free.index:
                entries.append((3 * i + j, free.index[f"{owner}.{axis}"], 1.0))
            if travel in free.index:
                entries.append((3 * i + j, free.index[travel], tangent[j]))
    row, column, value = zip(*entries, strict=True) if entries else ((), (), ())
    return coo_matrix((value, (row, column)), shape=(3 * len(pieces), len(free.index))).tocsr()


def _nodes(cut: MaterialPoints, free: _Free) -> tuple[csr_matrix, csr_matrix, csr_matrix]:
    """Displacements of the nodes lengthwise, sideways and up, times the roots of their masses."""
    frame = dict[str, np.ndarray]()
    for span in cut.spans:
        for piece in span.pieces:
            for end in "ab":
                frame.setdefault(cut.model.system.connections[piece, end][0], _frame(span))
    owners = list(dict.fromkeys(name.rpartition(".")[0] for name in free.index))
    row = [3 * owners.index(n.rpartition(".")[0]) + max("xyz".find(n.rpartition(".")[2]), 0) for n in free.index]
    count = len(free.index)
    rows = coo_matrix((np.sqrt(free.masses), (row, np.arange(count))), shape=(3 * len(owners), count)).tocsr()
    return _turned(np.array([frame.get(owner, np.eye(3)) for owner in owners]).reshape(-1, 3, 3), rows)


def _flexibility(cut: MaterialPoints, free: _Free) -> LinearOperator:
    """Displacements by forces, from the linearised equations. Raises EquilibriumError."""
    model, count = cut.model, len(free.index)
    entries = [
        (model.r.index[name], i, factor / model.r.nominals[model.r.index[name]])
        for i, forces in enumerate(free.forces)
        for name, factor in forces.items()
    ]
    row, column, value = zip(*entries, strict=True) if entries else ((), (), ())
    right = coo_matrix((value, (row, column)), shape=(len(model.z), count)).tocsr()
    place = np.array([model.z.index[name] for name in free.index], dtype=int)
    try:
        factors = splu(newton_of(model).matrix(cut.point))
    except RuntimeError as error:
        raise EquilibriumError(f"The equations of {model.name!r} are singular", "Hold all ropes and nodes") from error

    def displaced(force: np.ndarray) -> np.ndarray:
        moved = factors.solve(np.asarray(right @ force))[place]
        return np.asarray(-(moved.T * model.z.nominals[place]).T)

    return LinearOperator((count, count), matvec=displaced, matmat=displaced, dtype=float)
