//! One value for each term: of a step, and of an episode.

use std::ops::{Index, IndexMut};

use serde::{Deserialize, Serialize};

use super::entry::Total;
use super::{TERMS, Term};

/// The terms of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Amounts([f64; TERMS]);

/// The terms of an episode so far, accumulated by each term's own rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals(Amounts);

impl Amounts {
    /// Computes each term.
    pub fn of(value: impl Fn(Term) -> f64) -> Self {
        Self(Term::ALL.map(value))
    }

    /// The values in the order of [`Term::ALL`].
    pub fn values(&self) -> &[f64; TERMS] {
        &self.0
    }
}

impl From<[f64; TERMS]> for Amounts {
    fn from(values: [f64; TERMS]) -> Self {
        Self(values)
    }
}

impl Index<Term> for Amounts {
    type Output = f64;

    fn index(&self, term: Term) -> &f64 {
        &self.0[term as usize]
    }
}

impl IndexMut<Term> for Amounts {
    fn index_mut(&mut self, term: Term) -> &mut f64 {
        &mut self.0[term as usize]
    }
}

impl Totals {
    /// Adds a step.
    pub(crate) fn add(&mut self, step: &Amounts) {
        for term in Term::ALL {
            let total = &mut self.0[term];
            match term.entry().total {
                Total::Sum => *total += step[term],
                Total::Max => *total = total.max(step[term]),
                Total::Of(_) => {}
            }
        }
    }

    /// Returns the total of a term, in the unit of its steps.
    pub fn of(&self, term: Term) -> f64 {
        match term.entry().total {
            Total::Of(follow) => follow(self),
            Total::Sum | Total::Max => self.0[term],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_accumulate_as_the_list_says() {
        let mut totals = Totals::default();
        for number in [1.0, 2.0] {
            totals.add(&Amounts::of(|_| number));
        }
        let max = |term: &Term| matches!(term.entry().total, Total::Max);
        assert_eq!(totals.of(Term::Cost), 3.0);
        assert_eq!(totals.of(Term::ALL.into_iter().find(max).unwrap()), 2.0);
        assert_eq!(totals.of(Term::Energy), 6.0, "electricity and gas");
    }
}
