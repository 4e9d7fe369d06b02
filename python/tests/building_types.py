"""Building types as parameters of tests."""

import building2building as b2b
import pytest

#: Types whose episodes take the fewest seconds.
QUICK = {"SingleFamilyHouse", "RestaurantFastFood"}


def every_type() -> list:
    """Returns the building types; tests of the slower ones are nightly."""
    return [
        pytest.param(name, marks=() if name in QUICK else pytest.mark.nightly) for name in b2b.list_building_types()
    ]
