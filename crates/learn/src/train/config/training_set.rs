//! Buildings, tasks and period of a training run.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use b2b_base::spread::spread;
use b2b_building::{BuildingType, Period};
use b2b_climate::Place;
use b2b_dataset::{BuildingId, BuildingName, Control, Placement, Row, Split};
use serde::{Deserialize, Serialize};

use super::one_or_many;
use super::tasks::Tasks;
use crate::error::{Error, Result};
use crate::limits::require;

/// Buildings, tasks and period of a training run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TrainingSet {
    /// Training buildings by name, assigned to the environments in turn. Empty: the buildings of `building_type` in the
    /// training split.
    pub buildings: Vec<String>,
    /// Place of `buildings`, such as `Miami`. Empty: their own.
    pub place: String,
    /// Weather file (EPW) for `buildings`, instead of a place. Empty: the place's weather.
    pub weather: PathBuf,
    /// What an agent sets: the `actuators` of the systems or the `setpoints` of every zone.
    pub control: Control,
    /// Whether the equipment of a model file is sized for its own design days instead of the weather file's.
    pub keep_design_days: bool,
    /// Whether a model file may run code and open files outside its folder. Only the caller can set it. Configuration
    /// files cannot, and saved ones leave it out.
    #[serde(skip)]
    pub allow_external: bool,
    /// Building type from whose training split every episode's building is drawn, or a list of types, which take turns
    /// over the environments. Empty: `buildings`.
    #[serde(with = "one_or_many")]
    pub building_type: Vec<String>,
    /// Turns of a type among the types of the environments, such as `{ OfficeMedium = 3 }`. Other types have 1.
    pub type_turns: BTreeMap<BuildingType, usize>,
    /// Number of buildings of each type to draw from, evenly spread over its training split. 0: all.
    pub type_buildings: usize,
    /// ASHRAE 169 climate zones whose buildings are not drawn, such as `1A`, or `1` for 1A to 1C.
    pub excluded_climate_zones: Vec<String>,
    /// Number of episodes that an environment spends in a drawn building.
    pub building_episodes: u32,
    /// Number of seeds of the task's faults, one of which is drawn for every `building_episodes` episodes. 0: the
    /// task's own.
    pub fault_seeds: u64,
    /// Benchmark problem, by name or JSON file, that the agent is for. It sets buildings, tasks, run period, steps per
    /// hour, steps and attributes, and none of them may go beyond its training side. Empty: none.
    pub problem: String,
    /// Task, such as `occupancy+energy0.5`, or several, one of which is drawn for every episode. See [`Tasks`].
    pub task: Tasks,
    /// Run period: `winter`, `summer`, `full_year`, `MM-DD..MM-DD` or two weeks chosen from the weather of a building,
    /// such as `peak-heating`; or several, separated by commas, one of which is drawn for every episode.
    pub period: String,
    /// Zone time steps per hour, each one step.
    pub steps_per_hour: u32,
    /// Days of a training episode, which begins on one of `window_starts` days of the run period. 0: the whole run
    /// period.
    pub window_days: u32,
    /// Number of days of each run period on which training episodes may begin.
    pub window_starts: u32,
}

impl Default for TrainingSet {
    fn default() -> Self {
        Self {
            buildings: Vec::new(),
            place: String::new(),
            weather: PathBuf::new(),
            control: Control::default(),
            keep_design_days: false,
            allow_external: false,
            building_type: Vec::new(),
            type_turns: BTreeMap::new(),
            type_buildings: 0,
            excluded_climate_zones: Vec::new(),
            building_episodes: 1,
            fault_seeds: 0,
            problem: String::new(),
            task: Tasks::default(),
            period: "winter".into(),
            steps_per_hour: 12,
            window_days: 0,
            window_starts: 1,
        }
    }
}

impl TrainingSet {
    /// Returns the run periods, at least one.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn periods(&self) -> Result<Vec<Period>> {
        let parsed = |text: &str| {
            text.trim().parse().map_err(|error: b2b_building::Error| Error::Invalid(error.to_string()))
        };
        self.period.split(',').map(parsed).collect()
    }

    /// Returns the names of the training buildings; empty if a type is given instead.
    ///
    /// # Errors
    /// [`Error::Building`].
    pub fn named(&self) -> Result<Vec<BuildingName>> {
        Ok(self.buildings.iter().map(|name| name.parse()).collect::<b2b_dataset::Result<_>>()?)
    }

    /// Returns the number of types among the named buildings; a model counts as none.
    pub(super) fn named_types(&self) -> Result<usize> {
        let names = self.named()?;
        let types = names.iter().filter_map(|name| match name {
            BuildingName::Type(building_type) => Some(building_type.name()),
            BuildingName::Id(id) => Some(id.building_type().name()),
            BuildingName::Model(_) => None,
        });
        Ok(types.collect::<BTreeSet<_>>().len())
    }

    /// Returns the building types whose buildings are drawn; none for named buildings.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn building_types(&self) -> Result<Vec<BuildingType>> {
        let parsed = |name: &String| {
            name.parse().map_err(|error: b2b_building::Error| Error::Invalid(error.to_string()))
        };
        self.building_type.iter().map(parsed).collect()
    }

    /// Returns the types of the environments in turn: every type once, and then those with more turns again.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub(crate) fn turns(&self) -> Result<Vec<BuildingType>> {
        let types = self.building_types()?;
        let turns = |each: &BuildingType| self.type_turns.get(each).copied().unwrap_or(1);
        let rounds = types.iter().map(turns).max().unwrap_or(0);
        let of_round = |round| types.iter().filter(move |each| round < turns(each));
        Ok((0..rounds).flat_map(of_round).copied().collect())
    }

    /// Returns the buildings of a type to draw from: its training split, without the excluded climate zones, or some of
    /// it.
    pub(crate) fn drawn(&self, building_type: BuildingType) -> Vec<BuildingId> {
        let is_excluded =
            |row: &Row| self.excluded_climate_zones.iter().any(|zone| row.is_in_climate_zone(zone));
        let rows = b2b_dataset::rows(building_type).iter();
        let trained = rows.filter(|row| row.split == Split::Train && !is_excluded(row));
        let all: Vec<BuildingId> = trained.map(|row| row.id).collect();
        match self.type_buildings {
            0 => all,
            count => spread(&all, count),
        }
    }

    /// Returns the site of `buildings`.
    ///
    /// # Errors
    /// [`Error::Invalid`] for an unknown place.
    pub fn placement(&self) -> Result<Placement> {
        let find = |name| Place::find(name).map_err(|error| Error::Invalid(error.to_string()));
        let place = (!self.place.is_empty()).then(|| find(&self.place)).transpose()?;
        let weather = (!self.weather.as_os_str().is_empty()).then(|| self.weather.clone());
        let Self { allow_external, control, keep_design_days, .. } = *self;
        Ok(Placement { place, weather, allow_external, control, keep_design_days, transition: None })
    }

    /// Returns the place or the name of the weather file, if the buildings are not where they are in the dataset.
    pub fn site_text(&self) -> Option<String> {
        let weather = self.weather.file_stem().map(|weather| weather.display().to_string());
        weather.or_else(|| (!self.place.is_empty()).then(|| self.place.clone()))
    }

    /// Returns the training buildings as text for readers.
    pub fn buildings_text(&self) -> String {
        if !self.building_type.is_empty() {
            let types = self.building_type.join(", ");
            let excluded = match &self.excluded_climate_zones[..] {
                [] => String::new(),
                zones => format!(" outside of the climate zones {}", zones.join(", ")),
            };
            let some = match self.type_buildings {
                0 => String::new(),
                count => format!("{count} each of "),
            };
            return format!("{some}{types} of the training split{excluded}");
        }
        let site = self.site_text().map_or_else(String::new, |site| format!(" in {site}"));
        // A model is named by its file name, not its path.
        let name = |text: &String| text.parse().map_or(text.clone(), |name: BuildingName| name.to_string());
        format!("{}{site}", self.buildings.iter().map(name).collect::<Vec<_>>().join(", "))
    }

    /// Shortens the days of an episode to the shortest run period, for a window that nobody chose.
    pub fn shorten_window(&mut self) {
        self.window_days = self.window_days.min(self.shortest_period());
    }

    /// Returns the days of the shortest run period; 0 if one is not valid.
    fn shortest_period(&self) -> u32 {
        self.periods().map_or(0, |periods| periods.into_iter().map(Period::days).min().unwrap_or(0))
    }

    /// Checks the values.
    pub(super) fn check(&self) -> Result<()> {
        self.named()?;
        self.building_types()?;
        self.check_site()?;
        self.periods()?;
        let days = self.shortest_period();
        require(self.window_days <= days, || {
            format!(
                "`window_days` is {}; the run period has {days} days: expected at most {days}, or 0 for the whole run period",
                self.window_days
            )
        })?;
        require(self.window_starts > 0, || "`window_starts` is 0; expected at least 1".into())?;
        require(self.building_episodes > 0, || "`building_episodes` is 0; expected at least 1".into())?;
        let draws = !self.building_type.is_empty() || self.fault_seeds > 0;
        require(draws || self.building_episodes == 1, || {
            format!(
                "`building_episodes` is {}, for a drawn `building_type` or `fault_seeds`; remove it",
                self.building_episodes
            )
        })?;
        require(
            self.fault_seeds == 0 || self.task.as_slice().iter().all(|task| !task.faults.is_none()),
            || {
                format!(
                    "`fault_seeds` is {} and a task has no faults; give the task faults, or remove it",
                    self.fault_seeds
                )
            },
        )?;
        self.check_turns()?;
        self.check_zones()
    }

    /// Checks the turns of types.
    fn check_turns(&self) -> Result<()> {
        let types = self.building_types()?;
        for (building_type, turns) in &self.type_turns {
            require(types.contains(building_type), || {
                let types = self.building_type.join(", ");
                format!("`type_turns` has `{building_type}`, which is not in `building_type` ({types})")
            })?;
            require(*turns > 0, || {
                format!("`type_turns` of {building_type} is 0; remove it from `building_type`")
            })?;
        }
        Ok(())
    }

    /// Checks which buildings are named or drawn, and where they are.
    fn check_site(&self) -> Result<()> {
        let is_placed = self.placement()? != Placement { control: self.control, ..Placement::default() };
        require(self.buildings.is_empty() != self.building_type.is_empty(), || {
            "expected either `buildings` or `building_type`".into()
        })?;
        require(!is_placed || !self.buildings.is_empty(), || {
            "`place`, `weather`, `keep_design_days` and `allow_external` are for `buildings`; remove them"
                .into()
        })?;
        require(self.place.is_empty() || self.weather.as_os_str().is_empty(), || {
            "expected either `place` or `weather`".into()
        })
    }

    /// Checks the excluded climate zones.
    fn check_zones(&self) -> Result<()> {
        let zones = &self.excluded_climate_zones;
        if zones.is_empty() {
            return Ok(());
        }
        require(!self.building_type.is_empty(), || {
            "`excluded_climate_zones` are for `building_type`; remove them".into()
        })?;
        let types = self.building_types()?;
        let has = |zone: &String| {
            types.iter().any(|each| b2b_dataset::rows(*each).iter().any(|row| row.is_in_climate_zone(zone)))
        };
        if let Some(zone) = zones.iter().find(|zone| !has(zone)) {
            let types = self.building_type.join(" or ");
            return Err(Error::Invalid(format!(
                "`excluded_climate_zones` has `{zone}`, which no {types} is in; expected an ASHRAE 169 zone, such as 5B, \
                 or a number, such as 5"
            )));
        }
        match types.iter().find(|each| self.drawn(**each).is_empty()) {
            Some(empty) => {
                Err(Error::Invalid(format!("`excluded_climate_zones` leave no {empty} to train on")))
            }
            None => Ok(()),
        }
    }
}
