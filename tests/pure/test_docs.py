# SPDX-License-Identifier: GPL-3.0-or-later
"""The docs say what the code says."""

import parameter_tables


def test_the_parameter_page_is_up_to_date():
    written = parameter_tables.PAGE.read_text(encoding="utf-8")
    assert written == parameter_tables.page(), "run: python scripts/parameter_tables.py"
