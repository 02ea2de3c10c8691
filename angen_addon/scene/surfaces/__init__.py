# SPDX-License-Identifier: GPL-3.0-or-later
"""The properties of surfaces that models can query with rays, such as their temperature.

Each module in this folder with a `PROBE` reads one of them.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from .probe import SurfaceProbe


def _probes() -> dict[str, type[SurfaceProbe]]:
    """Return the probes in this folder by the names of their queries."""
    modules = [import_module(f"{__name__}.{m.name}") for m in pkgutil.iter_modules(__path__)]
    probes = [module.PROBE for module in modules if hasattr(module, "PROBE")]
    return {probe.need: probe for probe in probes}


SURFACES = _probes()
