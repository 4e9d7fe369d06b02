//! The features of an agent that supervises the sequences of Guideline 36: where the zones are in their bands, how the
//! bands change, what the sequences decided, weather, calendar, prices and the agent's previous action.

use b2b_building::hvac::{Packaged, Sequence, System};
use b2b_building::morphology::{NodeType, Observed, Owner};
use b2b_control::Controller;
use b2b_control::guideline36::{Mode, Shift};
use b2b_env::{DecisionSlot, Spaces, Target};

use super::feature::{Feature, Source};
use super::features::{energy, hours_and_seasons, temperature, weather};
use super::outdoor::OUTDOOR;
use crate::acting::Acting;
use crate::supervisor::Supervisor;

/// Hours ahead for which prices, outdoor temperatures and radiation are observed, if the task has a preview.
const AHEAD: [usize; 7] = [0, 1, 2, 4, 8, 12, 23];
/// Scale of electricity prices, currency/kWh.
const PRICE: f64 = 0.1;
/// Scale of solar radiation, W/m².
const SOLAR: f64 = 500.0;

/// Returns the features of a building.
pub(super) fn supervised(spaces: &Spaces, supervisor: &Supervisor) -> Vec<Feature> {
    let mut features = Vec::new();
    for (zone, slot) in spaces.controlled_zones().enumerate() {
        let name = &spaces.building.zones[slot].name;
        let of_zone = zone_features(spaces, zone, slot).into_iter();
        features.extend(of_zone.map(|(what, source)| Feature::new(format!("{name} {what}"), source)));
    }
    let space = &spaces.observation;
    let of_weather = weather(space.outdoor_temperature(), space.outdoor_humidity());
    features.extend(of_weather.map(|(name, source)| Feature::new(name, source)));
    let of_calendar = hours_and_seasons(space.time_of_day(), space.day_of_week(), space.day_of_year());
    features.extend(of_calendar.into_iter().map(|(name, source)| Feature::new(name, source)));
    let of_energy = energy(space.electricity(), space.gas(), spaces.episode.steps_per_hour);
    features.extend(of_energy.map(|(name, source)| Feature::new(name, source)));
    features.extend(preview(spaces));
    let decisions = supervisor.guideline().record().map_or(&[][..], |decisions| decisions.slots());
    features.extend(decisions.iter().enumerate().flat_map(|(number, slot)| decided(number, slot)));
    for (action, name) in supervisor.names().iter().enumerate() {
        features.push(Feature::new(format!("{name} previous"), Source::Previous(action)));
    }
    features
}

/// Returns the features of a controlled zone, given its index among the controlled zones and the slot of its
/// temperature.
fn zone_features(spaces: &Spaces, zone: usize, slot: usize) -> Vec<(&'static str, Source)> {
    let space = &spaces.observation;
    let mut features = vec![("change/0.1K", Source::Change { slot, scale: 0.1, limit: 3.0 })];
    let occupied = |slot| Source::Bounded { slot, low: 0.0, high: 1.0 };
    features.extend(space.occupancy(zone).map(|slot| ("occupancy", occupied(slot))));
    let mut side = |names: [&'static str; 2], setpoint: usize, cooling: bool| {
        let gap = Source::Difference { slot, less: setpoint, scale: 2.0, limit: 3.0 };
        let next = Source::NextSetpoint { zone, slot: setpoint, cooling, scale: 5.0, limit: 3.0 };
        features.extend(names.into_iter().zip([gap, next]));
    };
    match space.target(zone) {
        Target::Between([heating, cooling]) => {
            side(["above heating setpoint/2K", "next heating setpoint/5K"], heating, false);
            side(["above cooling setpoint/2K", "next cooling setpoint/5K"], cooling, true);
        }
        Target::Slot(target) => {
            side(["above heating setpoint/2K", "next heating setpoint/5K"], target, false);
        }
        Target::Always(_) => features.push(("temperature", temperature(slot))),
    }
    if !matches!(space.target(zone), Target::Always(_)) {
        features.push(("change ahead", Source::ChangeAhead { zone }));
    }
    features
}

/// A quantity of the preview, with a slot for each of the next hours.
struct Ahead {
    quantity: Observed,
    name: &'static str,
    center: f64,
    scale: f64,
}

const PRICES: Ahead = Ahead { quantity: Observed::PriceAhead, name: "price", center: 0.0, scale: PRICE };
const TEMPERATURES: Ahead = Ahead {
    quantity: Observed::OutdoorTemperatureAhead,
    name: "outdoor temperature",
    center: OUTDOOR.0,
    scale: OUTDOOR.1,
};
const RADIATION: Ahead =
    Ahead { quantity: Observed::SolarAhead, name: "solar radiation", center: 0.0, scale: SOLAR };

impl Ahead {
    /// Returns the names of its features, with their sources in a task with a preview.
    fn features(self, spaces: Option<&Spaces>) -> impl Iterator<Item = (String, Option<Source>)> {
        let Self { quantity, name, center, scale } = self;
        let slots = spaces.map_or(&[][..], |spaces| spaces.observation.slots()).iter().enumerate();
        let own: Vec<usize> =
            slots.filter(|(_, slot)| slot.quantity == quantity).map(|(index, _)| index).collect();
        AHEAD.into_iter().map(move |hours| {
            let slot = own.get(hours);
            let source = slot.map(|slot| Source::Deviation { slot: *slot, center, scale, limit: 10.0 });
            (format!("{name} in {hours} h"), source)
        })
    }
}

/// Returns the features of prices and weather ahead; none if the task has no preview.
fn preview(spaces: &Spaces) -> impl Iterator<Item = Feature> {
    let all = [PRICES, TEMPERATURES, RADIATION].into_iter();
    let features = all.flat_map(|ahead| ahead.features(Some(spaces)));
    features.filter_map(|(name, source)| Some(Feature::new(name, source?)))
}

/// Returns the features of a node's preview, 0 without a preview: prices at the energy node, weather at the weather
/// node.
pub(super) fn node_preview(
    node_type: NodeType,
    node: Option<&SupervisedNode<'_>>,
) -> impl Iterator<Item = (String, Source)> {
    let ahead = match node_type {
        NodeType::Energy => vec![PRICES],
        NodeType::Weather => vec![TEMPERATURES, RADIATION],
        _ => Vec::new(),
    };
    let spaces = node.map(|node| node.spaces);
    let features = ahead.into_iter().flat_map(move |ahead| ahead.features(spaces));
    features.map(|(name, source)| (name, source.unwrap_or(Source::Constant(0.0))))
}

/// Returns the features of a decision of the sequences: one per mode, or the scaled value. Flow rates are left out, and
/// so are zone setpoints in use, which follow from the band and the last shifts.
fn decided(number: usize, slot: &DecisionSlot) -> Vec<Feature> {
    if !slot.states.is_empty() {
        let mode = |(index, state): (usize, &&str)| {
            let source = Source::DecisionIs { decision: number, value: (index + 1) as f64 };
            Feature::new(format!("{}: {state}", slot.name), source)
        };
        return Mode::NAMES.iter().enumerate().map(mode).collect();
    }
    let (center, scale) = match slot.unit {
        "°C" if slot.zone.is_some() => return Vec::new(),
        "°C" => (18.0, 10.0),
        "kg/s" => return Vec::new(),
        _ => (0.0, 1.0),
    };
    let source = Source::Decision { decision: number, center, scale, limit: 3.0 };
    vec![Feature::new(slot.name.clone(), source)]
}

/// The node of a graph that a supervisor observes and shifts.
pub(super) struct SupervisedNode<'a> {
    spaces: &'a Spaces,
    supervisor: &'a Supervisor,
    owner: Owner,
}

impl<'a> SupervisedNode<'a> {
    pub(super) fn new(spaces: &'a Spaces, supervisor: &'a Supervisor, owner: Owner) -> Self {
        Self { spaces, supervisor, owner }
    }

    /// Returns the index of a decision of the sequences, given its name without the node's name.
    fn decision(&self, what: &str) -> Option<usize> {
        let building = &self.spaces.building;
        let name = match self.owner {
            Owner::Zone(zone) if what.ends_with(" loop") => Some(building.zones[zone].name.as_str()),
            Owner::Zone(_) => self.unit().map(|unit| unit.name()),
            Owner::AirLoop(own) => building.laid_out_systems().nth(own).map(|(system, _)| system.name()),
            _ => None,
        };
        let name = format!("{} {what}", name?);
        self.supervisor.guideline().record()?.slots().iter().position(|slot| slot.name == name)
    }

    /// Returns the system of a zone, if it has one of its own.
    fn unit(&self) -> Option<&'a dyn System> {
        let Owner::Zone(zone) = self.owner else { return None };
        let mut systems = self.spaces.building.laid_out_systems();
        systems
            .find(|(system, layout)| !system.has_air_handler() && layout.zones[0].index == zone)
            .map(|(system, _)| system)
    }

    fn packaged(&self) -> Option<Packaged> {
        match self.unit()?.sequence() {
            Sequence::SingleZone { packaged, .. } => Some(packaged),
            _ => None,
        }
    }

    /// Returns the index of a shift's action.
    fn action(&self, shift: Shift) -> Option<usize> {
        let points = self.supervisor.points();
        points.zip(0..).find(|(point, _)| point.owner == self.owner && point.shift == shift).map(|(_, at)| at)
    }

    fn zone_features(&self) -> Vec<(&'static str, Source)> {
        let mut zones = self.spaces.controlled_zones().enumerate();
        let own = zones.find(|(_, slot)| self.owner == Owner::Zone(*slot));
        own.map_or_else(Vec::new, |(zone, slot)| zone_features(self.spaces, zone, slot))
    }
}

/// Returns the attributes of a node that the sequences know: whether its unit heats with a heat pump, whose efficiency
/// falls with less air, and whether it has an economizer.
pub(super) fn equipment(
    node_type: NodeType,
    node: Option<&SupervisedNode<'_>>,
) -> impl Iterator<Item = (String, Source)> {
    let packaged = node.and_then(SupervisedNode::packaged).unwrap_or_default();
    let attributes = [("heat pump", packaged.heat_pump.is_some()), ("economizer", packaged.economizer)];
    let attributes = attributes.into_iter().filter(move |_| node_type == NodeType::UnitaryZone);
    attributes.map(|(name, is_so)| (name.to_owned(), Source::Constant(f64::from(u8::from(is_so)))))
}

/// Names of the features of a controlled zone with both setpoints.
const ZONE_FEATURES: [&str; 7] = [
    "change/0.1K",
    "occupancy",
    "above heating setpoint/2K",
    "next heating setpoint/5K",
    "above cooling setpoint/2K",
    "next cooling setpoint/5K",
    "change ahead",
];

/// Returns the shifts of a node type that an agent sets; a node of the type may lack some.
pub(super) fn set_shifts(acting: Acting, node_type: NodeType) -> impl Iterator<Item = Shift> {
    node_shifts(node_type).into_iter().filter(move |shift| acting.sets(*shift))
}

/// Returns all shifts of a node type.
pub(super) fn node_shifts(node_type: NodeType) -> Vec<Shift> {
    match node_type {
        NodeType::AirLoop => Shift::AIR_LOOP.to_vec(),
        NodeType::UnitaryZone => [Shift::UNIT, Shift::ZONE].concat(),
        NodeType::VavZone | NodeType::DamperZone | NodeType::HeatingOnlyZone | NodeType::SetpointZone => {
            Shift::ZONE.to_vec()
        }
        NodeType::Weather
        | NodeType::Calendar
        | NodeType::Energy
        | NodeType::UncontrolledZone
        | NodeType::FollowingZone => Vec::new(),
    }
}

/// Returns the features of an air handler or of a controlled zone, in an order that only depends on its type and on
/// what the agent shifts. What a node lacks is 0. Without a node, only the names count.
///
/// The weather is among them, although it has a node: what saves with cold air outside costs with warm air, and an
/// agent that learns of it from the weather's node alone often does not tell them apart.
pub(super) fn node_features(
    acting: Acting,
    node_type: NodeType,
    node: Option<&SupervisedNode<'_>>,
) -> Vec<(String, Source)> {
    let is_zone = node_type != NodeType::AirLoop;
    let own = node.map_or_else(Vec::new, SupervisedNode::zone_features);
    let of_zone = |name: &str| own.iter().find(|(known, _)| *known == name).map(|(_, source)| *source);
    let decided = |what: &str, source: &dyn Fn(usize) -> Source| {
        node.and_then(|node| node.decision(what)).map_or(Source::Constant(0.0), source)
    };
    let mut features: Vec<(String, Source)> = Vec::new();
    if is_zone {
        let known = |name: &str| (name.to_owned(), of_zone(name).unwrap_or(Source::Constant(0.0)));
        features.extend(ZONE_FEATURES.map(known));
    }
    if node_type != NodeType::VavZone {
        features.extend(Mode::NAMES.iter().zip(1..).map(|(mode, value)| {
            let is_on = move |decision| Source::DecisionIs { decision, value: f64::from(value) };
            (format!("mode: {mode}"), decided("mode", &is_on))
        }));
    }
    let scaled: &[(&str, f64, f64)] = match is_zone {
        true => &[("heating loop", 0.0, 1.0), ("cooling loop", 0.0, 1.0)],
        false => &[
            ("supply air temperature setpoint", 18.0, 10.0),
            ("t_max", 18.0, 10.0),
            ("cooling requests", 0.0, 1.0),
            ("economizer enabled", 0.0, 1.0),
        ],
    };
    features.extend(scaled.iter().map(|&(what, center, scale)| {
        let source = move |decision| Source::Decision { decision, center, scale, limit: 3.0 };
        (what.to_owned(), decided(what, &source))
    }));
    let [outdoor, humidity] = node.map_or([0, 0], |node| {
        let space = &node.spaces.observation;
        [space.outdoor_temperature(), space.outdoor_humidity()]
    });
    let of_weather = weather(outdoor, humidity).into_iter();
    features.extend(of_weather.map(|(name, source)| (name.to_owned(), source)));
    features.extend(set_shifts(acting, node_type).map(|shift| {
        let action = node.and_then(|node| node.action(shift));
        (format!("{} previous", shift.described().0), action.map_or(Source::Constant(0.0), Source::Previous))
    }));
    features
}
