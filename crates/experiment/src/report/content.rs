//! The content of a page.

use b2b_evaluate::report::Chart;
use serde_json::Value;

/// Tables and charts of a page.
#[derive(Default)]
pub(super) struct Content {
    /// Name and value.
    pub(super) tiles: Vec<(String, String)>,
    /// Tables as the page reads them.
    pub(super) tables: Vec<Value>,
    pub(super) charts: Vec<Chart>,
    /// Notes that explain the numbers.
    pub(super) notes: String,
}

/// Explains scores at the bottom of a page.
pub(super) const SCORES: &str = "Score: the return of an episode divided by the tuned reactive controllers' return in the same \
                                 building, task and days; lower is better, and theirs is 1. Resolved score: the same after \
                                 adding 0.2 K of deviation to both, which no thermometer resolves.";
