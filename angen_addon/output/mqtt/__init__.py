# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors as live devices at an MQTT broker. Only `link` needs paho-mqtt, and imports it when a
connection is made; nothing here needs Blender."""
