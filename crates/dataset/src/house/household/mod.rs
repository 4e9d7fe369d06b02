//! The people of a house and when they are at home.
//!
//! 1. A household has an integer number of people: workers, students and people who are mostly at home.
//! 2. Each person has work or school at habitual hours, days off, days of work from home, errands and evenings out,
//!    some together with others.
//! 3. [`Household::at_home`] counts the people at home in each quarter of an hour. Everyone spends the night at home.
//!
//! The week repeats: the same household has the same Tuesday all year.
//!
//! # Source
//! The share of homes with everyone out has been published by hour, number of residents, and weekday or weekend from
//! time-use diaries kept by every member of a household: McKenna, Krawczynski and Thomson, "Four-state domestic
//! building occupancy model for energy demand simulations", Energy and Buildings 96 (2015), from the UK Time Use Survey
//! 2000; the model's starting states and transition probabilities give the shares, which the tests compare with the
//! households. The time-use surveys of Canada (GSS) and of the United States (ATUS) interview one person of each
//! household, and cannot tell when all are out. ATUS 2012 gives the workers' days: 83 % of the employed work on a
//! weekday, for 8.0 hours, and 34 % on a weekend day; 23 % of workers do some of it at home. The occupations by
//! household size, and the errands and evenings out that reproduce the shares, are engineering judgment.

mod person;

use rand_chacha::ChaCha8Rng;

use b2b_base::random::{stream, uniform};
use person::{Occupation, Person};

/// Days of a week, Monday first.
pub(super) const DAYS: usize = 7;
/// Quarters of an hour in a day.
pub(super) const QUARTERS: usize = 96;
/// Name of the random stream.
const STREAM: &str = "household";

/// The people of a house and their week.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Household {
    people: u32,
    at_home: Vec<[u32; QUARTERS]>,
}

/// A time out: first quarter of an hour, and the first one back at home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Absence {
    from: usize,
    to: usize,
}

impl Absence {
    /// Creates an absence from its first hour and duration, limited to the day.
    fn new(from: f64, hours: f64) -> Self {
        let quarter = |hour: f64| (4.0 * hour).round().clamp(0.0, QUARTERS as f64) as usize;
        Self { from: quarter(from), to: quarter(from + hours) }
    }
}

impl Household {
    /// Draws a household of a number of people. The same number and seed give the same week.
    pub fn draw(people: u32, seed: u64) -> Self {
        let mut random = stream(STREAM, seed, u64::from(people));
        let persons = members(people, &mut random);
        let at_home = (0..DAYS).map(|day| count_day(&persons, day, &mut random)).collect();
        Self { people, at_home }
    }

    /// Returns the number of people.
    pub fn people(&self) -> u32 {
        self.people
    }

    /// Returns the number of people at home on a day (Monday is 0) by quarter of an hour.
    ///
    /// # Panics
    /// When the day is not from 0 to 6.
    pub fn at_home(&self, day: usize) -> &[u32] {
        &self.at_home[day]
    }
}

/// Draws the people: adults (all retired, or each working or not) and students.
fn members(people: u32, random: &mut ChaCha8Rng) -> Vec<Person> {
    let retired = uniform(random) < share_retired(people);
    (0..people)
        .map(|index| {
            let child = index >= 2 && uniform(random) < STUDENTS;
            let occupation = match (retired, child) {
                (true, _) => Occupation::AtHome,
                (false, true) => Occupation::Student,
                (false, false) => Occupation::of_adult(uniform(random)),
            };
            Person::draw(occupation, random)
        })
        .collect()
}

/// Share of the third and further members who go to school or college.
const STUDENTS: f64 = 0.85;

/// Share of households whose adults are all retired. In Québec 21 % of the people are 65 or older (census of 2021), and
/// most of them live alone or as couples; the shares by size are engineering judgment.
fn share_retired(people: u32) -> f64 {
    match people {
        0 | 1 => 0.35,
        2 => 0.30,
        _ => 0.03,
    }
}

/// Counts the people at home on a day.
fn count_day(persons: &[Person], day: usize, random: &mut ChaCha8Rng) -> [u32; QUARTERS] {
    let together = outings_together(persons.len(), day, random);
    let mut at_home = [0; QUARTERS];
    for person in persons {
        let mut absences = person.day(day, random);
        absences.extend(&together);
        for (quarter, count) in at_home.iter_mut().enumerate() {
            let is_out = absences.iter().any(|absence| (absence.from..absence.to).contains(&quarter));
            *count += u32::from(!is_out);
        }
    }
    at_home
}

/// Draws the outings of the whole household: by day and in the evening.
fn outings_together(people: usize, day: usize, random: &mut ChaCha8Rng) -> Vec<Absence> {
    let [goes, start, length, evening, late, hours] = [(); 6].map(|()| uniform(random));
    let mut absences = Vec::new();
    if goes < share_of_outings(people, is_weekend(day)) {
        absences.push(Absence::new(9.0 + 6.0 * start, 2.0 + 5.0 * length));
    }
    if people >= 2 && evening < 0.10 {
        absences.push(Absence::new(17.0 + 2.5 * late, 1.5 + 4.0 * hours));
    }
    absences
}

/// Share of days with an outing of the whole household; lower for larger households.
fn share_of_outings(people: usize, weekend: bool) -> f64 {
    match (people, weekend) {
        (0 | 1, _) => 0.0,
        (2, false) => 0.25,
        (_, false) => 0.08,
        (2, true) => 0.40,
        (3, true) => 0.32,
        (4, true) => 0.27,
        (_, true) => 0.17,
    }
}

/// Returns whether a day is a Saturday or a Sunday.
fn is_weekend(day: usize) -> bool {
    day >= 5
}

#[cfg(test)]
mod tests;
