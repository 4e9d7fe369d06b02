//! What an agent is asked to do: data, so that it can be written down, compared and kept with every result.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use b2b_building::Class;
use b2b_energyplus::digest::sha256;
use serde::{Deserialize, Serialize};

use crate::comfort::{Comfort, Pmv};
use crate::energy_scale::EnergyScale;
use crate::setpoints::Setpoints;
use crate::{Error, Result};

/// A comfort-energy task: where the target temperatures are, and what energy is worth against them.
///
/// It has a spelling, `SETPOINTS[+COMFORT][+RESOURCE WEIGHT]`, such as `constant`, `occupancy+energy0.5`,
/// `random:7+pmv+cost2`:
///
/// | part | is one of |
/// |---|---|
/// | setpoints | `constant`, `constant:23` (°C), `occupancy`, `random`, `random:7` (seed) |
/// | comfort | nothing (squared deviation, the paper's), `deadband`, `deadband0.5` (K), `pmv` |
/// | resource and its weight | nothing, `energy0.5`, `cost1`, `carbon1`, `peak1` |
///
/// What has no spelling is JSON: see [`Task::read`]. Fields that a file leaves out have their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Task {
    /// Target of every controlled zone.
    pub setpoints: Setpoints,
    /// How comfort is judged.
    pub comfort: Comfort,
    /// What is to be saved.
    pub resource: Resource,
    /// Weight w_E of what is to be saved (paper, eq. 1).
    pub energy_weight: f64,
    /// Scale τ_E: what the resource of a step is divided by before it is weighted; in its unit, Wh/m² for energy.
    /// `None`: see [`Task::scale_for`].
    pub energy_scale: Option<f64>,
    /// How zones that cannot be cooled are judged.
    pub heating_only_zones: HeatingOnlyZones,
    /// A zone is outside comfort when it is further than this from its target, K. For the metrics alone.
    pub comfort_band: f64,
    /// Price of energy, currency/kWh.
    pub prices: Fuels,
    /// Emissions of energy, kg of CO₂/kWh.
    pub emissions: Fuels,
}

/// What the energy term of the reward counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Resource {
    /// HVAC energy of the step, all fuels, Wh/m² (the paper's).
    #[default]
    Energy,
    /// Its cost by the task's prices, currency/m².
    Cost,
    /// Its emissions by the task's factors, g of CO₂/m².
    Carbon,
    /// By how much the step raises the episode's highest HVAC power, W/m² of electricity.
    Peak,
}

/// A number for each fuel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fuels {
    /// Of electricity.
    pub electricity: Hourly,
    /// Of gas.
    pub gas: Hourly,
}

/// A number that is the same all day, or one for each hour of the day from midnight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Hourly {
    /// The same all day.
    Always(f64),
    /// By hour of the day, standard time.
    Hours([f64; 24]),
}

/// How zones with heating and no cooling enter the reward.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HeatingOnlyZones {
    /// They count below target only: a warehouse at 35 °C in summer has no cooling to blame.
    #[default]
    BelowTarget,
    /// They count on both sides, as the paper has it.
    BothSides,
}

/// US commercial consumers, 2023, rounded: 12.7 ¢/kWh of electricity, 11.1 $ per thousand cubic feet of gas (EIA, Electric
/// Power Monthly and Natural Gas Monthly). A default to be replaced by those of a place.
const PRICES: Fuels = Fuels { electricity: Hourly::Always(0.127), gas: Hourly::Always(0.0365) };
/// 0.373 kg/kWh: mean of the US grid (EPA eGRID 2022, 823 lb/MWh); 0.181 kg/kWh: 53.06 kg per million Btu of natural gas
/// (40 CFR 98, table C-1). A default to be replaced by those of a place.
const EMISSIONS: Fuels = Fuels { electricity: Hourly::Always(0.373), gas: Hourly::Always(0.181) };

impl Default for Task {
    /// 21 °C, energy not counted.
    fn default() -> Self {
        Self {
            setpoints: Setpoints::default(),
            comfort: Comfort::Squared,
            resource: Resource::Energy,
            energy_weight: 0.0,
            energy_scale: None,
            heating_only_zones: HeatingOnlyZones::BelowTarget,
            comfort_band: 1.0,
            prices: PRICES,
            emissions: EMISSIONS,
        }
    }
}

impl Hourly {
    /// The number at an hour of the day, 0 to 24.
    pub fn at(&self, hour: f64) -> f64 {
        match self {
            Self::Always(value) => *value,
            Self::Hours(hours) => hours[(hour as usize) % 24],
        }
    }

    fn values(&self) -> &[f64] {
        match self {
            Self::Always(value) => std::slice::from_ref(value),
            Self::Hours(hours) => hours,
        }
    }
}

impl Task {
    /// The paper's six: three modes of setpoints, without and with energy.
    pub const NAMED: [&str; 6] =
        ["constant", "occupancy", "random", "constant+energy0.5", "occupancy+energy0.5", "random+energy0.5"];

    /// A task from a JSON file.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::TaskFile`] with what is wrong in it; those of [`Task::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let text =
            std::fs::read_to_string(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let task: Self = serde_json::from_str(&text)
            .map_err(|error| Error::TaskFile { path: path.to_owned(), why: error.to_string() })?;
        task.check()?;
        Ok(task)
    }

    /// Whether every number of it is finite and possible.
    ///
    /// # Errors
    /// [`Error::TaskValue`] naming the first that is not.
    pub fn check(&self) -> Result<()> {
        within("energy_weight", self.energy_weight, 0.0, f64::MAX)?;
        within("energy_scale", self.energy_scale.unwrap_or(1.0), f64::MIN_POSITIVE, f64::MAX)?;
        within("comfort_band", self.comfort_band, 0.0, 50.0)?;
        for (name, fuels, low) in [("prices", &self.prices, f64::MIN), ("emissions", &self.emissions, 0.0)] {
            for value in fuels.electricity.values().iter().chain(fuels.gas.values()) {
                within(name, *value, low, f64::MAX)?;
            }
        }
        self.setpoints.check()?;
        self.comfort.check()
    }

    /// The scale τ_E for a building of a class, with so many steps an hour: the task's own; else for energy the shipped
    /// [`EnergyScale`] of the class; else 1.
    pub fn scale_for(&self, class: Option<Class>, steps_per_hour: u32) -> f64 {
        let shipped = || match self.resource {
            Resource::Energy => EnergyScale::of(class?, steps_per_hour),
            _ => None,
        };
        self.energy_scale.or_else(shipped).unwrap_or(1.0)
    }

    /// SHA-256 of it as JSON, in hexadecimal: equal hashes mean equal tasks.
    pub fn hash(&self) -> String {
        // A task is plain data: it has a JSON form.
        let json = serde_json::to_vec(self).unwrap_or_default();
        sha256(json)
    }

    fn spelling(&self) -> String {
        let setpoints = match &self.setpoints {
            Setpoints::Constant { target } if *target == 21.0 => "constant".to_owned(),
            Setpoints::Constant { target } => format!("constant:{target}"),
            Setpoints::Occupancy { .. } => "occupancy".to_owned(),
            Setpoints::Random { seed: 0, .. } => "random".to_owned(),
            Setpoints::Random { seed, .. } => format!("random:{seed}"),
        };
        let comfort = match &self.comfort {
            Comfort::Squared => String::new(),
            Comfort::Deadband { half_width: 1.0 } => "+deadband".to_owned(),
            Comfort::Deadband { half_width } => format!("+deadband{half_width}"),
            Comfort::Pmv(_) => "+pmv".to_owned(),
        };
        let resource = match self.resource {
            Resource::Energy if self.energy_weight == 0.0 => return setpoints + &comfort,
            Resource::Energy => "energy",
            Resource::Cost => "cost",
            Resource::Carbon => "carbon",
            Resource::Peak => "peak",
        };
        format!("{setpoints}{comfort}+{resource}{}", self.energy_weight)
    }
}

impl fmt::Display for Task {
    /// Its spelling; where it has none, that of the nearest and the head of its hash, such as `occupancy#1a2b3c4d`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spelling = self.spelling();
        match spelling.parse::<Self>() {
            Ok(task) if task == *self => f.write_str(&spelling),
            _ => write!(f, "{spelling}#{}", &self.hash()[..8]),
        }
    }
}

impl FromStr for Task {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let unknown = || Error::UnknownTask { text: text.to_owned() };
        let mut parts = text.split('+');
        let setpoints = parts.next().unwrap_or_default();
        let mut task = Self { setpoints: setpoints.parse().map_err(|()| unknown())?, ..Self::default() };
        let (mut comfort, mut resource) = (false, false);
        for part in parts {
            let word = part.trim_end_matches(|c: char| c.is_ascii_digit() || ".-".contains(c));
            let number = &part[word.len()..];
            let number = (!number.is_empty()).then(|| number.parse::<f64>()).transpose();
            let number = number.map_err(|_| unknown())?;
            let counts = |of: Resource| number.map(|weight| (of, weight)).ok_or_else(unknown);
            let seen = match word {
                "deadband" => {
                    task.comfort = Comfort::Deadband { half_width: number.unwrap_or(1.0) };
                    &mut comfort
                }
                "pmv" if number.is_none() => {
                    task.comfort = Comfort::Pmv(Pmv::default());
                    &mut comfort
                }
                "energy" | "cost" | "carbon" | "peak" => {
                    (task.resource, task.energy_weight) = counts(match word {
                        "energy" => Resource::Energy,
                        "cost" => Resource::Cost,
                        "carbon" => Resource::Carbon,
                        _ => Resource::Peak,
                    })?;
                    &mut resource
                }
                _ => return Err(unknown()),
            };
            if std::mem::replace(seen, true) {
                return Err(unknown());
            }
        }
        task.check()?;
        Ok(task)
    }
}

/// Whether a value of a task is a number within bounds.
pub(crate) fn within(name: &'static str, value: f64, low: f64, high: f64) -> Result<()> {
    if (low..=high).contains(&value) && value.is_finite() {
        return Ok(());
    }
    Err(Error::TaskValue { name, value, low, high })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(text: &str) -> Task {
        text.parse().unwrap()
    }

    #[test]
    fn a_spelling_reads_back_as_it_prints() {
        for text in Task::NAMED.iter().copied().chain([
            "constant:23.5",
            "random:7",
            "occupancy+deadband",
            "occupancy+deadband0.5+cost2",
            "random:3+pmv+carbon0.1",
            "constant+peak1",
        ]) {
            assert_eq!(task(text).to_string(), text);
        }
        assert_eq!(task("constant"), Task::default());
        assert_eq!(task("occupancy+energy0.5").energy_weight, 0.5);
    }

    #[test]
    fn what_is_no_task_is_refused_with_what_would_be() {
        for text in
            ["", "occupied", "constant+energy", "constant+energy0.5+cost1", "constant+pmv2", "random:x"]
        {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(said.contains(&format!("`{text}`")) && said.contains("occupancy+energy0.5"), "{said}");
        }
        for (text, words) in [
            ("constant:99", ["target", "99"]),
            ("constant+energy-1", ["energy_weight", "-1"]),
            ("constant+deadband-1", ["half_width", "-1"]),
        ] {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
        let not_finite = Task { energy_weight: f64::NAN, ..Task::default() };
        assert!(not_finite.check().unwrap_err().to_string().contains("NaN"));
    }

    #[test]
    fn a_task_is_data_and_its_hash_tells_it_from_others() {
        for text in Task::NAMED {
            let json = serde_json::to_string(&task(text)).unwrap();
            assert_eq!(serde_json::from_str::<Task>(&json).unwrap(), task(text), "{json}");
        }
        let hashes: std::collections::BTreeSet<_> =
            Task::NAMED.iter().map(|text| task(text).hash()).collect();
        assert_eq!(hashes.len(), 6);
        let own = Task { comfort_band: 0.5, ..Task::default() };
        assert!(own.to_string().starts_with("constant#"), "{own}");
    }

    #[test]
    fn the_scale_is_the_task_s_own_or_that_of_the_class_and_of_energy_alone() {
        let [energy, cost] = ["constant+energy0.5", "constant+cost1"].map(task);
        let class = EnergyScale::shipped()[0].class;
        let shipped = EnergyScale::of(class, 12).unwrap();
        assert_eq!(energy.scale_for(Some(class), 12), shipped);
        assert_eq!(energy.scale_for(None, 12), 1.0);
        assert_eq!(cost.scale_for(Some(class), 12), 1.0);
        let own = Task { energy_scale: Some(3.0), ..energy };
        assert_eq!(own.scale_for(Some(class), 12), 3.0);
        assert_ne!(own.hash(), task("constant+energy0.5").hash());
        assert!(
            Task { energy_scale: Some(0.0), ..own }.check().unwrap_err().to_string().contains("energy_scale")
        );
    }

    #[test]
    fn the_file_in_the_documentation_is_a_task() {
        let text = include_str!("../../../docs/tasks.md");
        let json = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let task: Task = serde_json::from_str(json).unwrap();
        task.check().unwrap();
        assert_eq!((task.resource, task.comfort), (Resource::Cost, Comfort::Deadband { half_width: 0.5 }));
        assert!(Task::NAMED.iter().all(|name| text.contains(name.split('+').next().unwrap())));
    }

    #[test]
    fn a_file_may_leave_out_what_it_does_not_change_and_no_name_may_be_wrong() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("task.json");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            Task::read(&path)
        };
        let hours: Vec<String> =
            (0..24).map(|hour| if hour < 7 { "0.1" } else { "0.2" }.to_owned()).collect();
        let text = format!(
            r#"{{"setpoints": {{"mode": "occupancy", "summer": 27}}, "resource": "cost", "energy_weight": 2,
                "prices": {{"electricity": [{}], "gas": 0.05}}}}"#,
            hours.join(",")
        );
        let task = read(&text).unwrap();
        assert_eq!((task.prices.electricity.at(6.99), task.prices.electricity.at(7.0)), (0.1, 0.2));
        assert_eq!(
            task.setpoints,
            Setpoints::Occupancy { occupied: 21.0, winter: 18.0, summer: 27.0, otherwise: 21.0 }
        );
        let said = read(r#"{"energy_wieght": 1}"#).unwrap_err().to_string();
        assert!(said.contains("energy_wieght") && said.contains("energy_weight"), "{said}");
        let said = read(r#"{"comfort_band": -1}"#).unwrap_err().to_string();
        assert!(said.contains("comfort_band"), "{said}");
    }
}
