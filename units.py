"""Other units in SI units, for scripts: `45.0 * rw.units.KIP` is a force in N, `length / rw.units.FOOT` one in feet.

Mass [kg]: POUND, SHORT_TON, TONNE; length [m]: INCH, FOOT, MILE; force [N]: POUND_FORCE, KIP, KILOGRAM_FORCE,
TONNE_FORCE; mass per length [kg/m]: POUND_PER_FOOT; speed [m/s]: FOOT_PER_MINUTE, MILE_PER_HOUR, KILOMETRE_PER_HOUR;
pressure [Pa]: PSI; power [W]: HORSEPOWER; angle [rad]: DEGREE, GON.
"""

from ropeway.components.units import factor

POUND, TONNE = factor("lb", "kg"), factor("t", "kg")
SHORT_TON = 2000.0 * POUND
INCH, FOOT, MILE = (factor(unit, "m") for unit in ("in", "ft", "mi"))
POUND_FORCE, KIP, KILOGRAM_FORCE, TONNE_FORCE = (factor(unit, "N") for unit in ("lbf", "kip", "kgf", "tf"))
POUND_PER_FOOT = POUND / FOOT
FOOT_PER_MINUTE, MILE_PER_HOUR, KILOMETRE_PER_HOUR = (factor(unit, "m/s") for unit in ("fpm", "mph", "kmh"))
PSI, HORSEPOWER = factor("psi", "Pa"), factor("hp", "W")
DEGREE, GON = factor("deg", "rad"), factor("gon", "rad")
