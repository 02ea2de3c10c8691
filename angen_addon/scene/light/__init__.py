# SPDX-License-Identifier: GPL-3.0-or-later
"""The light at sensors: `probe` by renders, `direct` by closed forms, `signature` whether it can
have changed."""
