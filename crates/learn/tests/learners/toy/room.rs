//! Two rooms with heaters, each a capacity behind resistances.

use std::f32::consts::TAU;

use b2b_learn::random::RandomStream;
use b2b_learn::rollout::Widths;

use super::Toy;

/// Two rooms on a day of 96 steps of 15 minutes. Observation: each temperature minus its target now and in an hour,
/// over 5 K; outdoor temperature over 10 °C; cosine and sine of the hour. Action: heating power of each room, from none
/// at -1 to full at 1. Reward of each room: -|temperature - target| - 0.1 × share of full power.
pub struct Room {
    step: usize,
    /// °C.
    temperatures: [f32; 2],
    /// °C.
    outdoor: f32,
    /// Heat of people and devices in each room (kW).
    gains: [f32; 2],
}

/// Hours.
const STEP: f32 = 0.25;
/// kWh/K.
const CAPACITY: f32 = 0.5;
/// kW/K, to outdoors and between the rooms.
const LOSS: f32 = 0.06;
const COUPLING: f32 = 0.05;
/// kW.
const POWER: f32 = 3.0;
/// Hours of the day between which each room is used, and targets (°C) then and otherwise.
const USE: [(usize, usize); 2] = [(7, 18), (9, 22)];
const TARGETS: [f32; 2] = [21.0, 17.0];

impl Room {
    fn target(room: usize, step: usize) -> f32 {
        let hour = step % 96 / 4;
        TARGETS[usize::from(!(USE[room].0..USE[room].1).contains(&hour))]
    }

    fn disturb(&mut self, random: &mut RandomStream) {
        let daily = -5.0 * (TAU * (self.step as f32 / 96.0 - 0.1)).cos();
        self.outdoor += 0.2 * (daily - self.outdoor) + 0.4 * random.normal() as f32;
        for gain in &mut self.gains {
            *gain = (0.9 * *gain + 0.1 * random.normal() as f32).clamp(0.0, 0.5);
        }
    }
}

impl Toy for Room {
    const WIDTHS: Widths = Widths { observation: 7, action: 2, parts: 2, nodes: 1 };
    const STEPS: usize = 96;
    const REWARD_SCALE: f32 = 0.2;

    fn reset(random: &mut RandomStream) -> Self {
        let mut draw = |mean: f32, deviation: f32| mean + deviation * random.normal() as f32;
        Self {
            step: 0,
            temperatures: [draw(17.0, 1.0), draw(17.0, 1.0)],
            outdoor: draw(-5.0, 3.0),
            gains: [0.0; 2],
        }
    }

    fn observe(&self, observation: &mut [f32]) {
        for room in 0..2 {
            observation[2 * room] = (self.temperatures[room] - Self::target(room, self.step)) / 5.0;
            observation[2 * room + 1] = (self.temperatures[room] - Self::target(room, self.step + 4)) / 5.0;
        }
        let phase = TAU * self.step as f32 / 96.0;
        observation[4..].copy_from_slice(&[self.outdoor / 10.0, phase.cos(), phase.sin()]);
    }

    fn step(&mut self, action: &[f32], random: &mut RandomStream, rewards: &mut [f32]) {
        let [first, second] = self.temperatures;
        for (room, other) in [second, first].into_iter().enumerate() {
            let share = 0.5 + 0.5 * action[room].clamp(-1.0, 1.0);
            let temperature = &mut self.temperatures[room];
            let heat = LOSS * (self.outdoor - *temperature) + COUPLING * (other - *temperature);
            *temperature += STEP / CAPACITY * (heat + POWER * share + self.gains[room]);
            rewards[room] = -(*temperature - Self::target(room, self.step)).abs() - 0.1 * share;
        }
        self.step += 1;
        self.disturb(random);
    }
}
