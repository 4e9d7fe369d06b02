"""A building as a graph, with its observation and action as arrays per node type."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import _core
from ..errors import ActionError, need

Array = NDArray[Any]
#: Offset in a buffer, nodes and slots of the array of a node type.
_Block = tuple[int, int, int]


class NodeType(str, Enum):
    """Types of nodes: values of ``node.node_type``, the same in every building."""

    WEATHER = "weather"
    CALENDAR = "calendar"
    ENERGY = "energy"
    AIR_LOOP = "air_loop"
    UNITARY_ZONE = "unitary_zone"
    VAV_ZONE = "vav_zone"
    HEATING_ONLY_ZONE = "heating_only_zone"
    UNCONTROLLED_ZONE = "uncontrolled_zone"
    SETPOINT_ZONE = "setpoint_zone"
    DAMPER_ZONE = "damper_zone"
    FOLLOWING_ZONE = "following_zone"


class SystemKind(str, Enum):
    """Kinds of equipment: values of ``kind`` in ``env.unwrapped.description["systems"]``."""

    UNITARY = "unitary"
    AIR_LOOP = "air_loop"
    HEATING_ONLY = "heating_only"
    ROOM_UNIT = "room_unit"
    SETPOINTS = "setpoints"


class Morphology:
    """A building as a graph over node types that all buildings share, so that one policy can control any building.

    - :attr:`nodes` have ``node_type``, ``name``, ``attributes``, ``owner`` and ``row``, the row in the arrays of their
      type.
    - :attr:`edges` have ``kind`` (``serves``, ``adjacent`` or ``controls``), ``source``, ``target`` and ``attribute``.
    - :meth:`split_observation` and :meth:`join_actions` convert between the environment's vectors and one array
      ``[nodes, slots]`` per node type.
    """

    def __init__(self, core: _core.Morphology):
        self._core = core
        #: Name of the building.
        self.name = core.name
        #: Node types with their ``attributes``, ``observation`` and ``action`` slots.
        self.node_types = {each.name: each for each in core.node_types}
        #: Attributes of the whole building by name; 0 where unknown.
        self.common_attributes = dict(core.common_attributes)
        #: Bounds (low, high) of these attributes, which are the same for every building.
        self.common_attribute_bounds = {each.quantity: (each.low, each.high) for each in core.common_attribute_slots}
        #: Attributes of the whole building by name, scaled from their bounds to [-1, 1] and clipped; 0 where unknown.
        self.scaled_common_attributes = dict(zip(self.common_attributes, core.scaled_common_attributes))
        #: Nodes, ordered by type.
        self.nodes = core.nodes
        #: Edges; an undirected edge is listed once.
        self.edges = core.edges
        self._observation = {name: each.observation_block for name, each in self.node_types.items()}
        self._action = {name: each.action_block for name, each in self.node_types.items()}
        self._action_length = sum(nodes * slots for _, nodes, slots in self._action.values())
        #: Kinds of edges.
        self.edge_kinds = core.edge_kinds()
        #: Number of nodes of each type.
        self.counts = {name: sum(node.node_type == name for node in self.nodes) for name in self.node_types}

    def split_observation(self, observation: ArrayLike) -> dict[str, Array]:
        """Splits an observation into one array f32 ``[nodes, slots]`` per node type; a batch of observations into
        ``[batch, nodes, slots]``. Constant targets are filled in."""
        observation = np.asarray(observation)
        flat = self._core.split(np.atleast_2d(observation))
        return _views(flat, self._observation, observation.ndim == 1)

    def join_actions(self, actions: Mapping[str, ArrayLike]) -> Array:
        """Joins actions per node type, ``[nodes, slots]`` or ``[batch, nodes, slots]``, into actions of the
        environment."""
        expected = {name: block for name, block in self._action.items() if block[1] * block[2]}
        missing = expected.keys() - actions.keys()
        if missing:
            raise ActionError(f"no actions given for {', '.join(sorted(missing))}")
        given = {name: np.asarray(actions[name]) for name in expected}
        single = all(array.ndim == 2 for array in given.values())
        batch = 1 if single else next(iter(given.values())).shape[0]
        flat = np.zeros((batch, self._action_length), dtype=np.float64)
        for name, (offset, nodes, slots) in expected.items():
            shape = (nodes, slots) if single else (batch, nodes, slots)
            if given[name].shape != shape:
                raise ActionError(f"the actions of {name} have shape {given[name].shape}; expected {shape}")
            flat[:, offset : offset + nodes * slots] = given[name].reshape(batch, -1)
        joined = self._core.join(flat)
        return joined[0] if single else joined

    def split_action(self, action: ArrayLike) -> dict[str, Array]:
        """Splits an action or a vector of bounds into one array per node type; the inverse of :meth:`join_actions`."""
        return _views(self._core.split_action(np.asarray(action))[None], self._action, True)

    def attributes(self, node_type: str) -> Array:
        """Returns the attributes of the nodes of a type, ``[nodes, attributes]``."""
        rows = [node.attributes for node in self.nodes if node.node_type == node_type]
        return np.array(rows, dtype=np.float64).reshape(len(rows), len(self.node_types[node_type].attributes))

    def to_networkx(self) -> Any:
        """Returns a ``networkx.MultiDiGraph``, with undirected edges in both directions."""
        networkx = need("networkx", "networkx")
        graph = networkx.MultiDiGraph(name=self.name, **self.common_attributes)
        for number, node in enumerate(self.nodes):
            names = [slot.quantity for slot in self.node_types[node.node_type].attributes]
            attributes = dict(zip(names, node.attributes))
            graph.add_node(number, name=node.name, node_type=node.node_type, **attributes)
        for kind, source, target, attribute in self.directed_edges():
            graph.add_edge(source, target, kind=kind, attribute=attribute)
        return graph

    def to_pyg(self) -> dict[str, Any]:
        """Returns arrays in the layout of PyTorch Geometric's ``HeteroData``: ``x[type]`` (attributes),
        ``edge_index[source type, kind, target type]`` (two rows of row numbers) and ``edge_attr``. Undirected edges
        are included in both directions."""
        edges: dict[tuple[str, str, str], list[tuple[int, int, float]]] = {}
        for kind, source, target, attribute in self.directed_edges():
            a, b = self.nodes[source], self.nodes[target]
            edges.setdefault((a.node_type, kind, b.node_type), []).append((a.row, b.row, attribute))
        present = [name for name, count in self.counts.items() if count]
        return {
            "x": {name: self.attributes(name).astype(np.float32) for name in present},
            "edge_index": {key: np.array([edge[:2] for edge in each]).T for key, each in edges.items()},
            "edge_attr": {key: np.array([[edge[2]] for edge in each], dtype=np.float32) for key, each in edges.items()},
        }

    def directed_edges(self) -> Iterator[tuple[str, int, int, float]]:
        """Yields kind, source, target and attribute of every edge; undirected edges in both directions."""
        for kind in self.edge_kinds:
            edges = [edge for edge in self.edges if edge.kind == kind]
            for edge in edges:
                yield kind, edge.source, edge.target, edge.attribute
            for edge in edges:
                if not edge.directed:
                    yield kind, edge.target, edge.source, edge.attribute

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {name}" for name, count in self.counts.items() if count)
        return f"<Morphology of {self.name}: {counts}; {len(self.edges)} edges>"


class Metadata(dict[str, Any]):
    """The metadata of an environment. ``["morphology"]`` is computed when it is read, and is not pickled."""

    def __init__(self, values: Mapping[str, Any], morphology: Callable[[], _core.Morphology]):
        super().__init__(values)
        self._compute = morphology
        self._morphology: Morphology | None = None

    def __missing__(self, name: str) -> Morphology:
        if name != "morphology":
            raise KeyError(name)
        if self._morphology is None:
            self._morphology = Morphology(self._compute())
        return self._morphology

    def __contains__(self, name: object) -> bool:
        return name == "morphology" or super().__contains__(name)

    def get(self, name: str, default: Any = None) -> Any:
        return self[name] if name in self else default

    def __or__(self, others: Mapping[str, Any]) -> Metadata:  # type: ignore[override]
        return Metadata({**self, **others}, self._compute)

    def __reduce__(self) -> tuple[Any, ...]:
        return dict, (dict(self),)


def _views(flat: Array, blocks: dict[str, _Block], single: bool) -> dict[str, Array]:
    views = {}
    for name, (offset, nodes, slots) in blocks.items():
        if nodes and slots:
            array = flat[:, offset : offset + nodes * slots].reshape(-1, nodes, slots)
            views[name] = array[0] if single else array
    return views
