//! Layout of the values of nodes in one buffer.

use std::ops::Range;

use serde::Serialize;

use super::NodeType;

/// The arrays of all node types, one after the other in the order of [`NodeType::ALL`].
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Layout {
    blocks: [Block; NodeType::ALL.len()],
}

/// The array of a node type, row-major: `[nodes, slots]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Block {
    /// Offset of its first value.
    pub offset: usize,
    /// Rows: nodes of the type.
    pub nodes: usize,
    /// Columns: slots of a node.
    pub slots: usize,
}

impl Block {
    /// Returns its range in the buffer.
    pub fn range(&self) -> Range<usize> {
        self.offset..self.offset + self.nodes * self.slots
    }

    /// Returns the offset of a slot of a node.
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

    /// Returns the smallest layout with room for the nodes of each of these, to which a batch of different buildings is
    /// padded.
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

    /// Returns the offset of a value of another layout in this one; `None` if there is no room.
    pub fn cell_of(&self, other: &Self, cell: usize) -> Option<usize> {
        let (place, from) =
            self.blocks.iter().zip(&other.blocks).find(|(_, from)| from.range().contains(&cell))?;
        let within = cell - from.offset;
        (place.slots == from.slots && within / from.slots < place.nodes).then(|| place.offset + within)
    }

    /// Returns the array of a type.
    pub fn block(&self, node_type: NodeType) -> Block {
        self.blocks[node_type as usize]
    }

    /// Returns the length of the buffer.
    pub fn len(&self) -> usize {
        self.blocks[NodeType::ALL.len() - 1].range().end
    }

    /// Returns whether the buffer is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_are_contiguous_and_types_without_nodes_are_empty() {
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
