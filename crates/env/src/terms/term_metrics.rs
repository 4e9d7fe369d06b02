//! The terms in the metrics of an episode.

use std::fmt;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::{TERMS, Term, Totals};

/// The totals of the terms with a column, in the units of the columns. An episode from before a term was added to the
/// list does not have it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TermMetrics([Option<f64>; TERMS]);

impl TermMetrics {
    /// Returns the value of a term, in the unit of its column; `None` if it is unknown.
    pub fn get(&self, term: Term) -> Option<f64> {
        self.0[term as usize]
    }

    /// Sets the value of a term, in the unit of its column.
    pub fn set(&mut self, term: Term, value: f64) {
        self.0[term as usize] = Some(value);
    }

    fn known(&self) -> impl Iterator<Item = (Term, f64)> {
        Term::ALL.into_iter().filter_map(|term| Some((term, self.get(term)?)))
    }
}

impl From<&Totals> for TermMetrics {
    fn from(totals: &Totals) -> Self {
        let of = |term: Term| Some(totals.of(term) / term.entry().column.as_ref()?.divisor);
        Self(Term::ALL.map(of))
    }
}

/// A map from the names of the terms that are known.
impl Serialize for TermMetrics {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.known().map(|(term, value)| (term.entry().name, value)))
    }
}

/// Ignores all other names, so that it can be flattened into a record.
impl<'de> Deserialize<'de> for TermMetrics {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Named;

        impl<'de> Visitor<'de> for Named {
            type Value = TermMetrics;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("numbers by the names of terms")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TermMetrics, A::Error> {
                let mut metrics = TermMetrics::default();
                let with_column = |name: &str| {
                    let mut terms = Term::ALL.into_iter().filter(|term| term.entry().column.is_some());
                    terms.find(|term| term.entry().name == name)
                };
                while let Some(name) = map.next_key::<String>()? {
                    match with_column(&name) {
                        Some(term) => metrics.set(term, map.next_value()?),
                        None => _ = map.next_value::<IgnoredAny>()?,
                    }
                }
                Ok(metrics)
            }
        }

        deserializer.deserialize_map(Named)
    }
}
