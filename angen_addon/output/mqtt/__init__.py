# SPDX-License-Identifier: GPL-3.0-or-later
"""Publishes sensors as live devices at an MQTT broker.

Only `link` needs paho-mqtt, and imports it when it connects. Nothing here needs Blender, except
`sending`.
"""
