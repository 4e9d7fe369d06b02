//! Episodes that a memory spans.

/// Counts the consecutive episodes in a building that a memory spans.
#[derive(Clone, Copy, Debug)]
pub struct MemorySpan {
    /// All if `None`.
    episodes: Option<u32>,
    /// Episodes begun with the current memory.
    begun: u32,
}

impl MemorySpan {
    /// Key of the number of episodes in the metadata of an ONNX file.
    pub const KEY: &str = "memory_episodes";

    /// Creates the count of an empty memory; `None` spans all episodes.
    pub fn new(episodes: Option<u32>) -> Self {
        Self { episodes, begun: 1 }
    }

    /// Begins the first episode of an empty memory.
    pub fn reset(&mut self) {
        self.begun = 1;
    }

    /// Begins the next episode. Returns whether it begins with an empty memory.
    pub fn next_episode(&mut self) -> bool {
        let is_spent = self.episodes.is_some_and(|episodes| self.begun >= episodes);
        self.begun = if is_spent { 1 } else { self.begun.saturating_add(1) };
        is_spent
    }
}
