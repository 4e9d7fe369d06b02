//! The terms that a task can penalize.

use std::fmt;

use serde::de::{self, Deserialize, Deserializer, Visitor};
use serde::{Serialize, Serializer};

use super::entry::Penalty;
use super::{TERMS, Term};

/// A term that the reward of a task penalizes. Its form in a task is the [`Penalty::word`].
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Resource(Term);

/// Number of terms that a task can penalize.
pub const RESOURCES: usize = {
    let (mut count, mut index) = (0, 0);
    while index < TERMS {
        count += Term::ALL[index].entry().penalty.is_some() as usize;
        index += 1;
    }
    count
};

/// The words of all, in order.
const WORDS: [&str; RESOURCES] = {
    let mut words = [""; RESOURCES];
    let mut index = 0;
    while index < RESOURCES {
        words[index] = Resource::ALL[index].penalty().word;
        index += 1;
    }
    words
};

impl Resource {
    /// HVAC energy, as in the paper.
    pub const ENERGY: Self = Self(Term::Energy);

    /// Energy cost.
    pub const COST: Self = Self(Term::Cost);

    /// All, in the order of the terms.
    pub const ALL: [Self; RESOURCES] = {
        let mut all = [Self::ENERGY; RESOURCES];
        let (mut count, mut index) = (0, 0);
        while index < TERMS {
            if Term::ALL[index].entry().penalty.is_some() {
                all[count] = Self(Term::ALL[index]);
                count += 1;
            }
            index += 1;
        }
        all
    };

    /// Returns the one with a word.
    pub fn of_word(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|resource| resource.penalty().word == word)
    }

    /// Returns the text forms of all, with a weight W: `+energyW, +costW, …`.
    pub fn spelled() -> String {
        WORDS.map(|word| format!("+{word}W")).join(", ")
    }

    /// Returns the term.
    pub const fn term(self) -> Term {
        self.0
    }

    /// Returns how tasks penalize it.
    pub const fn penalty(self) -> &'static Penalty {
        match &self.0.entry().penalty {
            Some(penalty) => penalty,
            None => panic!("only terms with a penalty are resources"),
        }
    }
}

impl Default for Resource {
    fn default() -> Self {
        Self::ENERGY
    }
}

impl fmt::Debug for Resource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.penalty().word)
    }
}

impl Serialize for Resource {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.penalty().word)
    }
}

impl<'de> Deserialize<'de> for Resource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Word;

        impl Visitor<'_> for Word {
            type Value = Resource;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "one of {}", WORDS.join(", "))
            }

            fn visit_str<E: de::Error>(self, word: &str) -> Result<Resource, E> {
                Resource::of_word(word).ok_or_else(|| E::unknown_variant(word, &WORDS))
            }
        }

        deserializer.deserialize_str(Word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_resource_is_its_word() {
        assert_eq!(WORDS, ["energy", "cost", "carbon", "peak"]);
        for resource in Resource::ALL {
            let json = serde_json::to_string(&resource).unwrap();
            assert_eq!(json, format!("{:?}", resource.penalty().word));
            assert_eq!(serde_json::from_str::<Resource>(&json).unwrap(), resource);
        }
        let said = serde_json::from_str::<Resource>("\"watts\"").unwrap_err().to_string();
        assert!(said.contains("unknown variant `watts`, expected one of `energy`, `cost`"), "{said}");
    }
}
