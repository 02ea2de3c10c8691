# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed against error, each with its reference. Run with `make bench`."""

import os

# As the command line sets it, before numpy is loaded.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
