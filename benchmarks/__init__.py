# SPDX-License-Identifier: GPL-3.0-or-later
"""Benchmarks of speed and error, each against a reference. Run them with `make bench`."""

import os

# Set before numpy is loaded, as the command line of the extension does.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
