# SPDX-License-Identifier: GPL-3.0-or-later
"""Models of circuits: voltage divider, converter and output stage. Also radiation and light."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .model import Array, Emission

# Voltage divider with a load resistor to ground, and the converter that reads it.
#
# The sensing resistor is between the supply and the output, so the output rises as it conducts
# better: V = Vcc·RM/(RM + R) (Interlink FSR Integration Guide, "Voltage Divider").


def voltage(supply: float, load_resistor: float, resistance: float) -> float:
    """Return the output of a voltage divider in volts, read without drawing current.

    Parameters
    ----------
    supply
        Supply voltage in volts.
    load_resistor
        The fixed resistor between output and ground, in ohms.
    resistance
        The sensing resistor between supply and output, in ohms; can be infinite.

    References
    ----------
    Interlink Electronics, FSR Integration Guide, "Voltage Divider".
    """
    return supply * load_resistor / (load_resistor + resistance)


def adc(voltage: float, supply: float, bits: int) -> int:
    """Return the code of an ideal converter whose reference voltage is `supply`.

    The code is floor(V/Vcc·(2^bits − 1)), with V the voltage and Vcc the supply in volts. V is
    limited to 0 … Vcc.
    """
    largest = (1 << bits) - 1
    return min(max(math.floor(voltage / supply * largest), 0), largest)


# The output stage of a motion detector module: warm-up, hold time and blocking time.
#
# Terms as in the HC-SR501's datasheet. After a trigger the output stays high for the delay (hold)
# time. A module that retriggers restarts the hold time at each new trigger. After the output went
# low, triggers are ignored for the blocking time. During warm-up the output stays low.
#
# A wireless module sends each change as a message (`RadioTiming`). It ignores triggers while its
# radio sends, and the message arrives after a random delay.

# Absorbs the rounding of differences between times, which are multiples of a frame.
TIME_TOLERANCE_S = 1e-9


def waiting(warm_up: float, blocking: float, time: float, fell: float = -math.inf) -> str:
    """Return why a detector ignores movement at `time` (s), and for how long; "" if it does not.

    `fell` is the time (s) at which the output last went off.
    """
    left = warm_up - time
    if left > TIME_TOLERANCE_S:
        return f"warming up, {_seconds(left)} left"
    left = blocking - (time - fell)
    if left > TIME_TOLERANCE_S:
        return f"blocked after it went off, {_seconds(left)} left"
    return ""


def _seconds(time: float) -> str:
    return f"{time:.{0 if time >= 9.95 else 1}f} s"


def _relevant_updates(triggered: NDArray[np.bool_], is_idle: Callable[[], bool]) -> Iterator[int]:
    """Yield the indices of updates that have a trigger, or at which `is_idle` returns false."""
    triggers, i = np.flatnonzero(triggered), 0
    while i < len(triggered):
        if is_idle():
            following = int(np.searchsorted(triggers, i))
            if following == len(triggers):
                return
            i = int(triggers[following])
        yield i
        i += 1


class OutputTiming:
    """The output stage of a detector: on at a trigger, off after the hold time (times in s)."""

    def __init__(self) -> None:
        self.active = False
        self.last_trigger = -math.inf
        self._fell = -math.inf

    def update(
        self,
        time: float,
        triggered: bool,
        hold: float,
        blocking: float,
        warm_up: float,
        retrigger: bool = True,
    ) -> bool:
        """Return whether the output is on at `time`.

        Parameters
        ----------
        triggered
            Whether this update detected motion.
        hold
            How long the output stays on after a trigger, in s.
        blocking
            How long motion is ignored after the output went off, in s.
        warm_up
            The time in s before which motion is ignored.
        retrigger
            Whether motion while the output is on starts the hold time again.
        """
        blocked = not self.active and time - self._fell < blocking - TIME_TOLERANCE_S
        listening = not blocked and (retrigger or not self.active)
        if triggered and listening and time >= warm_up - TIME_TOLERANCE_S:
            self.last_trigger = time
            self.active = True
        elif self.active and time - self.last_trigger >= hold - TIME_TOLERANCE_S:
            self.active = False
            self._fell = time
        return self.active

    def run(
        self,
        times: NDArray[np.float64],
        triggered: NDArray[np.bool_],
        hold: float,
        blocking: float,
        warm_up: float,
        retrigger: bool = True,
    ) -> NDArray[np.bool_]:
        """Return whether the output is on (n,) at `times` (n,).

        `triggered` (n,) has whether each update detected motion. The other parameters are as for
        `update`. For speed, updates without a trigger are skipped while the output is off.
        """
        active = np.zeros(len(times), bool)
        for i in _relevant_updates(triggered, lambda: not self.active):
            seen = bool(triggered[i])
            active[i] = self.update(float(times[i]), seen, hold, blocking, warm_up, retrigger)
        return active


class RadioTiming:
    """The output of a wireless detector as its receiver knows it at each update; times are in s.

    The detector compares the signal with its threshold at each update. Its timer ends the hold time
    exactly, also between two updates.
    """

    def __init__(self) -> None:
        self._module = OutputTiming()
        # The time of the last message, and the messages that have not arrived: (arrival, output).
        self._sent = -math.inf
        self._messages: list[tuple[float, bool]] = []
        self._received = False
        self._before = -math.inf

    def run(
        self,
        times: NDArray[np.float64],
        triggered: NDArray[np.bool_],
        hold: float,
        blocking: float,
        warm_up: float,
        retrigger: bool,
        blanking: float,
        delay: Callable[[int], float],
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """Return the output (n,) that the receiver knows at each update, and the times (n,) in s.

        If a message has arrived since the previous update, the time is its time of arrival.
        Otherwise it is the time of the update.

        Parameters
        ----------
        times, triggered
            The times (n,) of the updates in s, and whether each detected motion (n,).
        hold, blocking, warm_up, retrigger
            The settings of the detector, as in `OutputTiming.update`.
        blanking
            The time in s after a message, during which the detector ignores triggers.
        delay
            A function that returns the delay in s of a message sent at update i, or since the
            previous update. Its argument is the index i.
        """
        received, arrivals = np.zeros(len(times), bool), np.array(times, np.float64)
        module = self._module
        for i in _relevant_updates(triggered, self._is_idle):
            time = float(times[i])
            before = self._before if i == 0 else float(times[i - 1])
            ends = module.last_trigger + hold
            if module.active and time >= ends - TIME_TOLERANCE_S:
                module.update(ends, False, hold, blocking, warm_up, retrigger)
                self._send(ends, False, delay(i))
            if triggered[i] and time - self._sent >= blanking - TIME_TOLERANCE_S:
                was_active = module.active
                module.update(time, True, hold, blocking, warm_up, retrigger)
                if module.active and not was_active:
                    self._send(time, True, delay(i))
            if self._messages and self._messages[0][0] <= time:
                arrival, self._received = self._messages.pop(0)
                arrivals[i] = max(arrival, before)
            received[i] = self._received
        if len(times):
            self._before = float(times[-1])
        return received, arrivals

    def _is_idle(self) -> bool:
        return not (self._module.active or self._messages or self._received)

    def _send(self, time: float, active: bool, delay: float) -> None:
        """Queue a message with the output `active`, to arrive after all earlier messages."""
        self._sent = time
        earliest = self._messages[-1][0] if self._messages else time
        self._messages.append((max(time + delay, earliest), active))


# Thermal radiation.

# In W/(m²·K⁴), CODATA 2018.
STEFAN_BOLTZMANN = 5.670374419e-8


def radiosity(seen: Emission) -> Array:
    """Return the radiosity (n,) of the surfaces in W/m².

    It is what they emit plus what they reflect of surroundings at the ambient temperature.
    """
    emitted = seen.emissivity * seen.temperature**4
    reflected = (1.0 - seen.emissivity) * seen.ambient**4
    result: Array = STEFAN_BOLTZMANN * (emitted + reflected)
    return result


# m²·K/W: 1 clo, and the insulation of the air at a clothed body in a still room, 1 / (4.5 + 3.3),
# by radiation and convection of a seated person (de Dear et al. 1997, cited from memory).
CLO = 0.155
STILL_AIR = 1.0 / 7.8


def insulated_share(clo: float) -> float:
    """Return the share by which the surface of an insulation follows the room, 0 to 1.

    The heat that leaves the skin passes the insulation I and the air I_air in series. So the
    surface is at T_skin + s·(T_room − T_skin), with s = I / (I + I_air). For 1 clo s is 0.55.

    Parameters
    ----------
    clo
        The insulation of clothing, fur or hair, in clo; 0 for bare skin.

    References
    ----------
    ISO 7730, equation of the temperature of clothing; ISO 9920 for the insulation of garments.
    """
    return clo * CLO / (clo * CLO + STILL_AIR)


# Photometric quantities from radiometric ones: luminance, illuminance, 8-bit counts.

# Luminance of linear RGB with the primaries of Rec. 709 (ITU-R BT.709-6, table 1).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# In lm/W. Blender's glTF exporter also converts lamps as if all light had 555 nm.
EFFICACY = 683.0
COUNTS = 255


def luminance(rgb: ArrayLike) -> Array:
    """Return the luminance Y (…) of linear Rec. 709 colours (…, 3), in the unit of the colours.

    The luminance of a lamp with negative power is negative.
    """
    weighted: Array = np.asarray(rgb, dtype=np.float64) @ LUMINANCE
    return weighted


def illuminance(rgb: ArrayLike, efficacy: float = EFFICACY) -> float:
    """Return the illuminance in lux of an irradiance (3,) in W/m², at least 0.

    `efficacy` is in lm/W.
    """
    return max(0.0, efficacy * float(luminance(rgb)))


def counts(rgb: ArrayLike, exposure: float) -> Array:
    """Return linear radiances (…) as 8-bit values (…): round(255 · clamp(exposure · L, 0, 1)).

    Halves are rounded up, as in a converter; NaN gives 0.
    """
    light = np.nan_to_num(np.asarray(rgb, dtype=np.float64) * exposure, nan=0.0)
    return np.floor(COUNTS * np.clip(light, 0.0, 1.0) + 0.5)


def luminance_percent(views: ArrayLike, exposure: float) -> float:
    """Return the mean luminance in percent of `views` (n, 3), each one pixel of linear radiance.

    A white view has 100 %. A view in which all channels have the 8-bit value 1 has 0.39 %.
    """
    return float(luminance(counts(views, exposure)).mean() / COUNTS * 100.0)
