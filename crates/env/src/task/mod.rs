//! Tasks: targets, reward, ventilation and disturbances as plain data, stored with every result.

mod fuels;
mod reward;
mod spelling;
mod tariff;

use std::path::Path;

use b2b_base::digest::sha256;
use b2b_building::{Class, user_file};
use serde::{Deserialize, Serialize};

use crate::faults::Faults;
use crate::limits::within;
use crate::preview::Preview;
use crate::reward::cost_scale::CostScale;
use crate::reward::energy_scale::EnergyScale;
use crate::setpoints::Setpoints;
use crate::setpoints::band::Band;
use crate::terms::Resource;
use crate::zones::HeatingOnlyZones;
use crate::zones::carbon_dioxide::CarbonDioxide;
use crate::zones::comfort::{Comfort, Pmv};
use crate::zones::presence::Presence;
use crate::zones::ventilation::Ventilation;
use crate::{Error, Result};
use fuels::{EMISSIONS, PRICES};
pub use fuels::{Fuels, Hourly};
pub use tariff::DataFile;

/// A comfort-energy task: target temperatures, comfort penalty and the weight of energy.
///
/// Its short text form is `SETPOINTS[+PART…]`, such as `constant`, `occupancy+energy0.5` or `random:7+pmv+cost2`:
///
/// | part | values |
/// |---|---|
/// | setpoints | `constant`, `constant:23` (°C), `occupancy`, `random`, `random:7` (seed), `operate`, `operate:21-24/15.6-28` (bands of heating and cooling setpoints, °C, with people and without) |
/// | comfort | none (squared deviation, as in the paper; deviation from the band with `operate`), `deadband`, `deadband0.5` (K), `pmv`, `band30` (weight of a kelvin outside the band) |
/// | resource and its weight | none, `energy0.5`, `cost1`, `carbon1`, `peak1` |
/// | tariff | none (constant prices), a name such as `tou` or `hq-m`, a TOML file |
/// | preview | none, `preview` (next setpoints; prices and weather of the next 24 hours), with bands only |
/// | CO₂ | none, `co2` (concentration in every zone), with bands only |
/// | ventilation | none (outdoor air for the people present), `free-ventilation` (as in the paper) |
/// | presence of people | none (by the schedules of the model), `presence2` (random, h): see [`Presence`] |
/// | faults | none, `noise0.2` (K), `bias0.5` (K), `stuck0.1` (probability), `fouling0.3` (share), `own-faults` (each building's own): see [`Faults`] |
///
/// All other options require JSON: see [`Task::read`]. Omitted fields keep their defaults.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Task {
    /// Target temperatures of the controlled zones.
    pub setpoints: Setpoints,
    /// Comfort penalty.
    pub comfort: Comfort,
    /// Resource that the energy penalty counts.
    pub resource: Resource,
    /// Weight w_E of the energy penalty (paper, eq. 1).
    pub energy_weight: f64,
    /// Scale τ_E that divides the resource used in a step; in the unit of the resource, Wh/m² for energy. `None`: see
    /// [`Task::scale_for`].
    pub energy_scale: Option<f64>,
    /// Treatment of zones without cooling.
    pub heating_only_zones: HeatingOnlyZones,
    /// Outdoor air that is required while zones are occupied.
    pub ventilation: Ventilation,
    /// Half width of the comfort band around the target, K. Used by metrics only.
    pub comfort_band: f64,
    /// Energy prices, currency/kWh.
    pub prices: Fuels,
    /// Emission factors, kg CO₂/kWh.
    pub emissions: Fuels,
    /// Tariff, which replaces the prices.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tariff: Option<DataFile>,
    /// Hourly emission profile, which replaces the emission factors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emission_profile: Option<DataFile>,
    /// Preview of the hours ahead in the observation, in a task with bands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preview: Option<Preview>,
    /// CO₂ of zones in the observation and the indicators, in a task with bands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub carbon_dioxide: Option<CarbonDioxide>,
    /// Presence of people.
    #[serde(skip_serializing_if = "Presence::is_scheduled")]
    pub presence: Presence,
    /// Faults of sensors and equipment.
    #[serde(skip_serializing_if = "Faults::is_none")]
    pub faults: Faults,
}

impl Default for Task {
    /// 21 °C, energy weight 0.
    fn default() -> Self {
        Self {
            setpoints: Setpoints::default(),
            comfort: Comfort::Squared,
            resource: Resource::ENERGY,
            energy_weight: 0.0,
            energy_scale: None,
            heating_only_zones: HeatingOnlyZones::BelowTarget,
            ventilation: Ventilation::Code,
            comfort_band: 1.0,
            prices: PRICES,
            emissions: EMISSIONS,
            tariff: None,
            emission_profile: None,
            preview: None,
            carbon_dioxide: None,
            presence: Presence::default(),
            faults: Faults::default(),
        }
    }
}

/// Deviation beyond which an hour counts as outside the band, K: about half the throttling range of a thermostat.
const UNMET: f64 = 0.5;
/// Weight of a kelvin outside the band in the operation tasks, in units of the mean cost of a step: a K·h per zone
/// costs as much as half a day. With it, discomfort is about a tenth of the guideline controller's penalty;
/// `b2b tune operation` computes the weight for which this holds (docs/tasks.md).
pub const OPERATION_WEIGHT: f64 = 12.0;

/// Limit of weights, scales and prices: far above sensible values, yet sums over a year stay exact enough to compare.
const LARGEST: f64 = 1e6;

impl Task {
    /// The six tasks of the paper: three modes of setpoints, without and with energy.
    pub const NAMED: [&str; 6] =
        ["constant", "occupancy", "random", "constant+energy0.5", "occupancy+energy0.5", "random+energy0.5"];

    /// Returns an operation task: hold a comfort band at low cost.
    pub fn operate(band: Band) -> Self {
        Self {
            setpoints: Setpoints::Band { band },
            comfort: Comfort::Band { weight: OPERATION_WEIGHT },
            resource: Resource::COST,
            energy_weight: 1.0,
            comfort_band: UNMET,
            ..Self::default()
        }
    }

    /// Returns whether this is an operation task, with comfort bands instead of targets.
    pub fn is_operation(&self) -> bool {
        self.setpoints.is_band()
    }

    /// Returns the currency of costs; `None` for user-defined prices, which do not state one.
    ///
    /// # Errors
    /// [`Error::Tariff`] for an unknown tariff, or with the line of an error.
    pub fn currency(&self) -> Result<Option<String>> {
        match &self.tariff {
            Some(tariff) => Ok(Some(tariff.tariff()?.currency)),
            None => Ok((self.prices == PRICES).then(|| "USD".to_owned())),
        }
    }

    /// Reads a task from a JSON file. Paths in it are relative to its folder.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::TaskFile`] with the reason; the errors of [`Task::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = user_file::read(path).map_err(|source| Error::Io { path: path.to_owned(), source })?;
        let task = Self::parse(&text).map_err(|why| Error::TaskFile { path: path.to_owned(), why })?;
        task.complete(path.parent().unwrap_or(Path::new("")))
    }

    /// Returns the short form, if it has one that says everything.
    pub fn short_form(&self) -> Option<String> {
        let text = self.to_string();
        text.parse::<Self>().is_ok_and(|task| task == *self).then_some(text)
    }

    /// Returns the text that [`Task::from_text`] reads back: the short form, or a JSON object.
    pub fn to_text(&self) -> String {
        let json = || serde_json::to_string(self).expect("plain data always serializes");
        self.short_form().unwrap_or_else(json)
    }

    /// Parses a task from a user's text: the short form, a JSON object, or the path of a JSON file.
    ///
    /// # Errors
    /// [`Error::UnknownTask`] for an unknown short form; [`Error::InvalidTask`] for an invalid object; the errors of
    /// [`Task::read`].
    pub fn from_text(text: &str) -> Result<Self> {
        if text.trim_start().starts_with('{') {
            return Self::parse(text).map_err(|why| Error::InvalidTask { why })?.complete(Path::new(""));
        }
        match Path::new(text).extension() {
            Some(extension) if extension == "json" => Self::read(Path::new(text)),
            _ => text.parse(),
        }
    }

    /// Parses a JSON object. With bands, fields that it omits are those of [`Task::operate`].
    fn parse(text: &str) -> std::result::Result<Self, String> {
        let task: Self = user_file::parse_object(text)?;
        if !task.is_operation() {
            return Ok(task);
        }
        let json = |error: serde_json::Error| error.to_string();
        let mut all: serde_json::Map<String, serde_json::Value> =
            serde_json::to_value(Self::operate(Band::Own)).and_then(serde_json::from_value).map_err(json)?;
        all.extend(user_file::parse_object::<serde_json::Map<_, _>>(text)?);
        serde_json::from_value(all.into()).map_err(json)
    }

    /// Adds the text of the files that the task names, with paths relative to a folder, and checks the task.
    fn complete(mut self, folder: &Path) -> Result<Self> {
        let replaced = [
            ("prices", "tariff", self.tariff.is_some() && self.prices != PRICES),
            ("emissions", "emission_profile", self.emission_profile.is_some() && self.emissions != EMISSIONS),
        ];
        if let Some((field, by, _)) = replaced.into_iter().find(|(.., given)| *given) {
            return Err(Error::Replaced { field, by });
        }
        self.tariff = self.tariff.map(|file| file.with_text(folder)).transpose()?;
        self.emission_profile = self.emission_profile.map(|file| file.with_text(folder)).transpose()?;
        self.check()?;
        Ok(self)
    }

    /// Checks that every number is finite and within its limits, and that files and combinations of parts are valid.
    ///
    /// # Errors
    /// [`Error::TaskValue`] for the first number that is not; [`Error::NeedsBands`]; [`Error::WithoutEffect`]; the errors
    /// of the other parts.
    pub fn check(&self) -> Result<()> {
        within("energy_weight", self.energy_weight, 0.0, LARGEST)?;
        within("energy_scale", self.energy_scale.unwrap_or(1.0), 1.0 / LARGEST, LARGEST)?;
        within("comfort_band", self.comfort_band, 0.0, 50.0)?;
        for (name, fuels, low) in [("prices", &self.prices, -LARGEST), ("emissions", &self.emissions, 0.0)] {
            for value in fuels.values() {
                within(name, value, low, LARGEST)?;
            }
        }
        self.tariff.as_ref().map_or(Ok(()), |tariff| tariff.tariff().map(drop))?;
        self.emission_profile.as_ref().map_or(Ok(()), |profile| profile.emissions().map(drop))?;
        self.preview.map_or(Ok(()), |preview| preview.check())?;
        self.carbon_dioxide.map_or(Ok(()), CarbonDioxide::check)?;
        self.check_bands()?;
        self.presence.check()?;
        self.faults.check()?;
        self.setpoints.check()?;
        self.comfort.check()
    }

    /// Checks that a task with targets has nothing that needs bands, and a task with bands nothing that needs targets.
    fn check_bands(&self) -> Result<()> {
        if !self.is_operation() {
            let parts = [("preview", self.preview.is_some()), ("co2", self.carbon_dioxide.is_some())];
            let given = parts.into_iter().find(|(_, given)| *given);
            return given.map_or(Ok(()), |(part, _)| Err(Error::NeedsBands { part }));
        }
        let (both_sides, humidity) = match &self.comfort {
            Comfort::Pmv(pmv) => (false, pmv.humidity != Pmv::default().humidity),
            _ => (self.heating_only_zones == HeatingOnlyZones::BothSides, false),
        };
        let fields = [("heating_only_zones", both_sides), ("humidity", humidity)];
        let given = fields.into_iter().find(|(_, given)| *given);
        given.map_or(Ok(()), |(field, _)| Err(Error::WithoutEffect { field }))
    }

    /// Returns the scale τ_E for a building of a class: the task's own; otherwise, for energy, the shipped
    /// [`EnergyScale`] of the class at `steps_per_hour`; for the cost of operation, the [`CostScale`]; otherwise 1.
    pub fn scale_for(&self, class: Option<Class>, steps_per_hour: u32) -> f64 {
        let usual = || match self.resource {
            Resource::ENERGY => EnergyScale::of(class?, steps_per_hour),
            Resource::COST if self.is_operation() => Some(CostScale::of(class, steps_per_hour)),
            _ => None,
        };
        self.energy_scale.or_else(usual).unwrap_or(1.0)
    }

    /// Returns the SHA-256 of the task's JSON form, in hexadecimal. Tasks with equal hashes are equal.
    pub fn hash(&self) -> String {
        // A task is plain data: serialization cannot fail.
        let json = serde_json::to_vec(self).unwrap_or_default();
        sha256(json)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(text: &str) -> Task {
        text.parse().unwrap()
    }

    #[test]
    fn a_value_that_is_not_finite_is_rejected() {
        let not_finite = Task { energy_weight: f64::NAN, ..Task::default() };
        assert!(not_finite.check().unwrap_err().to_string().contains("NaN"));
    }

    #[test]
    fn a_task_round_trips_through_json_and_its_hash_is_unique() {
        for text in Task::NAMED {
            let json = serde_json::to_string(&task(text)).unwrap();
            assert_eq!(serde_json::from_str::<Task>(&json).unwrap(), task(text), "{json}");
        }
        let hashes: std::collections::BTreeSet<_> =
            Task::NAMED.iter().map(|text| task(text).hash()).collect();
        assert_eq!(hashes.len(), 6);
    }

    #[test]
    fn the_scale_is_the_task_s_or_for_energy_the_class_s() {
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
    fn the_example_in_the_documentation_is_a_valid_task() {
        let text = include_str!("../../../../docs/tasks.md");
        let json = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let task: Task = serde_json::from_str(json).unwrap();
        task.check().unwrap();
        assert_eq!(
            (task.resource, task.comfort),
            (Resource::of_word("cost").unwrap(), Comfort::Deadband { half_width: 0.5 })
        );
        assert!(Task::NAMED.iter().all(|name| text.contains(name.split('+').next().unwrap())));
    }

    #[test]
    fn the_example_of_operation_in_the_documentation_is_a_valid_task() {
        let text = include_str!("../../../../docs/operation.md");
        let json = text.split("```json").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
        let task = Task::from_text(json).unwrap();
        assert!(task.is_operation() && task.preview.is_some());
        let form = task.clone();
        let plain = Task::operate(Band::Own);
        assert_eq!(
            (form.comfort, form.comfort_band),
            (plain.comfort, plain.comfort_band),
            "the defaults of `operate`"
        );
        for word in text.split('`').filter(|word| word.starts_with("operate")) {
            word.parse::<Task>().unwrap();
        }
    }

    #[test]
    fn an_object_with_bands_omits_what_operate_has() {
        let of = |text: &str| Task::from_text(text).unwrap();
        assert_eq!(of(r#"{"setpoints": {"mode": "band"}}"#), task("operate"));
        assert_eq!(of(r#"{"setpoints": {"mode": "band"}, "tariff": "tou"}"#), task("operate+tou"));
        let own = of(r#"{"setpoints": {"mode": "band"}, "energy_weight": 0.0, "comfort": "squared"}"#);
        assert_eq!((own.energy_weight, own.comfort), (0.0, Comfort::Squared));
        assert_eq!(of("{}"), Task::default());
    }

    #[test]
    fn a_field_without_effect_on_a_task_is_refused() {
        let with = |field: &str| Task::from_text(&format!(r#"{{"setpoints": {{"mode": "band"}}, {field}}}"#));
        let sides = r#""heating_only_zones": "both_sides""#;
        let humid = r#""comfort": {"pmv": {"humidity": 60}}"#;
        for (field, name) in [(sides, "`heating_only_zones`"), (humid, "`humidity`")] {
            let said = with(field).unwrap_err().to_string();
            assert!(said.contains(name), "{said}");
        }
        assert!(with(&format!(r#"{sides}, "comfort": {{"pmv": {{}}}}"#)).is_ok(), "a vote has two sides");
        assert!(
            Task::from_text(&format!("{{{sides}}}")).is_ok()
                && Task::from_text(&format!("{{{humid}}}")).is_ok()
        );
        assert!(task_error("constant+preview").contains("needs comfort bands"));
    }

    fn task_error(text: &str) -> String {
        text.parse::<Task>().unwrap_err().to_string()
    }

    #[test]
    fn a_file_may_omit_fields_but_not_misspell_them() {
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
        let said =
            read(r#"{"tariff": "tou", "prices": {"electricity": 1, "gas": 1}}"#).unwrap_err().to_string();
        assert!(said.contains("`prices`") && said.contains("`tariff`"), "{said}");
        let said = read(r#"{"energy_wieght": 1}"#).unwrap_err().to_string();
        assert!(said.contains("energy_wieght") && said.contains("energy_weight"), "{said}");
        let said = read(r#"{"comfort_band": -1}"#).unwrap_err().to_string();
        assert!(said.contains("comfort_band"), "{said}");
    }

    #[test]
    fn every_task_reads_back_from_its_text() {
        let named = "occupancy+energy0.5".parse::<Task>().unwrap();
        assert_eq!(named.to_text(), "occupancy+energy0.5");
        let own = Task { comfort_band: 0.7, ..named };
        assert_eq!(own.short_form(), None);
        assert_eq!(Task::from_text(&own.to_text()).unwrap(), own);
    }

    #[test]
    fn paths_in_a_task_file_are_relative_to_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let tariff = b2b_tariff::shipped_text("tou").unwrap();
        std::fs::write(folder.path().join("mine.toml"), tariff).unwrap();
        let task = |file: &str| {
            let path = folder.path().join("task.json");
            std::fs::write(&path, format!(r#"{{"tariff": "{file}"}}"#)).unwrap();
            Task::read(&path)
        };
        assert_eq!(task("mine.toml").unwrap().tariff.unwrap().text(), Some(tariff));
        let absolute = folder.path().join("mine.toml");
        assert_eq!(task(absolute.to_str().unwrap()).unwrap().tariff.unwrap().name(), "mine");
        let said = task("other.toml").unwrap_err().to_string();
        assert!(said.contains(folder.path().join("other.toml").to_str().unwrap()), "{said}");
    }
}
