# SPDX-License-Identifier: GPL-3.0-or-later
"""Moving rays and moving bodies, in numpy."""
