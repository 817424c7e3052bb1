"""The checks in C: sources, how they are built, and what Python calls of them by ctypes.

``library`` loads them, ``whole`` judges layouts, ``timed`` follows boxes that lose their balance,
``session`` has layouts that grow, ``loading`` what searches for other plans call, ``forces`` those
forces that others set up, and ``learned`` what learned methods judge by. Arrays are as the headers
say: C-contiguous, of type float64 where nothing else is said. Another array raises
:class:`~steadyload.core.library.WrongArrayError` before C reads it.
"""
