"""Kernels in C and on arrays have the values of their CasADi function."""

import ctypes

import casadi as ca
import numpy as np

from ropeway.systems.native.binary_cache import library
from ropeway.systems.native.kernel_source import kernel_source
from ropeway.systems.solvers.array_function import ArrayFunction


def every_operation() -> ca.Function:
    v = ca.SX.sym("v", 4)
    a, b, c, d = ca.vertsplit(v)
    results = [
        a + b, a - b, a * b, a / c, -a, a**2, 2 * a, 1 / c, ca.exp(a), ca.log(c), ca.sqrt(c), ca.sin(a), ca.cos(a),
        ca.tan(a), ca.asin(d), ca.acos(d), ca.atan(a), ca.sinh(a), ca.cosh(a), ca.tanh(a), ca.asinh(a), ca.acosh(c + 1),
        ca.atanh(d), ca.log1p(d), ca.expm1(d), ca.floor(a), ca.ceil(a), ca.fabs(a), ca.sign(a), ca.fmin(a, b),
        ca.fmax(a, b), ca.atan2(a, b), ca.hypot(a, b), ca.copysign(a, b), c**a, c**1.3, ca.if_else(a < b, a, c),
        ca.if_else(ca.logic_and(a <= b, ca.logic_not(a == b)), a, c), ca.if_else(ca.logic_or(a != b, a < 0), d, c),
        (a < b) + 1.5 * (b <= c), ca.SX(3.25),
    ]  # fmt: skip
    return ca.Function("every", [v], [ca.densify(ca.vertcat(*results))])


def points() -> np.ndarray:
    rng = np.random.default_rng(5)
    found = rng.uniform([-3.0, -3.0, 0.1, -0.9], [3.0, 3.0, 4.0, 0.9], (200, 4))
    found[::7, 1] = found[::7, 0]
    return found


def test_in_c_and_on_arrays() -> None:
    function = every_operation()
    expected = np.array([np.array(function(p)).ravel() for p in points()])
    on_arrays = np.array([np.broadcast_to(r, 200) for r in ArrayFunction(function)(list(points().T))]).T
    np.testing.assert_allclose(on_arrays, expected, rtol=4e-16, atol=0.0)
    compiled, found = library({"kernel.c": kernel_source(function, "kernel")}).kernel, np.empty(expected.shape[1])
    compiled.argtypes, compiled.restype = [ctypes.c_void_p, ctypes.c_void_p], None
    for point, values in zip(points(), expected, strict=True):
        compiled(np.ascontiguousarray(point).ctypes.data, found.ctypes.data)
        np.testing.assert_allclose(found, values, rtol=4e-16, atol=0.0)


def test_an_entry_does_not_depend_on_the_others() -> None:
    function = ArrayFunction(every_operation())
    whole = function(list(points().T))
    part = function(list(np.ascontiguousarray(points()[17:20].T)))
    for one, other in zip(whole, part, strict=True):
        if one.ndim:
            assert one[17:20].tobytes() == other.tobytes()
