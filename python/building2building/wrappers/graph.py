"""Observations as ``gymnasium.spaces.Graph``."""

from __future__ import annotations

import numpy as np
from gymnasium.spaces import Box, Graph, GraphInstance
from numpy.typing import NDArray

from ..env.layers import is_own
from ..env.morphology import Morphology
from ..errors import SettingError
from .observation_wrapper import Array, Env, ObservationWrapper

Floats = NDArray[np.float32]


class GraphObservation(ObservationWrapper):
    """Observes the building as a graph in a ``gymnasium.spaces.Graph`` that is the same for every building of a task.

    A row of ``nodes`` has a column for each node type, 1 for its own, and then for each node type the columns of its
    attributes and observation slots, 0 in nodes of other types (:attr:`node_columns`). A row of ``edges`` has a column
    for each kind (:attr:`edge_columns`) and the attribute; undirected edges are included in both directions.
    Attributes and edges do not change in an episode; unknown attributes are 0.

    Actions stay the environment's: :meth:`Morphology.join_actions` joins actions by node.
    """

    def __init__(self, env: Env):
        super().__init__(env)
        self._update()

    def _read(self) -> None:
        if not is_own(self.env):
            raise SettingError(f"{self.env} has changed the slots of the observation; wrap with GraphObservation first")
        graph = self._graph = self._core.morphology
        #: Names of the columns of a node.
        self.node_columns = list(graph.node_types)
        #: Names of the columns of an edge.
        self.edge_columns = [*graph.edge_kinds, "attribute"]
        self._nodes, self._observed = self._fixed_nodes(graph)
        edges = list(graph.directed_edges())
        self._links = np.array([edge[1:3] for edge in edges], dtype=np.int32).reshape(-1, 2)
        self._edges = np.zeros((len(edges), len(self.edge_columns)), dtype=np.float32)
        for row, (kind, _, _, attribute) in zip(self._edges, edges):
            row[graph.edge_kinds.index(kind)] = 1
            row[-1] = attribute

        def unbounded(columns: list[str]) -> Box:
            return Box(-np.inf, np.inf, (len(columns),), dtype=np.float32)

        self.observation_space = Graph(unbounded(self.node_columns), unbounded(self.edge_columns))

    def _fixed_nodes(self, graph: Morphology) -> tuple[Floats, dict[str, tuple[slice, slice]]]:
        """Returns the nodes without observations, and where the observations of each type go: its rows and columns."""
        observed = {}
        blocks = []
        first = 0
        for number, (name, node_type) in enumerate(graph.node_types.items()):
            rows = slice(first, first + graph.counts[name])
            first = rows.stop
            start = len(self.node_columns)
            self.node_columns += [f"{name} {slot.quantity}" for slot in (*node_type.attributes, *node_type.observation)]
            blocks.append((number, rows, start, np.nan_to_num(graph.attributes(name))))
            observed[name] = rows, slice(start + len(node_type.attributes), len(self.node_columns))
        nodes = np.zeros((first, len(self.node_columns)), dtype=np.float32)
        for number, rows, start, attributes in blocks:
            nodes[rows, number] = 1
            nodes[rows, start : start + attributes.shape[1]] = attributes
        return nodes, observed

    def observation(self, observation: Array) -> GraphInstance:  # type: ignore[override]
        nodes = self._nodes.copy()
        for name, values in self._graph.split_observation(observation).items():
            rows, columns = self._observed[name]
            nodes[rows, columns] = values
        return GraphInstance(nodes, self._edges.copy(), self._links.copy())
