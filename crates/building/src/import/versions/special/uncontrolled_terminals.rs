//! Terminals that connected an air loop to a zone directly.
//!
//! Since 9.3 there is an `AirTerminal:SingleDuct:ConstantVolume:NoReheat` in a `ZoneHVAC:AirDistributionUnit` in their
//! place. It has an inlet node of its own, which splitters, plenums and loops name instead of the zone's inlet.

use crate::import::versions::document::{Document, Field, Object};
use crate::import::versions::report::Conversion;

const CLASS: &str = "AirTerminal:SingleDuct:Uncontrolled";
const TERMINAL: &str = "AirTerminal:SingleDuct:ConstantVolume:NoReheat";
const UNIT: &str = "ZoneHVAC:AirDistributionUnit";
/// Classes that name the zone's inlet as the end of the air loop.
const UPSTREAM: [&str; 3] = ["AirLoopHVAC:ZoneSplitter", "AirLoopHVAC:SupplyPlenum", "AirLoopHVAC"];

/// A terminal of the old class.
struct Terminal {
    name: String,
    outlet: String,
}

impl Terminal {
    fn inlet(&self) -> String {
        format!("{} ATInlet", self.outlet)
    }

    fn unit(&self) -> String {
        format!("{} ADU", self.name)
    }
}

pub(super) fn convert(document: &mut Document, version: &str, report: &mut Conversion) -> Vec<String> {
    let outlet = Field { at: 3, name: "zone_supply_air_node_name" };
    let terminal =
        |object: &Object| Terminal { name: object.name(), outlet: object.get(outlet).unwrap_or_default() };
    let terminals: Vec<Terminal> = document.of(CLASS).map(terminal).collect();
    if terminals.is_empty() {
        return Vec::new();
    }
    let lists = upstream_lists(document);
    let problems = airflow_network(document, &terminals);
    let mut units = Vec::new();
    for object in &mut document.objects {
        if object.is(CLASS) {
            let terminal = terminal(object);
            units.push(replace(object, &terminal));
            report.changed(version, CLASS, format!("is now {TERMINAL} in a {UNIT}"));
        } else if object.is("ZoneHVAC:EquipmentList") {
            name_units(object, &terminals);
        } else if UPSTREAM.iter().any(|class| object.is(class))
            || (object.is("NodeList") && lists.contains(&object.name().to_lowercase()))
        {
            let inlet =
                |text: &str| Some(terminals.iter().find(|t| t.outlet.eq_ignore_ascii_case(text))?.inlet());
            object.change_texts(inlet);
        }
    }
    document.objects.extend(units);
    problems
}

/// Returns the names of the node lists that only objects of the classes [`UPSTREAM`] name, in lower case.
fn upstream_lists(document: &Document) -> Vec<String> {
    let names: Vec<String> = document.of("NodeList").map(|list| list.name().to_lowercase()).collect();
    let named_by = |object: &Object, name: &str| {
        let mut found = false;
        object.clone().change_texts(|text| {
            found |= text.eq_ignore_ascii_case(name);
            None
        });
        found
    };
    let is_upstream = |name: &String| {
        let users: Vec<_> =
            document.objects.iter().filter(|o| !o.is("NodeList") && named_by(o, name)).collect();
        !users.is_empty() && users.iter().all(|user| UPSTREAM.iter().any(|class| user.is(class)))
    };
    names.into_iter().filter(is_upstream).collect()
}

/// Returns a problem if the model has ducts of an AirflowNetwork, whose ends at the terminals cannot be converted.
fn airflow_network(document: &Document, terminals: &[Terminal]) -> Vec<String> {
    let has_ducts = document.of("AirflowNetwork:Distribution:Linkage").next().is_some();
    let ducts = terminals.first().filter(|_| has_ducts);
    ducts
        .map(|terminal| format!("{CLASS} `{}`: ducts of an AirflowNetwork end at it", terminal.name))
        .into_iter()
        .collect()
}

/// Makes a terminal of the new class and returns its distribution unit.
fn replace(object: &mut Object, terminal: &Terminal) -> Object {
    let sizing = Field { at: 7, name: "design_specification_air_terminal_sizing_object_name" };
    let sizing = object.remove(sizing).unwrap_or_default();
    TERMINAL.clone_into(&mut object.class);
    object.rename("zone_supply_air_node_name", "air_outlet_node_name");
    object.insert(Field { at: 3, name: "air_inlet_node_name" }, &terminal.inlet());
    let values = [
        ("air_distribution_unit_outlet_node_name", terminal.outlet.clone()),
        ("air_terminal_object_type", TERMINAL.to_owned()),
        ("air_terminal_name", terminal.name.clone()),
        ("nominal_upstream_leakage_fraction", String::new()),
        ("constant_downstream_leakage_fraction", String::new()),
        ("design_specification_air_terminal_sizing_object_name", sizing),
    ];
    Object::like(object, UNIT, &terminal.unit(), &values)
}

/// Names the distribution unit of each terminal in a list of equipment. Names of other equipment in the list stay,
/// unless they are the same as a terminal's.
fn name_units(list: &mut Object, terminals: &[Terminal]) {
    let unit = |text: &str| match text.eq_ignore_ascii_case(CLASS) {
        true => Some(UNIT.to_owned()),
        false => Some(terminals.iter().find(|terminal| terminal.name.eq_ignore_ascii_case(text))?.unit()),
    };
    let own_name = list.name();
    list.change_texts(|text| unit(text).filter(|_| !text.eq_ignore_ascii_case(&own_name)));
}
