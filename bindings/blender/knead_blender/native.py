# SPDX-License-Identifier: GPL-3.0-or-later
"""The module `knead`: the one that the add-on brings, else one that is installed."""

try:
    from .lib import knead
except ImportError:
    import knead

__all__ = ["knead"]
