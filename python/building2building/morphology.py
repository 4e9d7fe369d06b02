"""A building as a graph, with its vectors as arrays of the nodes."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from .errors import ActionError, need


class Morphology:
    """A graph over one vocabulary for all buildings, so that one policy can drive buildings of any type.

    - :attr:`nodes`: dictionaries with ``node_type``, ``name``, ``attributes``, ``row`` (in the type's array).
    - :attr:`edges`: dictionaries with ``kind`` (``serves``, ``adjacent``, ``controls``), ``from``, ``to``,
      ``attribute``.
    - :meth:`split_observation` and :meth:`join_actions` go between vectors and arrays ``[nodes, slots]``, one a type.
    """

    def __init__(self, core):
        self._core = core
        data = json.loads(core.to_json())
        graph, universe = data["graph"], data["universe"]
        #: Name of the building.
        self.name: str = graph["name"]
        #: The types with their ``attributes``, ``observation`` and ``action``: lists of quantity, unit, low, high.
        self.node_types: dict[str, dict[str, Any]] = {each["node_type"]: each for each in universe["node_types"]}
        #: Attributes of the whole building, by name.
        self.common_attributes: dict[str, float] = {
            slot["quantity"]: value for slot, value in zip(universe["common_attributes"], graph["common_attributes"])
        }
        self.nodes: list[dict[str, Any]] = graph["nodes"]
        self.edges: list[dict[str, Any]] = graph["edges"]
        names = list(self.node_types)
        self._observation = dict(zip(names, data["observation"]))
        self._action = dict(zip(names, data["action"]))
        self._lengths = [sum(nodes * slots for _, nodes, slots in data[each]) for each in ("observation", "action")]
        counts = dict.fromkeys(names, 0)
        for node in self.nodes:
            node["row"] = counts[node["node_type"]]
            counts[node["node_type"]] += 1
        #: How many nodes of each type there are.
        self.counts: dict[str, int] = counts

    def split_observation(self, observation) -> dict[str, np.ndarray]:
        """The observation of each node: by type, f32 of shape ``[nodes, slots]``; of a batch of observations,
        ``[batch, nodes, slots]``. Targets that never move are filled in."""
        observation = np.asarray(observation)
        flat = self._core.split(np.atleast_2d(observation))
        return self._views(flat, self._observation, observation.ndim == 1)

    def join_actions(self, actions: dict[str, np.ndarray]) -> np.ndarray:
        """The action of actions of the nodes: by type, of shape ``[nodes, slots]`` or ``[batch, nodes, slots]``."""
        wanted = {name: block for name, block in self._action.items() if block[1] * block[2]}
        missing = wanted.keys() - actions.keys()
        if missing:
            raise ActionError(f"there are no actions of {', '.join(sorted(missing))}")
        given = {name: np.asarray(actions[name]) for name in wanted}
        one = all(array.ndim == 2 for array in given.values())
        batch = 1 if one else next(iter(given.values())).shape[0]
        flat = np.zeros((batch, self._lengths[1]), dtype=np.float64)
        for name, (offset, nodes, slots) in wanted.items():
            shape = given[name].shape
            if shape != ((nodes, slots) if one else (batch, nodes, slots)):
                raise ActionError(f"the actions of {name} are of shape {shape}, and must end with ({nodes}, {slots})")
            flat[:, offset : offset + nodes * slots] = given[name].reshape(batch, -1)
        joined = self._core.join(flat)
        return joined[0] if one else joined

    def split_action(self, action) -> dict[str, np.ndarray]:
        """The actions, or bounds, of each node; undoes :meth:`join_actions`."""
        return self._views(self._core.split_action(np.asarray(action))[None], self._action, True)

    @staticmethod
    def _views(flat, blocks, one):
        views = {}
        for name, (offset, nodes, slots) in blocks.items():
            if nodes and slots:
                array = flat[:, offset : offset + nodes * slots].reshape(-1, nodes, slots)
                views[name] = array[0] if one else array
        return views

    def attributes(self, node_type: str) -> np.ndarray:
        """Attributes of the nodes of a type, ``[nodes, attributes]``."""
        rows = [node["attributes"] for node in self.nodes if node["node_type"] == node_type]
        return np.array(rows, dtype=np.float64).reshape(len(rows), -1)

    def to_networkx(self):
        """As a ``networkx.MultiDiGraph``; an edge without direction is there both ways."""
        networkx = need("networkx", "networkx")
        graph = networkx.MultiDiGraph(name=self.name, **self.common_attributes)
        for number, node in enumerate(self.nodes):
            slots = [slot["quantity"] for slot in self.node_types[node["node_type"]]["attributes"]]
            attributes = dict(zip(slots, node["attributes"]))
            graph.add_node(number, name=node["name"], node_type=node["node_type"], **attributes)
        for kind, ends, values in self._relations():
            for source, target, value in zip(*ends, values):
                graph.add_edge(int(source), int(target), kind=kind, attribute=float(value))
        return graph

    def to_pyg(self) -> dict[str, Any]:
        """Arrays as PyTorch Geometric's ``HeteroData`` has them: ``x[type]`` (attributes), ``edge_index[(from type,
        kind, to type)]`` (2 rows: rows of the nodes in their types) and ``edge_attr``. No edge without direction is
        lost: it is there both ways."""
        index: dict[tuple, list] = {}
        for kind, ends, values in self._relations():
            for source, target, value in zip(*ends, values):
                a, b = self.nodes[source], self.nodes[target]
                key = (a["node_type"], kind, b["node_type"])
                index.setdefault(key, []).append((a["row"], b["row"], value))
        present = [name for name, count in self.counts.items() if count]
        return {
            "x": {name: self.attributes(name).astype(np.float32) for name in present},
            "edge_index": {key: np.array([edge[:2] for edge in edges]).T for key, edges in index.items()},
            "edge_attr": {
                key: np.array([[edge[2]] for edge in edges], dtype=np.float32) for key, edges in index.items()
            },
        }

    def _relations(self):
        for kind in ("serves", "adjacent", "controls"):
            edges = [edge for edge in self.edges if edge["kind"] == kind]
            both = edges + [{**edge, "from": edge["to"], "to": edge["from"]} for edge in edges]
            listed = both if kind == "adjacent" else edges
            ends = [edge["from"] for edge in listed], [edge["to"] for edge in listed]
            yield kind, ends, [edge["attribute"] for edge in listed]

    def __repr__(self) -> str:
        counts = ", ".join(f"{count} {name}" for name, count in self.counts.items() if count)
        return f"<Morphology of {self.name}: {counts}; {len(self.edges)} edges>"
