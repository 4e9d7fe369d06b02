//! A person and their hours away from home.

use rand_chacha::ChaCha8Rng;

use super::{Absence, is_weekend};
use b2b_base::random::{standard_normal, uniform};

/// What a person does on weekdays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Occupation {
    /// Works full time.
    FullTime,
    /// Works part time.
    PartTime,
    /// Goes to school, college or day care.
    Student,
    /// Retired, or mostly at home for another reason.
    AtHome,
}

/// Shares of adults under retirement: in Québec 79 % of the 25 to 64-year-olds were employed in 2021 (census), a sixth
/// of them part time; the rest are at home.
const ADULTS: [(Occupation, f64); 2] = [(Occupation::FullTime, 0.68), (Occupation::PartTime, 0.14)];

impl Occupation {
    /// Returns the occupation at a quantile of the adults under retirement.
    pub(super) fn of_adult(quantile: f64) -> Self {
        let mut rest = quantile;
        for (occupation, share) in ADULTS {
            if rest < share {
                return occupation;
            }
            rest -= share;
        }
        Self::AtHome
    }
}

/// A person with habitual hours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Person {
    occupation: Occupation,
    /// Hour of leaving home for work or school.
    leaves: f64,
    /// Hours away, travel included.
    away: f64,
}

/// Normal distributions of the hour of leaving and of the hours away: mean and standard deviation. ATUS 2012: 8.0 hours
/// of work on a weekday; the rest is travel and lunch. The others are engineering judgment.
const FULL_TIME: [[f64; 2]; 2] = [[7.5, 1.0], [9.6, 1.1]];
const PART_TIME: [[f64; 2]; 2] = [[9.0, 1.6], [6.0, 1.2]];
const STUDENT: [[f64; 2]; 2] = [[7.8, 0.4], [8.5, 1.1]];
/// Share of the full-time workers who work from the afternoon to the late evening, and their hours.
const LATE_SHIFT: f64 = 0.08;
const LATE: [[f64; 2]; 2] = [[14.5, 0.5], [8.5, 0.5]];
/// Earliest hour of leaving (engineering judgment; the night shift is left out).
const EARLIEST: f64 = 5.0;
/// Deviation of a day from the habit, h.
const JITTER: f64 = 0.25;

/// Share of days on which a full-time worker goes to work (ATUS 2012, without work at home).
const WORKDAY: f64 = 0.83;
const WEEKEND_WORK: f64 = 0.20;

impl Person {
    pub(super) fn draw(occupation: Occupation, random: &mut ChaCha8Rng) -> Self {
        let late = uniform(random) < LATE_SHIFT;
        let [leaves, away] = match occupation {
            Occupation::FullTime if late => LATE,
            Occupation::FullTime => FULL_TIME,
            Occupation::PartTime => PART_TIME,
            Occupation::Student | Occupation::AtHome => STUDENT,
        }
        .map(|[mean, deviation]| mean + deviation * standard_normal(random));
        Self { occupation, leaves, away }
    }

    /// Draws the absences of a day.
    pub(super) fn day(&self, day: usize, random: &mut ChaCha8Rng) -> Vec<Absence> {
        let duty = self.duty(day, random);
        let leisure = self.leisure(day, duty.is_some(), random);
        duty.into_iter().chain(leisure).collect()
    }

    /// Work or school.
    fn duty(&self, day: usize, random: &mut ChaCha8Rng) -> Option<Absence> {
        let goes = uniform(random) < self.share_of_days(day);
        let [leaves, away] = [self.leaves, self.away].map(|habit| habit + JITTER * standard_normal(random));
        goes.then(|| Absence::new(leaves.max(EARLIEST), away))
    }

    /// Share of such days with work or school.
    fn share_of_days(&self, day: usize) -> f64 {
        match (self.occupation, is_weekend(day)) {
            (Occupation::FullTime, false) => WORKDAY,
            (Occupation::FullTime, true) => WEEKEND_WORK,
            (Occupation::PartTime, false) => 0.6,
            (Occupation::PartTime, true) => 0.25,
            (Occupation::Student, false) => 0.95,
            (Occupation::Student, true) | (Occupation::AtHome, _) => 0.0,
        }
    }

    /// Errands by day and evenings out. Days without work or school have more errands.
    fn leisure(&self, day: usize, has_duty: bool, random: &mut ChaCha8Rng) -> Vec<Absence> {
        let [errand, start, length, evening, late, hours] = [(); 6].map(|()| uniform(random));
        let weekend = is_weekend(day);
        let mut absences = Vec::new();
        if !has_duty && errand < if weekend { 0.65 } else { 0.78 } {
            absences.push(Absence::new(8.0 + 7.0 * start, 1.5 + 5.0 * length));
        }
        if evening < if weekend { 0.30 } else { 0.25 } {
            absences.push(Absence::new(17.0 + 2.5 * late, 1.5 + 4.0 * hours));
        }
        absences
    }
}
