"""The method and the limit of gaps that ``check``, ``view`` and ``score`` use by default."""

DEFAULT_METHOD = "cascade@mujoco:question=stands"
"""The method that judges unless another is named: on layouts of real size it is the most accurate
of those that take milliseconds (page ``real``)."""

GAPS_CM = 2.0
"""How far a box that has nothing under it may drop [cm] before a load is said to hover: customers'
pallets have boxes up to 1.7 cm in the air, from the tolerances of their software."""
