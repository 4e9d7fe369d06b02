//! Gradients of attention.

use b2b_agent::network::graph::{RELATIONS, transpose};

/// The attention of one building in a forward pass.
#[derive(Clone, Copy)]
pub(super) struct Attended<'a> {
    /// Queries, keys and values: nodes × three times the embedding.
    pub projections: &'a [f32],
    /// Weights: heads × nodes × nodes.
    pub weights: &'a [f32],
    /// Edges from the node of each row to the node of each column.
    pub relations: &'a [u8],
    pub heads: usize,
    pub nodes: usize,
}

/// Propagates the gradients of the mixed values, nodes × embedding. Overwrites the gradients of queries, keys and
/// values, and adds to the gradients of the edge scores, heads × kinds, if there are any. `columns` has room for the
/// values of a head and for one number per node.
pub(super) fn backward(
    attended: Attended<'_>,
    gradients: &[f32],
    of_projections: &mut [f32],
    of_edges: &mut [f32],
    columns: &mut [f32],
) {
    let Attended { projections, weights, relations, heads, nodes } = attended;
    let embedding = gradients.len() / nodes;
    let (width, stride) = (embedding / heads, 3 * embedding);
    let scale = 1.0 / (width as f32).sqrt();
    let (values, of_weights) = columns.split_at_mut(width * nodes);
    let of_weights = &mut of_weights[..nodes];
    of_projections.fill(0.0);
    for (head, weights) in weights.chunks_exact(nodes * nodes).enumerate() {
        let first = head * width;
        transpose(projections, stride, 2 * embedding + first, width, values);
        for (node, weights) in weights.chunks_exact(nodes).enumerate() {
            let gradients = &gradients[node * embedding + first..][..width];
            of_weights.fill(0.0);
            for (gradient, values) in gradients.iter().zip(values.chunks_exact(nodes)) {
                of_weights.iter_mut().zip(values).for_each(|(sum, value)| *sum += gradient * value);
            }
            let mean: f32 = of_weights.iter().zip(weights).map(|(gradient, weight)| gradient * weight).sum();
            for (other, weight) in weights.iter().enumerate() {
                let of_score = weight * (of_weights[other] - mean);
                add(of_projections, other * stride + 2 * embedding + first, gradients, *weight);
                let key = &projections[other * stride + embedding + first..][..width];
                add(of_projections, node * stride + first, key, scale * of_score);
                let query = &projections[node * stride + first..][..width];
                add(of_projections, other * stride + embedding + first, query, scale * of_score);
                if !of_edges.is_empty() {
                    let relation = relations[node * nodes + other];
                    let kinds = (0..RELATIONS).filter(|kind| relation & (1 << kind) != 0);
                    kinds.for_each(|kind| of_edges[head * RELATIONS + kind] += of_score);
                }
            }
        }
    }
}

/// Adds values times a factor from a place on.
fn add(sums: &mut [f32], place: usize, values: &[f32], factor: f32) {
    sums[place..].iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}
