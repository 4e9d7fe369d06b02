//! People who come and go at random.
//!
//! Each person is a Markov chain of two states, present and absent, whose probability of presence is the scheduled
//! share of people in the model (Page et al., *A generalised stochastic model for the simulation of occupant presence*,
//! Energy and Buildings 40(2), 2008). The authors set a constant ratio of changes to stays; here, the correlation time
//! is set instead.

use b2b_base::random::uniform;
use b2b_building::people::{self, PeopleGroup};
use b2b_building::{Model, PreparedBuilding};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::limits::within;
use crate::random::stream;
use crate::zones::ControlledZone;

/// The first random stream.
const STREAMS: u64 = 1 << 40;

/// Random presence of people. Off by default: people are present according to the schedules of the model.
///
/// The mean number of people follows the schedules, one step later. Lights and equipment keep their schedules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `hours` and, optionally, `seed`")]
pub struct Presence {
    /// Random seed.
    #[serde(default)]
    pub seed: u64,
    /// Correlation time of the presence of a person, h; 0 for presence by schedule.
    pub hours: f64,
}

impl Presence {
    /// Returns whether people are present by schedule.
    pub fn is_scheduled(&self) -> bool {
        self.hours == 0.0
    }

    pub(crate) fn check(&self) -> Result<()> {
        within("presence.hours", self.hours, 0.0, 1000.0)
    }
}

/// Returns the names of the controlled zones to which the model assigns no people, or zero people.
///
/// # Errors
/// The errors of [`people::groups`].
pub(crate) fn never_occupied(building: &PreparedBuilding, zones: &[ControlledZone]) -> Result<Vec<String>> {
    let groups = people::groups(building.model())?;
    let names = zones.iter().map(|zone| &building.zones[zone.slot].name);
    Ok(names.filter(|name| people::at_design(&groups, name) == 0.0).cloned().collect())
}

/// The people of a building in an episode.
#[derive(Debug)]
pub(crate) struct Attendance {
    seed: u64,
    /// Correlation of the presence of a person from step to step.
    correlation: f64,
    groups: Vec<Group>,
}

/// A group of people and the number present.
#[derive(Debug)]
struct Group {
    group: PeopleGroup,
    random: ChaCha8Rng,
    /// Number of simulated persons, and the number of the model's people that each represents: the model may have 8.3
    /// people.
    persons: u32,
    weight: f64,
    present: u32,
    /// Probability of presence in the last step; none before the first.
    probability: Option<f64>,
}

impl Attendance {
    /// The people of a model; `None` if they are present by schedule.
    pub(crate) fn new(presence: Presence, model: &Model, steps_per_hour: u32) -> Result<Option<Self>> {
        if presence.is_scheduled() {
            return Ok(None);
        }
        let groups = people::groups(model)?.into_iter().filter(|group| group.people > 0.0);
        let groups = groups.map(Group::new).collect();
        let steps = presence.hours * f64::from(steps_per_hour);
        Ok(Some(Self { seed: presence.seed, correlation: libm::exp(-1.0 / steps), groups }))
    }

    /// The groups, in the order of draws.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &PeopleGroup> {
        self.groups.iter().map(|group| &group.group)
    }

    /// Starts an episode on a day of the year.
    pub(crate) fn restart(&mut self, day_of_year: u32) {
        for (number, group) in self.groups.iter_mut().enumerate() {
            group.random = stream(self.seed, STREAMS + number as u64 * 1000 + u64::from(day_of_year));
            group.probability = None;
        }
    }

    /// Draws the number of people of a group in the next step. `scheduled` is the value of their schedule.
    pub(crate) fn draw(&mut self, group: usize, scheduled: f64) -> f64 {
        self.groups[group].draw(scheduled, self.correlation)
    }
}

impl Group {
    fn new(group: PeopleGroup) -> Self {
        let persons = group.people.round().max(1.0);
        Self {
            random: stream(0, STREAMS),
            persons: persons as u32,
            weight: group.people / persons,
            present: 0,
            probability: None,
            group,
        }
    }

    fn draw(&mut self, scheduled: f64, correlation: f64) -> f64 {
        let next = scheduled.clamp(0.0, 1.0);
        let last = self.probability.replace(next);
        // Probabilities of presence in the next step, for present and for absent people. Their difference is the
        // correlation, reduced where the schedule changes faster than it allows.
        let [stays, comes] = match last {
            None => [next; 2],
            Some(last) => {
                let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { f64::INFINITY };
                let limit = ratio(next, last).min(ratio(1.0 - next, 1.0 - last));
                let correlation = correlation.min(limit);
                [next + correlation * (1.0 - last), next - correlation * last]
            }
        };
        let mut count = |persons: u32, probability: f64| {
            (0..persons).filter(|_| uniform(&mut self.random) < probability).count() as u32
        };
        self.present = count(self.present, stays) + count(self.persons - self.present, comes);
        // A schedule above 1 has more people than the design.
        f64::from(self.present) * self.weight * scheduled.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::json;

    use super::*;

    fn attendance(people: f64, hours: f64) -> Attendance {
        let place = "zone_or_zonelist_or_space_or_spacelist_name";
        let text = json!({
            "Zone": {"Hall": {"floor_area": 100.0}},
            "People": {"Staff": {place: "Hall", "number_of_people": people}},
        });
        let model = Model::from_epjson(&text.to_string(), Path::new("hall.epJSON")).unwrap();
        let mut attendance = Attendance::new(Presence { seed: 1, hours }, &model, 12).unwrap().unwrap();
        attendance.restart(1);
        attendance
    }

    /// 400 people over 20,000 steps: the mean equals the schedule's, and the correlation over an hour is e^(-1/2).
    #[test]
    fn the_mean_follows_the_schedule_and_the_correlation_falls_with_time() {
        let mut attendance = attendance(400.4, 2.0);
        let steps: Vec<f64> = (0..20_000).map(|_| attendance.draw(0, 0.3) / 400.4).collect();
        let mean = steps.iter().sum::<f64>() / steps.len() as f64;
        let covariance = |lag: usize| {
            let pairs = steps.iter().zip(&steps[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / (steps.len() - lag) as f64
        };
        assert!((mean - 0.3).abs() < 0.003, "{mean}");
        assert!((covariance(0) / (0.3 * 0.7 / 400.0) - 1.0).abs() < 0.15, "{}", covariance(0));
        assert!((covariance(12) / covariance(0) - (-0.5f64).exp()).abs() < 0.1);
    }

    #[test]
    fn a_schedule_of_1_or_0_has_everyone_present_or_absent() {
        let mut attendance = attendance(8.3, 24.0);
        for scheduled in [0.0, 1.0, 1.0, 0.0, 0.5, 0.0, 1.5] {
            let people = attendance.draw(0, scheduled);
            if scheduled != 0.5 {
                assert!((people - 8.3 * scheduled).abs() < 1e-12, "{scheduled}: {people}");
            }
        }
    }

    #[test]
    fn the_mean_follows_a_schedule_that_changes() {
        let mut attendance = attendance(1000.0, 4.0);
        for scheduled in [0.05, 0.1, 0.5, 0.95, 0.9, 0.4, 0.5, 0.05] {
            let people = attendance.draw(0, scheduled);
            // Four standard deviations.
            let spread = 4.0 * (1000.0 * scheduled * (1.0 - scheduled)).sqrt();
            assert!((people - 1000.0 * scheduled).abs() < spread, "{scheduled}: {people}");
        }
    }

    #[test]
    fn the_draws_of_a_seed_and_day_repeat() {
        let mut attendance = attendance(20.0, 1.0);
        let day = |attendance: &mut Attendance, day_of_year: u32| -> Vec<f64> {
            attendance.restart(day_of_year);
            (0..100).map(|_| attendance.draw(0, 0.5)).collect()
        };
        let first = day(&mut attendance, 1);
        assert_ne!(first, day(&mut attendance, 2));
        assert_eq!(first, day(&mut attendance, 1));
    }
}
