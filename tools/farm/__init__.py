# SPDX-License-Identifier: Apache-2.0
"""Renders over a cluster: README.md in this folder says how. Python's standard library only."""
