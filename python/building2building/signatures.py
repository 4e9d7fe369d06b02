"""Functions that take the arguments of a class."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import ParamSpec, TypeVar, cast

P = ParamSpec("P")
T = TypeVar("T")


def with_arguments_of(maker: Callable[P, object]) -> Callable[[Callable[..., T]], Callable[P, T]]:
    """Gives a function the arguments of a class, for type checkers, editors and ``help``."""

    def give(function: Callable[..., T]) -> Callable[P, T]:
        returned = inspect.signature(function).return_annotation
        signature = inspect.signature(maker).replace(return_annotation=returned)
        function.__signature__ = signature  # type: ignore[attr-defined]
        return cast(Callable[P, T], function)

    return give
