//! The interface of a system under control. Each kind implements it in a file or folder of its own.

use std::any::Any;
use std::fmt::Debug;

use serde::de::DeserializeOwned;
use serde::ser::Error as _;
use serde::{Serialize, Serializer};
use serde_json::Value;

use super::actuator::Actuator;
use super::candidate::Candidate;
use super::capacity::SystemEquipment;
use super::sequence::Sequence;
use super::ventilation::Ventilation;
use crate::morphology::universe::NodeType;
use crate::{Conditioning, Model, Result};

/// A group of actuators that act together on their zones.
///
/// Zones and actuators are numbered within the system: its zones in the order of [`System::zones`], its actuators in
/// the order of [`System::actuators`], which is the action's.
pub trait System: Object + Debug + Send + Sync {
    /// Name: its air loop or its zone.
    fn name(&self) -> &str;

    /// Names of the zones that it serves.
    fn zones(&self) -> Vec<&str>;

    /// The number of its first zones whose temperatures its actuators control; the others share what these get.
    fn zones_with_loops(&self) -> usize {
        self.zones().len()
    }

    /// Actuators, in the order of the action.
    fn actuators(&self) -> Vec<&Actuator>;

    /// The zone to which an actuator belongs; `None` for the air handler that several zones share.
    fn zone_of(&self, _actuator: usize) -> Option<usize> {
        Some(0)
    }

    /// Heating and cooling capability in its zones.
    fn conditioning(&self) -> Conditioning {
        Conditioning::HeatingAndCooling
    }

    /// The node type of one of its zones in the [morphology](crate::morphology), with the quantities of its actuators
    /// there.
    fn node_type(&self, zone: usize) -> NodeType;

    /// Its outdoor air, if it has any.
    fn ventilation(&self) -> Option<&Ventilation> {
        None
    }

    /// Lower limits of its actions that ensure the design minimum of outdoor air, each with the number of the actuator.
    fn outdoor_air_limits(&self) -> Vec<(usize, f64)> {
        Vec::new()
    }

    /// The flows that its actuators share, if they share any.
    fn shared_flow(&self) -> Option<SharedFlow> {
        None
    }

    /// Writes the action of the warm-up period, which brings zones near their targets with a proportional rule. It is
    /// part of the definition of an environment: every episode starts in the same state for every agent. Must not
    /// allocate.
    fn warm_up(&self, zone: &dyn Fn(usize) -> ZoneState, action: &mut [f64]);

    /// The sequence of operation by which rule-based controllers control it.
    fn sequence(&self) -> Sequence<'_>;

    /// Design flows and capacities, from the model. By default the capacities of its zone's equipment, without air
    /// flow.
    ///
    /// # Errors
    /// [`crate::Error::MissingObject`] for a dangling reference.
    fn equipment(&self, model: &Model) -> Result<SystemEquipment> {
        SystemEquipment::of_zone(model, self.name())
    }
}

/// Name of a kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KindName {
    /// Identifier in files, for example `air_loop`.
    pub id: &'static str,
    /// Name, for example `air loop`.
    pub name: &'static str,
    /// Name of several, for example `air loops`.
    pub plural: &'static str,
}

impl Serialize for KindName {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.id)
    }
}

/// How a kind of systems is found in a model.
pub trait FromModel: System + Clone + PartialEq + Serialize + DeserializeOwned + 'static {
    /// Name of the kind.
    const NAME: KindName;

    /// Returns whether this kind controls a candidate. The first of the kinds that does is used.
    ///
    /// # Errors
    /// [`crate::Error::MissingObject`] for a dangling reference.
    fn claims(model: &Model, candidate: Candidate<'_>) -> Result<bool>;

    /// Makes a candidate of a hard-sized model controllable. `air_density`, kg/m³, turns design volume flows into mass
    /// flows.
    ///
    /// # Errors
    /// [`crate::Error::Unsupported`] naming the object that cannot be made controllable;
    /// [`crate::Error::MissingObject`] for a dangling reference.
    fn make_controllable(model: &mut Model, candidate: Candidate<'_>, air_density: f64) -> Result<Self>;
}

/// What every system can do as an object; implemented for all kinds.
pub trait Object {
    /// Returns the name of its kind.
    fn kind(&self) -> KindName;

    /// Returns it for conversion to its type.
    fn as_any(&self) -> &dyn Any;

    /// Returns it for conversion to its type.
    fn as_any_mut(&mut self) -> &mut dyn Any;

    /// Returns a copy.
    fn to_box(&self) -> Box<dyn System>;

    /// Returns its fields as JSON.
    ///
    /// # Errors
    /// The errors of [`serde_json::to_value`].
    fn to_json(&self) -> serde_json::Result<Value>;

    /// Returns whether another system is the same.
    fn equals(&self, other: &dyn System) -> bool;
}

impl<T: FromModel> Object for T {
    fn kind(&self) -> KindName {
        T::NAME
    }

    fn as_any(&self) -> &dyn Any {
        self
    }

    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }

    fn to_box(&self) -> Box<dyn System> {
        Box::new(self.clone())
    }

    fn to_json(&self) -> serde_json::Result<Value> {
        serde_json::to_value(self)
    }

    fn equals(&self, other: &dyn System) -> bool {
        other.as_any().downcast_ref::<T>().is_some_and(|other| self == other)
    }
}

impl dyn System + '_ {
    /// Returns whether it has an air handler with actuators of its own, besides its zones' actuators.
    pub fn has_air_handler(&self) -> bool {
        (0..self.actuators().len()).any(|actuator| self.zone_of(actuator).is_none())
    }
}

impl Clone for Box<dyn System> {
    fn clone(&self) -> Self {
        self.to_box()
    }
}

impl PartialEq for dyn System {
    fn eq(&self, other: &dyn System) -> bool {
        self.equals(other)
    }
}

impl Serialize for dyn System {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let fields = self.to_json().map_err(S::Error::custom)?;
        serializer.collect_map([(self.kind().id, fields)])
    }
}

/// State of a zone and its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneState {
    /// Air temperature, °C.
    pub temperature: f64,
    /// Target temperature, °C.
    pub target: f64,
}

/// The flows that the actuators of a system share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SharedFlow {
    /// Design flow of the supply fan, kg/s. It limits the flow through all dampers together.
    pub fan: f64,
    /// Design flow of the exhaust fans in its zones, kg/s. Outdoor air makes up for it, regardless of the command.
    pub exhaust: f64,
}
