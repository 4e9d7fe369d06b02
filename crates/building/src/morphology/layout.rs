//! Where the values of nodes are in one buffer.

use std::ops::Range;

use serde::Serialize;

use super::NodeType;

/// The arrays of all node types, one after the other in the order of [`NodeType::ALL`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Layout {
    blocks: [Block; NodeType::ALL.len()],
}

/// The array of one node type, row by row: `[nodes, slots]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Block {
    /// Where it begins.
    pub offset: usize,
    /// Rows: nodes of the type.
    pub nodes: usize,
    /// Columns: slots of each.
    pub slots: usize,
}

impl Block {
    /// Where it is in the buffer.
    pub fn range(&self) -> Range<usize> {
        self.offset..self.offset + self.nodes * self.slots
    }

    /// Where a slot of a node is in the buffer.
    pub fn cell(&self, row: usize, slot: usize) -> usize {
        debug_assert!(row < self.nodes && slot < self.slots);
        self.offset + row * self.slots + slot
    }
}

impl Layout {
    /// A layout with `[nodes, slots]` of each type.
    pub(super) fn new(shape: impl Fn(NodeType) -> [usize; 2]) -> Self {
        let mut offset = 0;
        let blocks = NodeType::ALL.map(|node_type| {
            let [nodes, slots] = shape(node_type);
            let block = Block { offset, nodes, slots };
            offset = block.range().end;
            block
        });
        Self { blocks }
    }

    /// The smallest layout with room for the nodes of each of these: what a batch of different buildings is padded to.
    pub fn covering<'a>(layouts: impl IntoIterator<Item = &'a Self>) -> Self {
        let layouts: Vec<_> = layouts.into_iter().collect();
        Self::new(|node_type| {
            let blocks = || layouts.iter().map(|layout| layout.block(node_type));
            [
                blocks().map(|block| block.nodes).max().unwrap_or(0),
                blocks().map(|block| block.slots).max().unwrap_or(0),
            ]
        })
    }

    /// Where a cell of another layout of the same types is in this one. `None` when it has no room.
    pub fn cell_of(&self, other: &Self, cell: usize) -> Option<usize> {
        let (place, from) =
            self.blocks.iter().zip(&other.blocks).find(|(_, from)| from.range().contains(&cell))?;
        let within = cell - from.offset;
        (place.slots == from.slots && within / from.slots < place.nodes).then(|| place.offset + within)
    }

    /// The array of a type.
    pub fn block(&self, node_type: NodeType) -> Block {
        self.blocks[node_type as usize]
    }

    /// Length of the buffer.
    pub fn len(&self) -> usize {
        self.blocks[NodeType::ALL.len() - 1].range().end
    }

    /// Whether there are no values at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_follow_each_other_and_types_without_nodes_take_no_room() {
        let layout = Layout::new(|node_type| match node_type {
            NodeType::Weather => [1, 2],
            NodeType::VavZone => [3, 4],
            NodeType::UnitaryZone => [0, 5],
            _ => [1, 0],
        });
        assert_eq!(layout.len(), 14);
        assert_eq!(layout.block(NodeType::VavZone).range(), 2..14);
        assert_eq!(layout.block(NodeType::VavZone).cell(2, 3), 13);
        assert!(layout.block(NodeType::UnitaryZone).range().is_empty());
    }
}
