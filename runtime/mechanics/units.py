"""Names of the units of length, mass and time, and of what is composed of them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """Names of units: labels, without conversion."""

    length: str = "m"
    mass: str = "kg"
    time: str = "s"

    def _si_or_composed(self, si: str, composed: str) -> str:
        return si if (self.length, self.mass, self.time) == ("m", "kg", "s") else composed

    @property
    def velocity(self) -> str:
        return f"{self.length}/{self.time}"

    @property
    def angular_velocity(self) -> str:
        return f"rad/{self.time}"

    @property
    def force(self) -> str:
        return self._si_or_composed("N", f"{self.mass} {self.length}/{self.time}^2")

    @property
    def moment(self) -> str:
        return self._si_or_composed("N m", f"{self.mass} {self.length}^2/{self.time}^2")

    @property
    def energy(self) -> str:
        return self._si_or_composed("J", f"{self.mass} {self.length}^2/{self.time}^2")

    @property
    def momentum(self) -> str:
        return f"{self.mass} {self.length}/{self.time}"

    @property
    def angular_momentum(self) -> str:
        return f"{self.mass} {self.length}^2/{self.time}"
