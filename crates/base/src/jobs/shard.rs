//! A part of a list of jobs, for job arrays.

use std::str::FromStr;

use serde::Deserialize;
use thiserror::Error;

/// Text that is not a shard.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("invalid shard `{text}`; expected I/N with I from 0 to N - 1, such as 0/3")]
pub struct InvalidShard {
    text: String,
}

/// Part `index` of `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// All jobs.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Returns whether a job belongs to the part, by its number.
    pub fn contains(self, number: usize) -> bool {
        number % self.count == self.index
    }
}

impl FromStr for Shard {
    type Err = InvalidShard;

    fn from_str(text: &str) -> Result<Self, InvalidShard> {
        let parsed = text.split_once('/').and_then(|(index, count)| {
            let shard = Self { index: index.parse().ok()?, count: count.parse().ok()? };
            (shard.index < shard.count).then_some(shard)
        });
        parsed.ok_or_else(|| InvalidShard { text: text.to_owned() })
    }
}

impl TryFrom<String> for Shard {
    type Error = InvalidShard;

    fn try_from(text: String) -> Result<Self, InvalidShard> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_belongs_to_one_shard() {
        let shards: Vec<Shard> = ["0/3", "1/3", "2/3"].map(|text| text.parse().unwrap()).into();
        for number in 0..10 {
            assert_eq!(shards.iter().filter(|shard| shard.contains(number)).count(), 1);
            assert!(Shard::WHOLE.contains(number));
        }
    }

    #[test]
    fn other_text_is_refused() {
        for text in ["3/3", "1", "a/b", "1/0", "-1/2"] {
            assert!(text.parse::<Shard>().unwrap_err().to_string().contains(text));
        }
    }
}
