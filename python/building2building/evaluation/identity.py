"""The identity of a policy: a digest of its code and of the values that it refers to."""

from __future__ import annotations

import copyreg
import dis
import functools
import hashlib
import importlib
import importlib.metadata
import os
import site
import sys
import sysconfig
import types
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import gymnasium
import numpy as np

from ..env import BuildingEnv
from ..errors import SettingError

#: Attributes of a class that Python or a decorator derives from others.
_DERIVED = {
    "__abstractmethods__",
    "__annotate__",
    "__annotate_func__",
    "__annotations__",
    "__annotations_cache__",
    "__dataclass_fields__",
    "__dataclass_params__",
    "__dict__",
    "__doc__",
    "__firstlineno__",
    "__module__",
    "__orig_bases__",
    "__parameters__",
    "__qualname__",
    "__slotnames__",
    "__static_attributes__",
    "__weakref__",
    "_abc_impl",
}
_PLAIN = (bool, int, float, complex, str, bytes, bytearray, range, type(None), type(...), type(NotImplemented))
_CONTAINERS = (list, tuple, set, frozenset, dict, np.ndarray, np.generic)
_SLOTS = (
    types.MemberDescriptorType,
    types.GetSetDescriptorType,
    types.WrapperDescriptorType,
    types.MethodDescriptorType,
)


def identity_of(policy: Any, version: str) -> str:
    """Returns what identifies a policy in a folder of results.

    Without a version, that is a digest of its code and of everything that it refers to: closures, defaults, global
    variables, attributes, and the versions of installed packages. A version stands for all values, so the
    digest covers only the code. Raises :class:`SettingError` for a value that cannot be identified.
    """
    digest = _Digest(with_values=not version)
    try:
        digest.add(policy, getattr(policy, "__name__", type(policy).__name__))
    except (_Unidentified, RecursionError) as error:
        what = f"{error.place} ({type(error.value).__name__})" if isinstance(error, _Unidentified) else "the policy"
        raise SettingError(
            f"{what} cannot be identified, so the folder could return results of "
            "another policy later; pass version=..., and change it whenever the policy changes"
        ) from error
    return f"{'code' if version else 'code and values'} {digest.text()}"


class _Unidentified(Exception):
    def __init__(self, place: str, value: Any):
        super().__init__(place)
        self.place, self.value = place, value


class _Digest:
    """A SHA-256 of objects: their types and parts, in a fixed order."""

    def __init__(self, with_values: bool):
        self._with_values = with_values
        self._hash = hashlib.sha256()
        #: Number of every object by its id, and the objects, kept so that their ids are not reused.
        self._numbers: dict[int, int] = {}
        self._kept: list[Any] = []

    def text(self) -> str:
        return self._hash.hexdigest()[:16]

    def add(self, value: Any, place: str) -> None:
        """Adds a value. ``place`` names it in an error."""
        if type(value) in _PLAIN:
            if self._with_values:
                self._token(type(value).__name__, repr(value))
            return
        if not self._with_values and isinstance(value, _CONTAINERS):
            return
        if id(value) in self._numbers:
            self._token("again", str(self._numbers[id(value)]))
            return
        self._numbers[id(value)] = len(self._kept)
        self._kept.append(value)
        for kind, add in _BY_TYPE:
            if isinstance(value, kind):
                add(self, value, place)
                return
        if hasattr(value, "__wrapped__"):
            self.add(value.__wrapped__, place)
        elif not self._with_values:
            # For an object, the code of its class.
            self.add(type(value), place)
        else:
            self._object(value, place)

    def _token(self, kind: str, data: str | bytes) -> None:
        data = data.encode(errors="surrogatepass") if isinstance(data, str) else data
        self._hash.update(f"{kind} {len(data)} ".encode())
        self._hash.update(data)

    def _all(self, kind: str, values: Iterable[Any], place: str) -> None:
        for number, value in enumerate(values):
            self._token(kind, str(number))
            self.add(value, f"{place}[{number}]")

    def _sequence(self, value: Any, place: str) -> None:
        if type(value) in (list, tuple):
            self._all(type(value).__name__, value, place)
        else:
            self._object(value, place)

    def _set(self, value: Any, place: str) -> None:
        # Their order differs from process to process.
        parts = []
        for each in value:
            part = _Digest(self._with_values)
            part.add(each, place)
            parts.append(part.text())
        self._token(type(value).__name__, " ".join(sorted(parts)))

    def _dict(self, value: Any, place: str) -> None:
        if type(value) is not dict:
            self._object(value, place)
            return
        for name, each in value.items():
            self._token("key", "")
            self.add(name, place)
            self.add(each, f"{place}[{name!r}]")

    def _array(self, value: Any, place: str) -> None:
        array = np.asarray(value)
        self._token("array", f"{array.dtype.str} {array.shape}")
        if array.dtype.hasobject:
            self._all("element", array.ravel().tolist(), place)
        else:
            self._token("data", np.ascontiguousarray(array).tobytes())

    def _environment(self, value: Any, place: str) -> None:
        # Its arguments rather than its state, which every episode changes.
        spec = getattr(value.unwrapped, "spec", None)
        self._token("environment", f"{getattr(spec, 'id', '')} {value.metadata.get('buildings', '')}")
        if isinstance(value, BuildingEnv):
            self.add(dict(value._arguments), place)
        elif isinstance(value, gymnasium.Wrapper):
            self.add(type(value), place)
            self.add(value.env, place)

    def _module(self, value: types.ModuleType, place: str) -> None:
        self._token("module", f"{value.__name__} {_version(value.__name__)}")

    def _function(self, value: types.FunctionType, place: str) -> None:
        self._token("function", value.__qualname__)
        self._all("closure", _cells(value), place)
        if _is_installed(value.__module__):
            self._token("package", f"{value.__module__} {_version(value.__module__)}")
            return
        self._code(value.__code__)
        self.add(value.__defaults__ or (), place)
        self.add(value.__kwdefaults__ or {}, place)
        for name, each in _named_by(value):
            self._token("variable", name)
            self.add(each, name)

    def _code(self, code: types.CodeType) -> None:
        self._token("code", code.co_code)
        self._token("exceptions", getattr(code, "co_exceptiontable", b""))
        numbers = (code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_flags)
        names = (code.co_names, code.co_varnames, code.co_freevars, code.co_cellvars)
        self._token("form", f"{numbers} {names}")
        for constant in code.co_consts:
            if isinstance(constant, types.CodeType):
                self._code(constant)
            elif isinstance(constant, frozenset):
                self._token("constant", str(sorted(map(repr, constant))))
            else:
                self._token("constant", repr(constant))

    def _class(self, value: type[Any], place: str) -> None:
        self._token("class", value.__qualname__)
        if _is_installed(value.__module__):
            self._token("package", f"{value.__module__} {_version(value.__module__)}")
            return
        self._all("base", value.__bases__, place)
        for name, each in vars(value).items():
            if name not in _DERIVED:
                self._token("attribute", name)
                self.add(each, f"{place}.{name}")

    def _object(self, value: Any, place: str) -> None:
        """Adds the data of a tensor, or the pickled state of any other object."""
        try:
            if hasattr(value, "detach") and hasattr(value, "cpu"):
                self._array(value.detach().cpu().numpy(), place)
                return
            reduce = copyreg.dispatch_table.get(type(value))
            reduced: Any = value.__reduce_ex__(4) if reduce is None else reduce(value)
        except Exception as error:
            raise _Unidentified(place, value) from error
        if isinstance(reduced, str):
            self._token("name", f"{type(value).__module__}.{reduced}")
            return
        self._token("object", type(value).__qualname__)
        function, arguments, state, *items = (*reduced, None, None, None)[:5]
        self.add(function, place)
        self.add(arguments, place)
        for part in state if isinstance(state, tuple) else (state,):
            if type(part) is dict:
                for name, each in part.items():
                    self._token("attribute", str(name))
                    self.add(each, f"{place}.{name}")
            else:
                self.add(part, place)
        for part in items:
            self._all("item", part or (), place)


def _builtin(digest: _Digest, value: Any, place: str) -> None:
    digest._token("builtin", f"{value.__module__}.{value.__qualname__}")
    if not isinstance(value.__self__, (types.ModuleType, type(None))):
        digest.add(value.__self__, place)


def _parts(*names: str) -> Callable[[_Digest, Any, str], None]:
    """Returns a function that adds some attributes of an object."""

    def add(digest: _Digest, value: Any, place: str) -> None:
        for name in names:
            digest._token(type(value).__name__, name)
            digest.add(getattr(value, name), place)

    return add


#: Functions that add a value, by type; the first match applies.
_BY_TYPE: list[tuple[Any, Callable[[Any, Any, str], None]]] = [
    ((gymnasium.Env, gymnasium.vector.VectorEnv), _Digest._environment),
    (types.ModuleType, _Digest._module),
    (types.FunctionType, _Digest._function),
    (types.MethodType, _parts("__func__", "__self__")),
    (types.BuiltinFunctionType, _builtin),
    (type, _Digest._class),
    (_SLOTS, lambda digest, value, place: digest._token("slot", value.__name__)),
    (property, _parts("fget", "fset", "fdel")),
    ((staticmethod, classmethod), _parts("__func__")),
    (functools.cached_property, _parts("func")),
    ((functools.partial, functools.partialmethod), _parts("func", "args", "keywords")),
    ((list, tuple), _Digest._sequence),
    ((set, frozenset), _Digest._set),
    (dict, _Digest._dict),
    ((np.ndarray, np.generic), _Digest._array),
]


def _cells(function: types.FunctionType) -> Iterator[Any]:
    for cell in function.__closure__ or ():
        try:
            yield cell.cell_contents
        except ValueError:  # not assigned yet
            yield None


def _codes(code: types.CodeType) -> Iterator[types.CodeType]:
    """Yields a code object and the code objects of the functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _codes(constant)


def _named_by(function: types.FunctionType) -> Iterator[tuple[str, Any]]:
    """Yields the global variables that a function refers to, and the attributes of the user's modules that it names."""
    codes = list(_codes(function.__code__))
    words = sorted({name for code in codes for name in code.co_names})
    loads = {"LOAD_GLOBAL": "variable", "LOAD_NAME": "variable", "IMPORT_NAME": "module"}
    found = {
        (loads[each.opname], each.argval)
        for code in codes
        for each in dis.get_instructions(code)
        if each.opname in loads
    }
    for value in _cells(function):
        if isinstance(value, types.ModuleType):
            yield from _attributes_of(value, words)
    for kind, name in sorted(found):
        if kind == "variable":
            if name not in function.__globals__:
                continue  # built in, or not defined yet
            value = function.__globals__[name]
        else:
            try:
                value = importlib.import_module(name)
            except Exception:  # the policy will see
                continue
        yield name, value
        if isinstance(value, types.ModuleType):
            yield from _attributes_of(value, words)


def _attributes_of(module: types.ModuleType, words: list[str]) -> Iterator[tuple[str, Any]]:
    """Yields the attributes of a user's module that have one of these names, and such attributes of its submodules."""
    if _is_installed(module.__name__):
        return
    for word in words:
        if word in vars(module):
            value = vars(module)[word]
            yield f"{module.__name__}.{word}", value
            if isinstance(value, types.ModuleType) and value.__name__.startswith(f"{module.__name__}."):
                yield from _attributes_of(value, words)


def _installed_folders() -> tuple[str, ...]:
    paths = sysconfig.get_paths()
    folders = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    folders += [site.getusersitepackages()]
    return tuple(os.path.realpath(folder) + os.sep for folder in folders)


@functools.cache
def _is_installed(module: str | None) -> bool:
    """Returns whether a module belongs to Python or to an installed package, which its version identifies."""
    top = (module or "__main__").partition(".")[0]
    if top in ("__main__", "building2building"):
        return top != "__main__"
    file = getattr(sys.modules.get(module or ""), "__file__", None)
    if file is None:
        return top in sys.stdlib_module_names
    return os.path.realpath(file).startswith(_installed_folders())


@functools.cache
def _version(module: str) -> str:
    """Returns the version of a module's package; empty if unknown."""
    top = module.partition(".")[0]
    if top in sys.stdlib_module_names:
        return ".".join(map(str, sys.version_info[:2]))
    version = getattr(sys.modules.get(top), "__version__", None)
    if version is None:
        try:
            version = importlib.metadata.version(top)
        except importlib.metadata.PackageNotFoundError:
            version = ""
    return str(version)
