"""Rigid-body engines behind one protocol.

Everything here speaks metres, kilograms, seconds and radians, z up, and knows nothing of layouts,
methods or reports. See :mod:`steadyload.engines.world` for the contract and
:mod:`steadyload.engines.registry` for the list of engines.
"""

if __name__ != "steadyload.engines":
    raise ImportError("engines is installed as steadyload.engines: import it under that name")
