# SPDX-License-Identifier: BSD-3-Clause
"""A share of the profile's random examples, for tests whose examples take long, and what others repeat."""

import os

from hypothesis import HealthCheck, settings

FULL = bool(os.environ.get("KANE_FULL"))
"""Whether tests that are marked `grows` go through all that they may, not through a part."""


def examples(share: float, least: int = 1, **more: object) -> settings:
    """Settings of a test that draws `share` of the profile's examples, `least` at the least; building one takes its time."""
    return settings(
        max_examples=max(least, round(share * settings().max_examples)),
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large],
        **more,
    )
