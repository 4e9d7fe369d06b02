"""Functions that take the arguments of a class."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from typing import ParamSpec, TypeVar, cast

P = ParamSpec("P")
T = TypeVar("T")


def with_arguments_of(maker: Callable[P, object], **more: object) -> Callable[[Callable[..., T]], Callable[P, T]]:
    """Gives a function the arguments of a class, and ``more`` with their defaults, for type checkers and ``help``."""

    def give(function: Callable[..., T]) -> Callable[P, T]:
        returned = inspect.signature(function).return_annotation
        signature = inspect.signature(maker)
        own = [inspect.Parameter(each, inspect.Parameter.KEYWORD_ONLY, default=more[each]) for each in more]
        parameters = [*signature.parameters.values(), *own]
        signature = signature.replace(parameters=parameters, return_annotation=returned)
        function.__signature__ = signature  # type: ignore[attr-defined]
        return cast(Callable[P, T], function)

    return give


def renamed(positions: int | None = None, **now: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Raises for arguments of the original implementation and names what replaces each, ``now`` (docs/coming_from.md).

    A call with more than ``positions`` positional arguments also counts as one to the original.
    """

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        # Names of classes, not of their constructors.
        name = function.__qualname__.removesuffix(".__init__").rpartition(".")[2]

        @functools.wraps(function)
        def checked(*arguments: P.args, **options: P.kwargs) -> T:
            old = next((each for each in now if each in options), None)
            if old is None and positions is not None and len(arguments) > positions:
                old = next(iter(now))
            if old is not None:
                raise TypeError(
                    f"{name}() has no argument `{old}` of the original implementation: {now[old]} (see "
                    "docs/coming_from.md)"
                )
            return function(*arguments, **options)

        return checked

    return decorate


def check_names(
    name: str,
    arguments: Iterable[str],
    takers: Iterable[Callable[..., object]],
    other: Callable[..., object] | None = None,
    remedy: str = "",
) -> None:
    """Raises a :class:`TypeError` that suggests the nearest name for an argument that none of ``takers`` has.

    For an argument of ``other``, it has the ``remedy`` instead.
    """
    known = [parameter for taker in takers for parameter in inspect.signature(taker).parameters]
    of_other = () if other is None else inspect.signature(other).parameters
    for argument in arguments:
        if argument not in known:
            if argument in of_other:
                raise TypeError(f"{name}() has no argument `{argument}`, {remedy}")
            near = get_close_matches(argument, known, 1)
            hint = f"; did you mean `{near[0]}`?" if near else ""
            raise TypeError(f"{name}() has no argument `{argument}`{hint}")
