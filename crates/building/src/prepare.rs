//! Preparation of a model for control.

mod calendar;
mod episode_edits;
mod make_up_air;

use std::path::Path;

use b2b_base::calendar::Calendar;
use b2b_base::carrier::Carrier;
use b2b_base::digest::sha256;
use b2b_climate::Site;
use b2b_energyplus::Library;
use serde::{Deserialize, Serialize};
use serde_json::json;

use self::episode_edits::{Exhaust, for_episodes};
use crate::band::{self, Year};
use crate::hvac::{
    self, Actuator, Discovery, EngineVariable, KINDS, Kind, Switch, System, SystemLayout, Uncontrolled,
    Unsupported,
};
use crate::hvac_energy::{self, HvacMeter, hvac_meters};
use crate::import::{Notes, switched_off, without_band};
use crate::model::{Model, floors};
use crate::run_period::RunPeriod;
use crate::sizing::{self, Sizes, Unreported};
use crate::zone;
use crate::{Class, Error, Result, ZoneYear};

/// A building prepared for control: hard-sized, with controllable systems and without output files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedBuilding {
    /// Name, for example `OfficeSmall`.
    pub name: String,
    /// Its class; `None` for a user's model, or if it was not set.
    pub class: Option<Class>,
    /// Whether it is an unmodified prototype that ships with the engine, rather than a generated building.
    pub prototype: bool,
    /// The model: [`PreparedBuilding::model_for`] gives it a run period.
    model: Model,
    /// SHA-256 of the model, kept after the model is dropped.
    pub model_sha256: String,
    /// Every zone, in model order.
    pub zones: Vec<Zone>,
    /// The controlled systems, in the order of the action.
    pub systems: Vec<Box<dyn System>>,
    /// Places of the systems in the action and in the zones, in the same order.
    layouts: Vec<SystemLayout>,
    /// Systems and equipment without actuators of their own, with the reason; empty except for imported buildings.
    pub uncontrolled: Vec<Uncontrolled>,
    /// Floor area of the conditioned zones, m², by which energy is normalized. It includes zones under their own
    /// controls, because energy covers all HVAC.
    pub conditioned_floor_area: f64,
    /// The engine's meters of HVAC energy, electricity and natural gas first.
    pub meters: Vec<HvacMeter>,
    /// The calendar of a user's model; `None` for a generated building, which stays in its year of 365 days.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    calendar: Option<Calendar>,
    /// The days of each zone according to its own schedules, in the order of the zones.
    #[serde(default)]
    pub years: Vec<ZoneYear>,
    /// Days, from 1 on 1 January of the first year and in order, that the model declares special, such as holidays: its
    /// schedules do not follow their day of the week.
    #[serde(default)]
    pub holidays: Vec<u32>,
    /// Outdoor air that the model controls: of the systems of a building under its own controls, and of air loops whose
    /// zones are controlled through their thermostats.
    #[serde(default)]
    own_ventilation: Vec<Option<OutdoorAir>>,
    /// How a user's model was read and sized.
    #[serde(default)]
    pub notes: Notes,
}

/// The outdoor air of a system.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutdoorAir {
    /// Its design minimum, its damper and its flow.
    pub ventilation: hvac::Ventilation,
    /// Its zones, as indices of controlled zones.
    pub zones: Vec<usize>,
}

/// Who controls a prepared building.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Controls {
    /// An agent or controller that sets the actuators of its systems.
    #[default]
    Actuators,
    /// An agent or controller that sets the heating and the cooling setpoint of every zone. The model's own equipment
    /// follows them.
    Setpoints,
    /// The thermostats and schedules of the original model. There are no actuators.
    Own,
}

impl Controls {
    /// Suffix of the names of buildings under [`Controls::Setpoints`].
    pub const SETPOINTS_SUFFIX: &'static str = "+setpoints";

    /// Returns the name of a building, which is the same under all controls.
    pub fn common_name(building: &str) -> &str {
        building.strip_suffix(Self::SETPOINTS_SUFFIX).unwrap_or(building)
    }
}

/// A zone of a prepared building.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zone {
    /// Name.
    pub name: String,
    /// Floor area with multiplier, m².
    pub floor_area: f64,
    /// Number of identical zones.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub multiplier: f64,
    /// Heating and cooling capability of its controlled equipment.
    pub conditioning: Conditioning,
    /// Whether uncontrolled equipment conditions it, by the thermostat and schedules of the model. Such a zone is
    /// observed but does not count in the reward.
    pub own_controls: bool,
}

const fn one() -> f64 {
    1.0
}

fn is_one(multiplier: &f64) -> bool {
    *multiplier == one()
}

/// The heating and cooling capability of the controlled equipment of a zone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Conditioning {
    /// Nothing, as in an attic or a plenum.
    None,
    /// Heat only.
    Heating,
    /// Heat and cool.
    HeatingAndCooling,
}

impl PreparedBuilding {
    /// Sizes a model for a weather file, then makes every system controllable.
    ///
    /// # Errors
    /// [`Error::Unsupported`] naming the object that cannot be made controllable; [`Error::NothingToControl`];
    /// [`Error::Engine`] when the engine rejects the model.
    pub fn new(name: &str, model: Model, weather: &Path, library: &Library) -> Result<Self> {
        Self::with_kinds(name, model, weather, library, &KINDS, Unsupported::Refused)
    }

    /// Like [`PreparedBuilding::new`], but a system that cannot be made controllable is not controlled and is listed in
    /// [`PreparedBuilding::uncontrolled`]. For users' models: see [`crate::import`].
    ///
    /// # Errors
    /// Same as [`PreparedBuilding::new`], without [`Error::Unsupported`].
    pub fn as_far_as_possible(name: &str, model: Model, weather: &Path, library: &Library) -> Result<Self> {
        Self::with_kinds(name, model, weather, library, &KINDS, Unsupported::LeftAlone)
    }

    /// Like [`PreparedBuilding::new`] or [`PreparedBuilding::as_far_as_possible`], with systems of these kinds. Only a
    /// building of the [`KINDS`] of this crate can be read from a file.
    ///
    /// # Errors
    /// Same as [`PreparedBuilding::new`].
    pub fn with_kinds(
        name: &str,
        mut model: Model,
        weather: &Path,
        library: &Library,
        kinds: &[Kind],
        unsupported: Unsupported,
    ) -> Result<Self> {
        let (air_density, mut notes) = size(name, &mut model, weather, library, unsupported)?;
        notes.changed = changes(&model, weather, unsupported, Exhaust::Balanced)?;
        let switches = match unsupported {
            Unsupported::LeftAlone => hvac::switches_of_all(&model)?,
            Unsupported::Refused => Vec::new(),
        };
        let calendar = calendar::of(&model, weather, unsupported)?;
        let Year { zones: years, holidays, off } = year(name, &model, &switches, calendar, library)?;
        let absent = hvac::absent(&switches, off.iter().map(|off| off.share));
        let discovery = hvac::discover(&mut model, air_density, kinds, unsupported, &absent)?;
        notes.switched_off = switched_off(&switches, &off, &discovery);
        notes.changed.extend_from_slice(&discovery.notes);
        Ok(Self { calendar, holidays, notes, ..Self::with(name, model, discovery, Exhaust::Balanced)? }
            .of_years(years))
    }

    /// Prepares a model whose zones are controlled through the setpoints of their thermostats, and nothing else.
    /// `complete` adds controls that the model lacks; it is given the years of the zones.
    ///
    /// # Errors
    /// [`Error::NothingToControl`]; [`Error::Engine`] when the engine rejects the model.
    pub fn under_setpoints(
        name: &str,
        mut model: Model,
        weather: &Path,
        library: &Library,
        unsupported: Unsupported,
        complete: impl FnOnce(&mut Model, &[ZoneYear]),
    ) -> Result<Self> {
        let (air_density, mut notes) = size(name, &mut model, weather, library, unsupported)?;
        notes.changed = changes(&model, weather, unsupported, Exhaust::Balanced)?;
        let calendar = calendar::of(&model, weather, unsupported)?;
        let Year { zones: years, holidays, .. } = year(name, &model, &[], calendar, library)?;
        complete(&mut model, &years);
        let discovery = hvac::discover_setpoints(&mut model, air_density)?;
        notes.changed.extend_from_slice(&discovery.notes);
        Ok(Self { calendar, holidays, notes, ..Self::with(name, model, discovery, Exhaust::Predicted)? }
            .of_years(years))
    }

    /// Prepares a model that keeps its own controls. The building has the same zones, meters and years as when it is
    /// controlled, but no actuators. `complete` adds controls that the model lacks; it receives the years of the zones.
    ///
    /// # Errors
    /// Same as [`PreparedBuilding::new`] or [`PreparedBuilding::as_far_as_possible`].
    pub fn under_own_controls(
        name: &str,
        mut model: Model,
        weather: &Path,
        library: &Library,
        unsupported: Unsupported,
        complete: impl FnOnce(&mut Model, &[ZoneYear]),
    ) -> Result<Self> {
        let (_, mut notes) = size(name, &mut model, weather, library, unsupported)?;
        let exhaust = match unsupported {
            Unsupported::Refused => Exhaust::Predicted,
            Unsupported::LeftAlone => Exhaust::AsGiven,
        };
        notes.changed = changes(&model, weather, unsupported, exhaust)?;
        let controlled = Self::with_kinds(name, model.clone(), weather, library, &KINDS, unsupported)?;
        notes.warnings.extend_from_slice(&controlled.notes.warnings);
        complete(&mut model, &controlled.years);
        for_episodes(&mut model, exhaust);
        Ok(Self {
            model_sha256: sha256(model.to_epjson()),
            meters: hvac_meters(&model),
            model,
            own_ventilation: controlled.outdoor_air().map(without_damper).collect(),
            systems: Vec::new(),
            layouts: Vec::new(),
            notes,
            ..controlled
        })
    }

    /// Completes a sized model whose systems have been made controllable.
    fn with(name: &str, mut model: Model, discovery: Discovery, exhaust: Exhaust) -> Result<Self> {
        if discovery.systems.is_empty() {
            return Err(Error::NothingToControl { name: name.to_owned(), reasons: discovery.reasons() });
        }
        let Discovery { systems, uncontrolled, outdoor_air, .. } = discovery;
        for_episodes(&mut model, exhaust);
        let zones = zone::zones(&model)?;
        let names: Vec<&str> = zones.iter().map(|zone| zone.name.as_str()).collect();
        let layouts = SystemLayout::of_all(&systems, &names)?;
        let own_ventilation = own_ventilation(outdoor_air, &zones, &layouts);
        let zones = prepared_zones(&model, zones, &systems, &layouts)?;
        let meters = hvac_meters(&model);
        Ok(Self {
            name: name.to_owned(),
            class: None,
            prototype: false,
            model_sha256: sha256(model.to_epjson()),
            model,
            conditioned_floor_area: conditioned_floor_area(name, &zones)?,
            zones,
            systems,
            layouts,
            uncontrolled,
            meters,
            calendar: None,
            years: Vec::new(),
            holidays: Vec::new(),
            own_ventilation,
            notes: Notes::default(),
        })
    }

    /// Sets the years of its zones, with warnings for a user's model if zones lack a comfort band or water heaters heat
    /// rooms.
    fn of_years(mut self, years: Vec<ZoneYear>) -> Self {
        if self.calendar.is_some() {
            self.notes.warnings.extend(without_band(&self.zones, &years));
            self.notes.warnings.extend(hvac_energy::heating_tanks(&self.model));
        }
        Self { years, ..self }
    }

    /// Returns the outputs of fans outside systems, such as a bathroom's, by zone, J. The engine's meter of fans
    /// includes them, HVAC energy does not. The engine may lack some.
    pub fn fans_outside(&self) -> impl Iterator<Item = EngineVariable> {
        let of_zones = |output: &'static str| {
            self.zones
                .iter()
                .map(move |zone| EngineVariable { name: output.to_owned(), key: zone.name.clone() })
        };
        hvac_energy::fans_outside(&self.model, &self.meters).into_iter().flat_map(of_zones)
    }

    /// Drops the model, which takes ten times the memory of the rest, once environments have been built from it.
    pub fn drop_model(&mut self) {
        self.model = Model::default();
    }

    /// Sets its class.
    #[must_use]
    pub fn of_class(self, class: Option<Class>) -> Self {
        Self { class, ..self }
    }

    /// Adds the notes of its import.
    #[must_use]
    pub fn with_notes(self, notes: Notes) -> Self {
        let Notes { left_autosized, unused_autosized, changed, switched_off, warnings, .. } = self.notes;
        let warnings = notes.warnings.into_iter().chain(warnings).collect();
        Self {
            notes: Notes { left_autosized, unused_autosized, changed, switched_off, warnings, ..notes },
            ..self
        }
    }

    /// Returns the model for a run period with this number of zone time steps per hour.
    pub fn model_for(&self, period: RunPeriod, steps_per_hour: u32) -> Model {
        let mut model = self.model.clone();
        model.remove_class("Timestep");
        model.insert("Timestep", "Timestep 1", json!({"number_of_timesteps_per_hour": steps_per_hour}));
        model.remove_class("RunPeriod");
        model.insert("RunPeriod", "Episode", self.in_its_calendar(period).to_epjson(&self.model));
        model
    }

    /// Returns the prepared model, without a run period.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the actuators, in the order of the action.
    pub fn actuators(&self) -> impl Iterator<Item = &Actuator> {
        self.systems.iter().flat_map(|system| system.actuators())
    }

    /// Returns the energy carriers used by its HVAC.
    pub fn carriers(&self) -> impl Iterator<Item = Carrier> {
        Carrier::ALL.into_iter().filter(|carrier| self.meters.iter().any(|meter| meter.carrier == *carrier))
    }

    /// Returns the layouts of the systems, in the same order.
    pub fn layouts(&self) -> &[SystemLayout] {
        &self.layouts
    }

    /// Returns the systems with their layouts, in the order of the action.
    pub fn laid_out_systems(&self) -> impl Iterator<Item = (&dyn System, &SystemLayout)> {
        self.systems.iter().map(|system| &**system).zip(&self.layouts)
    }

    /// Returns the outdoor air of each system, if it has any, and then that which the model controls.
    pub fn outdoor_air(&self) -> impl Iterator<Item = Option<OutdoorAir>> {
        let of_system = |(system, layout): (&dyn System, &SystemLayout)| {
            let zones = layout.zones.iter().map(|zone| zone.controlled).collect();
            Some(OutdoorAir { ventilation: system.ventilation()?.clone(), zones })
        };
        self.laid_out_systems().map(of_system).chain(self.own_ventilation.iter().cloned())
    }

    /// Returns the controlled zones, in model order.
    pub fn controlled_zones(&self) -> impl Iterator<Item = &Zone> {
        self.zones.iter().filter(|z| z.conditioning != Conditioning::None)
    }
}

/// Writes sizes into a model. Returns the air density of its design flows, kg/m³, and notes on the autosized fields
/// without a size.
fn size(
    name: &str,
    model: &mut Model,
    weather: &Path,
    library: &Library,
    unsupported: Unsupported,
) -> Result<(f64, Notes)> {
    if unsupported == Unsupported::LeftAlone {
        floors::enter(model);
    }
    let site = Site::read(weather)?;
    let mut notes = Notes::default();
    if sizing::needs_sizing(model) {
        let sizes = Sizes::of(model, weather, library)
            .map_err(|error| error.on_model(name).while_doing(format!("sizing {name}")))?;
        let Unreported { left, unused } = sizes.write_into(model);
        notes.left_autosized = left;
        notes.unused_autosized = unused;
    }
    Ok((standard_air_density(site.elevation), notes))
}

/// Returns what the edits for episodes change in a user's model; nothing for a generated building.
fn changes(model: &Model, weather: &Path, unsupported: Unsupported, exhaust: Exhaust) -> Result<Vec<String>> {
    match unsupported {
        Unsupported::Refused => Ok(Vec::new()),
        Unsupported::LeftAlone => Ok(episode_edits::changes(model, &Site::read(weather)?, exhaust)),
    }
}

/// Air density that the engine assumes for design flows, kg/m³: dry air at 20 °C at the standard pressure of the
/// elevation (m) in the weather file.
pub fn standard_air_density(elevation: f64) -> f64 {
    // Standard atmosphere and ideal gas law with the engine's constants (Engineering Reference,
    // "Psychrometric Services").
    let pressure = 101_325.0 * libm::pow(1.0 - 2.25577e-05 * elevation, 5.2559);
    pressure / (287.0 * (20.0 + 273.15))
}

/// Returns the zones of a model with the capabilities of their systems.
fn prepared_zones(
    model: &Model,
    zones: Vec<zone::Zone>,
    systems: &[Box<dyn System>],
    layouts: &[SystemLayout],
) -> Result<Vec<Zone>> {
    let conditioning = |zone: usize| match systems.iter().zip(layouts).find(|(_, layout)| layout.serves(zone))
    {
        None => Conditioning::None,
        Some((system, _)) => system.conditioning(),
    };
    let prepared = |(index, zone): (usize, zone::Zone)| {
        let conditioning = conditioning(index);
        let own_controls = conditioning == Conditioning::None && hvac::has_own_controls(model, &zone.name)?;
        Ok(Zone {
            conditioning,
            own_controls,
            floor_area: zone.floor_area * zone.multiplier,
            multiplier: zone.multiplier,
            name: zone.name,
        })
    };
    zones.into_iter().enumerate().map(prepared).collect()
}

/// Returns the floor area of the conditioned zones, m².
fn conditioned_floor_area(name: &str, zones: &[Zone]) -> Result<f64> {
    let conditioned = |zone: &&Zone| zone.conditioning != Conditioning::None || zone.own_controls;
    let area: f64 = zones.iter().filter(conditioned).map(|zone| zone.floor_area).sum();
    if area > 0.0 { Ok(area) } else { Err(Error::NoFloorArea { name: name.to_owned() }) }
}

/// Returns the outdoor air of air loops with controlled zones, given the zones that each serves.
fn own_ventilation(
    loops: Vec<(hvac::Ventilation, Vec<String>)>,
    zones: &[zone::Zone],
    layouts: &[SystemLayout],
) -> Vec<Option<OutdoorAir>> {
    let controlled = |name: &String| {
        let index = zones.iter().position(|zone| zone.name.eq_ignore_ascii_case(name))?;
        let served = layouts.iter().flat_map(|layout| &layout.zones).find(|served| served.index == index)?;
        Some(served.controlled)
    };
    let of_loop = |(ventilation, served): (hvac::Ventilation, Vec<String>)| {
        let zones: Vec<usize> = served.iter().filter_map(controlled).collect();
        (!zones.is_empty()).then_some(Some(OutdoorAir { ventilation, zones }))
    };
    loops.into_iter().filter_map(of_loop).collect()
}

/// Returns the outdoor air of a system whose damper is controlled by the model.
fn without_damper(air: Option<OutdoorAir>) -> Option<OutdoorAir> {
    air.map(|OutdoorAir { ventilation, zones }| OutdoorAir {
        ventilation: hvac::Ventilation { damper: None, ..ventilation },
        zones,
    })
}

/// Returns the years of a sized model.
fn year(
    name: &str,
    model: &Model,
    switches: &[Switch],
    calendar: Option<Calendar>,
    library: &Library,
) -> Result<Year> {
    let zones = zone::zones(model)?;
    let names: Vec<&str> = zones.iter().map(|zone| zone.name.as_str()).collect();
    let switches: Vec<&str> = switches.iter().map(|switch| switch.schedule.as_str()).collect();
    let year = band::year(name, model, &names, &switches, calendar, library);
    year.map_err(|error| error.on_model(name).while_doing(format!("reading the schedules of {name}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energy_is_not_divided_by_a_floor_area_of_zero() {
        let zone = |floor_area, own_controls| {
            let (name, conditioning) = ("Hall".to_owned(), Conditioning::None);
            Zone { name, floor_area, multiplier: 1.0, conditioning, own_controls }
        };
        let area = |zones: &[Zone]| conditioned_floor_area("office", zones);
        assert_eq!(area(&[zone(20.0, true), zone(30.0, false)]).unwrap(), 20.0);
        let said = area(&[zone(0.0, true), zone(30.0, false)]).unwrap_err().to_string();
        assert!(said.contains("office") && said.contains("`floor_area`"), "{said}");
    }

    #[test]
    fn the_air_density_of_denver_and_miami_matches_the_engine() {
        // The engine's own figures for the weather files of Denver (1726 m) and Miami (11 m).
        assert!((standard_air_density(1726.0) - 0.977).abs() < 5e-4);
        assert!((standard_air_density(11.0) - 1.203).abs() < 5e-4);
    }
}
