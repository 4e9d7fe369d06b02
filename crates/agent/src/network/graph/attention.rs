//! Attention between the nodes of one building.

use super::topology::{REACHES, RELATIONS};
use crate::network::exp;

/// The contribution of a building's edges to the attention scores.
#[derive(Clone, Copy, Debug)]
pub struct EdgeScores<'a> {
    /// Edges from the node of each row to the node of each column, nodes × nodes.
    pub relations: &'a [u8],
    /// Score of each kind of edge, heads × kinds; empty without edge scores.
    pub scores: &'a [f32],
    /// Whether a node attends only along edges.
    pub mask: bool,
}

/// Transposes `width` columns of a matrix, from `first` on.
pub fn transpose(rows: &[f32], stride: usize, first: usize, width: usize, columns: &mut [f32]) {
    let count = rows.len() / stride;
    for (row, values) in rows.chunks_exact(stride).enumerate() {
        for (column, value) in values[first..first + width].iter().enumerate() {
            columns[column * count + row] = *value;
        }
    }
}

/// Computes the attention of the nodes of a building (Vaswani et al. 2017, eq. 1): from queries, keys and values, nodes
/// × three times the embedding, the weights, heads × nodes × nodes, and the mixed values, nodes × embedding. `keys` is
/// a buffer for the keys of a head.
pub fn attend(
    projections: &[f32],
    heads: usize,
    edges: EdgeScores<'_>,
    weights: &mut [f32],
    mixed: &mut [f32],
    keys: &mut [f32],
) {
    let nodes = ((weights.len() / heads) as f64).sqrt() as usize;
    let embedding = mixed.len() / nodes;
    let (width, stride) = (embedding / heads, 3 * embedding);
    let scale = 1.0 / (width as f32).sqrt();
    mixed.fill(0.0);
    for (head, weights) in weights.chunks_exact_mut(nodes * nodes).enumerate() {
        let (first, keys) = (head * width, &mut keys[..width * nodes]);
        transpose(projections, stride, embedding + first, width, keys);
        for (node, weights) in weights.chunks_exact_mut(nodes).enumerate() {
            weights.fill(0.0);
            let queries = &projections[node * stride + first..][..width];
            for (query, keys) in queries.iter().zip(keys.chunks_exact(nodes)) {
                weights.iter_mut().zip(keys).for_each(|(sum, key)| *sum += query * scale * key);
            }
            edges.add(head, &edges.relations[node * nodes..][..nodes], weights);
            softmax(weights);
            let mixed = &mut mixed[node * embedding + first..][..width];
            for (other, weight) in weights.iter().enumerate() {
                let values = &projections[other * stride + 2 * embedding + first..][..width];
                mixed.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
            }
        }
    }
}

impl EdgeScores<'_> {
    /// Adds the edge scores of a node to its attention scores; -∞ where it does not attend.
    pub(crate) fn add(&self, head: usize, relations: &[u8], scores: &mut [f32]) {
        if !self.scores.is_empty() {
            let of_kind = &self.scores[head * RELATIONS..][..RELATIONS];
            for (score, relation) in scores.iter_mut().zip(relations) {
                let kinds = (0..RELATIONS).filter(|kind| relation & (1 << kind) != 0);
                *score += kinds.map(|kind| of_kind[kind]).sum::<f32>();
            }
        }
        if self.mask {
            for (score, relation) in scores.iter_mut().zip(relations) {
                if relation & REACHES == 0 {
                    *score = f32::NEG_INFINITY;
                }
            }
        }
    }
}

/// Replaces scores by their softmax; 0 for a score of -∞.
fn softmax(scores: &mut [f32]) {
    let highest = scores.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let mut sum = 0.0;
    for score in &mut *scores {
        *score = if *score == f32::NEG_INFINITY { 0.0 } else { exp(*score - highest) };
        sum += *score;
    }
    let factor = 1.0 / sum;
    scores.iter_mut().for_each(|score| *score *= factor);
}
