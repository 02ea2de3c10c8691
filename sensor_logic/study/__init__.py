# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: one home simulated many times with other parameters, and what came of it.

`study` is the file that a user writes, `draws` makes runs of it, `targets` holds them against the
sensors of the home; `truth` judges a log by what people did, `summary` sums up runs over seeds.
"""
