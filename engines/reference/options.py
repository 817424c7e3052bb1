"""Options of the reference simulator, and its two sets of contact parameters."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from steadyload.engines.quantities import check_ranges, quantity
from steadyload.engines.reference.law import Law, damping_ratio


class Contact(StrEnum):
    """A set of contact parameters.

    ``stiff``: as rigid as labels need; linear. ``adams``: the values of the paper's reference
    simulation in MSC ADAMS, taken over from cm to m. Its scripts set no unit of force; newton, the
    default, is assumed: 6e7 N/cm^1.2 and 800 N s/cm. Every item starts 1 mm above the floor.
    """

    STIFF = "stiff"
    ADAMS = "adams"


class Integrator(StrEnum):
    """The integrator: our own Rosenbrock method, or scipy's Radau to check it against."""

    RODAS = "rodas"
    RADAU = "radau"


_VALUES = MappingProxyType(
    {
        Contact.STIFF: MappingProxyType(
            {
                "stiffness": 1e9,
                "exponent": 1.0,
                "damping_time": 3e-3,
                "damping_depth": 1e-8,
                "dynamic_share": 1.0,
                "stiction_speed": 1e-4,
                "friction_speed": 1e-2,
                "most_rate": 3e4,
                "floor_gap": 0.0,
            }
        ),
        Contact.ADAMS: MappingProxyType(
            {
                "stiffness": 6e7 * 100.0**1.2,
                "exponent": 1.2,
                "damping_time": 800.0 * 100.0 / (6e7 * 100.0**1.2),
                "damping_depth": 1e-5,
                "dynamic_share": 0.75,
                "stiction_speed": 1e-4,
                "friction_speed": 1e-2,
                "most_rate": 1e9,
                "floor_gap": 1e-3,
            }
        ),
    }
)


@dataclass(frozen=True)
class ReferenceOptions:
    """Accuracy and contact. Values that are None come with ``contact``.

    Raises:
        ValueError: a value outside its range, friction that would have to become dynamic before it
            is full, or a coefficient of restitution for contacts that have none.
    """

    tolerance: float = quantity(
        1e-7, "error allowed a step: of positions; velocities 100 times as much a second",
        unit="m", least=1e-12, most=1e-4,
    )  # fmt: skip
    most_time: float = quantity(
        0.01, "longest step of the integrator", unit="s", least=1e-6, most=1
    )
    integrator: Integrator = quantity(Integrator.RODAS, "radau: scipy's, slow, as a check")
    contact: Contact = quantity(Contact.STIFF, "the set of contact parameters")
    stiffness: float | None = quantity(None, "of a contact, N/m^exponent", least=1.0, most=1e14)
    exponent: float | None = quantity(None, "of the depth in the elastic force", least=1, most=3)
    damping_time: float | None = quantity(
        None, "damping of a contact at full depth, over its stiffness", unit="s", least=0, most=10
    )
    damping_depth: float | None = quantity(
        None, "depth at which damping is full", unit="m", least=1e-12, most=1
    )
    dynamic_share: float | None = quantity(None, "dynamic over static friction", least=0, most=1)
    stiction_speed: float | None = quantity(
        None, "sliding speed at which friction is full", unit="m/s", least=1e-6, most=1
    )
    friction_speed: float | None = quantity(
        None, "sliding speed at which friction has become dynamic", unit="m/s", least=1e-9, most=10
    )
    most_rate: float | None = quantity(
        None, "soften a contact on which a body alone would vibrate faster, rad/s",
        least=1, most=1e12,
    )  # fmt: skip
    floor_gap: float | None = quantity(
        None, "distance of the floor below z = 0", unit="m", least=0, most=1
    )
    rebound: float | None = quantity(
        None, "coefficient of restitution, in the place of damping_time", least=0, most=0.999,
        later=True,
    )  # fmt: skip

    def __post_init__(self) -> None:
        object.__setattr__(self, "integrator", Integrator(self.integrator))
        object.__setattr__(self, "contact", Contact(self.contact))
        check_ranges(self)
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if value is not None and not isinstance(value, StrEnum):
                # Compiled code is made for floats; a whole number would be compiled for anew.
                object.__setattr__(self, field.name, float(value))
        if self.value("friction_speed") <= self.value("stiction_speed"):
            raise ValueError(
                f"friction_speed is {self.value('friction_speed'):g} m/s; allowed: more than "
                f"stiction_speed, {self.value('stiction_speed'):g} m/s"
            )
        if self.rebound is not None:
            self._check_rebound(self.rebound)

    def _check_rebound(self, rebound: float) -> None:
        if self.damping_time is not None:
            raise ValueError(
                f"rebound is {rebound:g} and damping_time {self.damping_time:g} s; allowed: one of "
                "them, as both say how contacts are damped"
            )
        if self.value("exponent") != 1.0:
            raise ValueError(
                f"rebound is {rebound:g} at an exponent of {self.value('exponent'):g}; allowed: an "
                "exponent of 1, at which restitution does not depend on the speed"
            )

    def value(self, name: str) -> float:
        """A contact parameter: as stated, or as it comes with :attr:`contact`."""
        stated = getattr(self, name)
        return _VALUES[self.contact][name] if stated is None else stated

    def law(self, friction: float) -> Law:
        """The forces of a contact with the given static coefficient of friction."""
        return Law(
            self.value("stiffness"),
            self.value("exponent"),
            self.value("stiffness") * self.value("damping_time"),
            self.value("damping_depth"),
            friction,
            friction * self.value("dynamic_share"),
            self.value("stiction_speed"),
            self.value("friction_speed"),
            self.value("most_rate"),
            0.0 if self.rebound is None else damping_ratio(self.rebound),
        )
