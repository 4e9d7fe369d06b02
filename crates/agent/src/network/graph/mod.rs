//! Graph networks: one network for buildings of every shape, as in the paper's appendix on cross-domain transfer (after
//! Amorpheus, Kurin et al. 2021).
//!
//! 1. A linear encoder per node type maps the features of each node to the embedding.
//! 2. A transformer (pre-norm, no causal mask) lets every node attend to every other, or only along [`Edges`].
//! 3. With a memory, a gated recurrent unit that all nodes share maps the embedding of each node to its next state.
//! 4. A linear decoder per node type maps the embedding or the state of each node to its outputs.
//!
//! A [`GraphNetwork`] covers all node types; a [`Graph`] is one building. A batch may mix buildings: their nodes are
//! one list of tokens without padding, and only attention separates the buildings ([`Tape::forward`]).

mod attention;
mod buffer;
mod forward;
mod layer_norm;
mod network;
mod places;
mod topology;

pub use attention::{EdgeScores, attend, transpose};
pub use buffer::sized;
pub(crate) use forward::LARGEST;
pub use forward::{Batch, BlockTape, Linear, Span, Tape};
pub(crate) use layer_norm::EPSILON;
pub use layer_norm::{NormTape, lane_sum};
pub use network::{Edges, GraphNetwork, NodeWidths};
pub use places::{BlockPlaces, EncoderPlaces, MemoryPlaces, NormPlaces, Places};
pub use topology::{ActionPlace, Graph, REACHES, RELATIONS};
