# SPDX-License-Identifier: GPL-3.0-or-later
"""What turns quantities of the world into what a circuit makes of them."""
