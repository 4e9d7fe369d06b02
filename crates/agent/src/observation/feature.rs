//! One slot of an agent's observation.

use std::f64::consts::TAU;

use b2b_env::{NextPair, Target};

use super::memory::Memory;
use super::outdoor::{OUTDOOR, at_hour};
use super::past::Past;

/// One slot of an agent's observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Name, for example `Core_ZN error/1K`.
    pub name: String,
    /// How it is computed.
    pub(super) source: Source,
}

/// How a slot is computed. A number is divided by its scale and clipped to its limit on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Source {
    /// A constant.
    Constant(f64),
    /// A slot of the environment, scaled from its bounds to [-1, 1].
    Bounded { slot: usize, low: f64, high: f64 },
    /// The deviation of a slot from a center.
    Deviation { slot: usize, center: f64, scale: f64, limit: f64 },
    /// The change of a slot in the last step.
    Change { slot: usize, scale: f64, limit: f64 },
    /// Temperature minus target of a controlled zone, by its index.
    Error { zone: usize, scale: f64, limit: f64 },
    /// The recent mean of that error: see [`Memory`].
    RecentError { zone: usize, scale: f64, limit: f64 },
    /// A target.
    Target { target: Target, center: f64, scale: f64 },
    /// Sine or cosine of the time of day, with a number of periods per day.
    Day { slot: usize, periods: f64, cosine: bool },
    /// Sine or cosine of the time of the week.
    Week { day: usize, hour: usize, cosine: bool },
    /// Proximity to an hour of the week (of 168): 1 at the hour, falling linearly to 0 an hour away.
    HourOfWeek { day: usize, hour: usize, at: f64 },
    /// Sine or cosine of the time of the year.
    Year { slot: usize, cosine: bool },
    /// The outdoor temperature a number of hours ahead, by the slots of the day of the year and the time of day.
    Forecast { day: usize, hour: usize, ahead: f64 },
    /// One slot minus another.
    Difference { slot: usize, less: usize, scale: f64, limit: f64 },
    /// Proximity of the next change of the band of a zone, by its index: 1 now, 0 in 12 hours or more.
    ChangeAhead { zone: usize },
    /// By how much the next change moves the heating setpoint in a slot, or the cooling setpoint.
    NextSetpoint { zone: usize, slot: usize, cooling: bool, scale: f64, limit: f64 },
    /// The deviation of a decision of the supervised sequences from a center.
    Decision { decision: usize, center: f64, scale: f64, limit: f64 },
    /// Whether a decision of the supervised sequences has a value.
    DecisionIs { decision: usize, value: f64 },
    /// A component of the agent's previous action.
    Previous(usize),
    /// The signed square root of the reward of the previous decision.
    PreviousReward,
    /// Whether the step is the first of an episode.
    First,
    /// The base controller's next action for an actuator.
    Base(usize),
}

/// A slot that is linear in a slot of the environment: `scale` × that slot + `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LinearFeature {
    pub(crate) slot: usize,
    pub(crate) scale: f64,
    pub(crate) offset: f64,
}

/// Inputs from which a slot is computed.
pub(super) struct Context<'a> {
    pub(super) observation: &'a [f64],
    pub(super) memory: &'a Memory,
    /// Outdoor temperatures at the end of each hour of the year, °C.
    pub(super) outdoor: &'a [f64],
    /// The next change of the band of each zone.
    pub(super) changes: &'a [Option<NextPair>],
    pub(super) past: Past<'a>,
    pub(super) base: &'a [f32],
    /// Decisions of the supervised sequences in the last step.
    pub(super) decisions: &'a [f64],
}

impl Feature {
    pub(super) fn new(name: impl Into<String>, source: Source) -> Self {
        Self { name: name.into(), source }
    }

    /// Returns it as a linear function of one slot; `None` if it is not linear.
    pub(super) fn linear(&self) -> Option<LinearFeature> {
        match self.source {
            Source::Constant(value) => Some(LinearFeature { slot: 0, scale: 0.0, offset: value }),
            Source::Bounded { slot, low, high } => {
                let (scale, offset) = (2.0 / (high - low), (low + high) / (low - high));
                Some(LinearFeature { slot, scale, offset })
            }
            _ => None,
        }
    }

    pub(super) fn value(&self, context: &Context<'_>) -> f64 {
        let Context { observation, memory, outdoor, changes, past, base, decisions } = context;
        match self.source {
            Source::Constant(value) => value,
            Source::Bounded { slot, low, high } => 2.0 * (observation[slot] - low) / (high - low) - 1.0,
            Source::Deviation { slot, center, scale, limit } => {
                clipped(observation[slot] - center, scale, limit)
            }
            Source::Change { slot, scale, limit } => clipped(memory.change(slot), scale, limit),
            Source::Error { zone, scale, limit } => clipped(memory.error(zone), scale, limit),
            Source::RecentError { zone, scale, limit } => clipped(memory.recent_error(zone), scale, limit),
            Source::Target { target, center, scale } => (target.of(observation) - center) / scale,
            Source::Day { slot, periods, cosine } => wave(observation[slot] / 24.0 * periods, cosine),
            Source::Week { day, hour, cosine } => {
                wave((observation[day] + observation[hour] / 24.0) / 7.0, cosine)
            }
            Source::HourOfWeek { day, hour, at } => {
                let distance = (24.0 * observation[day] + observation[hour] - at).abs();
                (1.0 - distance.min(HOURS_OF_WEEK - distance)).max(0.0)
            }
            Source::Year { slot, cosine } => wave(observation[slot] / 365.0, cosine),
            Source::Forecast { day, hour, ahead } => {
                let hour = 24.0 * (observation[day] - 1.0) + observation[hour] + ahead;
                let (center, scale) = OUTDOOR;
                (at_hour(outdoor, hour) - center) / scale
            }
            Source::Difference { slot, less, scale, limit } => {
                clipped(observation[slot] - observation[less], scale, limit)
            }
            Source::ChangeAhead { zone } => {
                changes[zone].map_or(0.0, |next| (1.0 - next.hours / HOURS_AHEAD).max(0.0))
            }
            Source::NextSetpoint { zone, slot, cooling, scale, limit } => changes[zone].map_or(0.0, |next| {
                let setpoint = if cooling { next.pair.cooling } else { next.pair.heating };
                clipped(setpoint - observation[slot], scale, limit)
            }),
            Source::Decision { decision, center, scale, limit } => {
                clipped(decisions[decision] - center, scale, limit)
            }
            Source::DecisionIs { decision, value } => f64::from(u8::from(decisions[decision] == value)),
            Source::Previous(actuator) => f64::from(past.action[actuator]),
            Source::PreviousReward => past.reward.signum() * past.reward.abs().sqrt().min(LARGEST_ROOT),
            Source::First => f64::from(u8::from(past.is_first)),
            Source::Base(actuator) => f64::from(base[actuator]),
        }
    }
}

/// Limit of the signed square root of a reward, K in tracking tasks.
const LARGEST_ROOT: f64 = 5.0;

/// Hours of a week.
pub(super) const HOURS_OF_WEEK: f64 = 168.0;

/// Hours ahead at which `ChangeAhead` reaches 0.
const HOURS_AHEAD: f64 = 12.0;

fn clipped(value: f64, scale: f64, limit: f64) -> f64 {
    (value / scale).clamp(-limit, limit)
}

/// Sine or cosine of a share of a turn, the same bits on every machine.
fn wave(turn: f64, cosine: bool) -> f64 {
    if cosine { libm::cos(TAU * turn) } else { libm::sin(TAU * turn) }
}
