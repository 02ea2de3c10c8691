# SPDX-License-Identifier: GPL-3.0-or-later
"""What a kind of sensor defines about its appearance: housings, handles, figures, explanations."""
