//! Conversion of small models, and versions that are refused.

use std::path::Path;

use serde_json::{Value, json};

use super::document::{Body, Object};
use super::*;
use crate::model::Model;

const ENGINE: &str = "25.2.0-cf7368216c";

fn idf(version: &str, text: &str) -> (Document, Conversion) {
    let mut document = idf::parse(&format!("Version,{version};\n{text}")).unwrap();
    let Found::Converted(report) = convert(&mut document, ENGINE).unwrap() else { panic!("converted") };
    (document, report)
}

fn epjson(version: &str, mut model: Value) -> (Model, Conversion) {
    model["Version"] = json!({"Version 1": {"version_identifier": version}});
    let model = Model::from_epjson(&model.to_string(), Path::new("test.epJSON")).unwrap();
    let mut document = Document::from_model(&model);
    let Found::Converted(report) = convert(&mut document, ENGINE).unwrap() else { panic!("converted") };
    (document.into_model(), report)
}

fn values<'a>(document: &'a Document, class: &'a str) -> Vec<&'a [String]> {
    let positions = |object: &'a Object| match &object.body {
        Body::Positions(values) => values.as_slice(),
        Body::Names { .. } => panic!("positions"),
    };
    document.of(class).map(positions).collect()
}

#[test]
fn a_surface_gets_its_space_between_zone_and_boundary() {
    let (document, report) = idf("9.5", "BuildingSurface:Detailed,South,Wall,W,Room,Outdoors,,SunExposed;");
    assert_eq!(values(&document, "BuildingSurface:Detailed")[0][3..6], ["Room", "", "Outdoors"]);
    assert_eq!(document.version().as_deref(), Some("25.2"));
    assert!(
        report.changed.iter().any(|change| change.version == "9.6" && change.what.contains("space_name"))
    );
    assert!(report.left_out.is_empty(), "{report:?}");
}

#[test]
fn what_has_no_counterpart_is_listed_with_its_value() {
    let (document, report) =
        idf("8.9", "Boiler:HotWater,B,NaturalGas,autosize,0.8,LeavingBoiler,Curve,82,autosize;");
    assert_eq!(values(&document, "Boiler:HotWater")[0][5..], ["Curve", "autosize"]);
    let [left] = &report.left_out[..] else { panic!("{report:?}") };
    assert_eq!((left.objects, left.what.as_str()), (1, "`design_water_outlet_temperature` = `82`"));
}

#[test]
fn refrigerant_flow_by_schedule_follows_the_load_and_is_reported() {
    let blanks = ",".repeat(33);
    let (document, report) =
        idf("24.2", &format!("AirConditioner:VariableRefrigerantFlow,Outdoor{blanks},Scheduled,Modes;"));
    let unit = values(&document, "AirConditioner:VariableRefrigerantFlow")[0];
    assert_eq!(unit[34..], ["LoadPriority", "Modes"]);
    assert!(report.changed.iter().any(|change| change.what.contains("`Scheduled` is now `LoadPriority`")));
}

#[test]
fn an_epjson_is_converted_by_the_names_of_its_fields() {
    let (model, report) = epjson(
        "9.5",
        json!({
            "People": {"P": {"zone_or_zonelist_name": "Room", "people_per_zone_floor_area": 0.1,
                             "mean_radiant_temperature_calculation_type": "ZoneAveraged"}},
            "Lights": {"L": {"zone_or_zonelist_name": "Room", "watts_per_zone_floor_area": 8}},
        }),
    );
    let people = model.get("People", "P").unwrap();
    assert_eq!(people["zone_or_zonelist_or_space_or_spacelist_name"], "Room");
    assert_eq!(people["people_per_floor_area"], 0.1);
    assert_eq!(people["mean_radiant_temperature_calculation_type"], "EnclosureAveraged");
    assert_eq!(model.get("Lights", "L").unwrap()["watts_per_floor_area"], 8);
    assert_eq!(report.changed.iter().filter(|change| change.class == "People").count(), 3);
}

#[test]
fn heat_recovery_keeps_its_effectiveness_at_75_percent_of_the_flow() {
    let exchanger =
        "HeatExchanger:AirToAir:SensibleAndLatent,HX,On,1,0.7,0.6,0.8,0.6,0.7,0.6,0.8,0.6,a,b,c,d;";
    let (document, _) = idf("23.2", exchanger);
    let fields = values(&document, "HeatExchanger:AirToAir:SensibleAndLatent")[0];
    assert_eq!(fields[3..8], ["0.7", "0.6", "0.7", "0.6", "a"]);
    // Constant latent effectiveness needs no curve.
    assert_eq!(fields[19..], ["HX Sensible Heating", "", "HX Sensible Cooling"]);
    let curve = values(&document, "Curve:Linear")[0];
    let number = |index: usize| curve[index].parse::<f64>().unwrap();
    assert!((0.7 * (number(1) + 0.75 * number(2)) - 0.8).abs() < 1e-12);
    assert!((number(1) + number(2) - 1.0).abs() < 1e-12);
}

#[test]
fn fields_become_an_object_of_their_own() {
    let text = "ZoneHVAC:Baseboard:RadiantConvective:Water,B,On,in,out,82,,HeatingDesignCapacity,autosize,,,autosize,\
                0.001,0.3,0.4,Wall,0.6;";
    let (document, _) = idf("9.4", text);
    let baseboard = values(&document, "ZoneHVAC:Baseboard:RadiantConvective:Water")[0];
    assert_eq!(
        baseboard,
        ["B", "B Design", "On", "in", "out", "82", "", "autosize", "autosize", "Wall", "0.6"]
    );
    let design = values(&document, "ZoneHVAC:Baseboard:RadiantConvective:Water:Design")[0];
    assert_eq!(design, ["B Design", "HeatingDesignCapacity", "", "", "0.001", "0.3", "0.4"]);
}

#[test]
fn a_terminal_that_was_connected_directly_gets_a_unit_and_a_node() {
    let text = "AirTerminal:SingleDuct:Uncontrolled,Direct,On,Zone In,autosize;\
                ZoneHVAC:EquipmentList,L,SequentialLoad,AirTerminal:SingleDuct:Uncontrolled,Direct,1,1;\
                ZoneHVAC:EquipmentConnections,Room,L,Zone In;\
                AirLoopHVAC:ZoneSplitter,S,Loop,Zone In;";
    let (document, _) = idf("9.2", text);
    let terminal = values(&document, "AirTerminal:SingleDuct:ConstantVolume:NoReheat")[0];
    assert_eq!(terminal, ["Direct", "On", "Zone In ATInlet", "Zone In", "autosize"]);
    assert_eq!(values(&document, "AirLoopHVAC:ZoneSplitter")[0][2], "Zone In ATInlet");
    assert_eq!(
        values(&document, "ZoneHVAC:EquipmentList")[0][2..4],
        ["ZoneHVAC:AirDistributionUnit", "Direct ADU"]
    );
    assert_eq!(values(&document, "ZoneHVAC:EquipmentConnections")[0][2], "Zone In");
}

#[test]
fn a_shading_control_names_its_windows_by_zone() {
    let text = "WindowProperty:ShadingControl,Blind,InteriorBlind,,AlwaysOn;\
                Wall:Detailed,South,W,Room,Outdoors;\
                FenestrationSurface:Detailed,Pane,Window,Glass,South,,0.5,Blind,,,4,1,1,1;";
    let (document, report) = idf("8.9", text);
    let control = values(&document, "WindowShadingControl")[0];
    assert_eq!(control[..4], ["Blind Room", "Room", "1", "InteriorBlind"]);
    assert_eq!(control[15..], ["Sequential", "Pane"]);
    assert_eq!(values(&document, "FenestrationSurface:Detailed")[0][5..8], ["0.5", "", ""]);
    assert!(report.left_out.is_empty(), "{report:?}");
}

#[test]
fn a_fraction_of_the_load_becomes_a_schedule_and_1_is_blank() {
    let text = "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,1.0,0.50,B,b,2,2,,0.5;\
                Schedule:Compact,sequential fraction 0.5;";
    let (document, report) = idf("9.1", text);
    const NAME: &str = "Sequential Fraction 0.5 of Load";
    let list = values(&document, "ZoneHVAC:EquipmentList")[0];
    assert_eq!(list[2..], ["A", "a", "1", "1", "", NAME, "B", "b", "2", "2", "", NAME]);
    assert_eq!(values(&document, "Schedule:Constant"), [[NAME, "", "0.5"]]);
    assert!(report.changed.iter().any(|change| change.what.contains("fractions of the load")));

    let (document, _) = idf("9.0", "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,B,b,2,2;");
    let list = values(&document, "ZoneHVAC:EquipmentList")[0];
    assert_eq!(list[2..], ["A", "a", "1", "1", "", "", "B", "b", "2", "2", "", ""]);

    let item = json!({"zone_equipment_sequential_cooling_fraction": 1.0,
                      "zone_equipment_sequential_heating_fraction": 0.25});
    let (model, _) = epjson("9.1", json!({"ZoneHVAC:EquipmentList": {"L": {"equipment": [item]}}}));
    let name = "Sequential Fraction 0.25";
    let list = model.get("ZoneHVAC:EquipmentList", "L").unwrap();
    assert_eq!(
        list["equipment"],
        json!([{"zone_equipment_sequential_heating_fraction_schedule_name": name}])
    );
    assert_eq!(model.get("Schedule:Constant", name).unwrap()["hourly_value"], 0.25);
}

#[test]
fn a_table_of_one_variable_is_a_lookup_table_in_order() {
    let table = "Table:OneIndependentVariable,T,Linear,LinearInterpolationOfTable,0,1,,,Dimensionless,Dimensionless,,\
                 1,0.5,0,0.2;";
    let (document, _) = idf("9.1", table);
    assert_eq!(values(&document, "Table:IndependentVariable")[0][10..], ["0", "1"]);
    assert_eq!(values(&document, "Table:Lookup")[0][10..], ["0.2", "0.5"]);
    assert_eq!(values(&document, "Table:IndependentVariableList")[0], ["T Variables", "T Variable"]);
}

#[test]
fn outputs_that_programs_read_are_renamed() {
    let (document, _) = idf("9.3", "EnergyManagementSystem:Sensor,S,Room,Lights Electric Power;");
    assert_eq!(values(&document, "EnergyManagementSystem:Sensor")[0][2], "Lights Electricity Rate");
    let (document, _) = idf("9.3", "ENERGYMANAGEMENTSYSTEM:SENSOR,S,Room,LIGHTS ELECTRIC POWER;");
    assert_eq!(values(&document, "EnergyManagementSystem:Sensor")[0][2], "LIGHTS Electricity Rate");
}

#[test]
fn newer_older_and_unknown_versions_are_refused_with_a_remedy() {
    let said = |version: &str, text: &str| {
        let mut document = idf::parse(&format!("Version,{version};{text}")).unwrap();
        convert(&mut document, ENGINE).unwrap_err().join("\n")
    };
    for (version, words) in
        [("26.1", ["26.1", "newer"]), ("7.2", ["7.2", "8.8 to 25.2"]), ("9.7", ["9.7", "accepted"])]
    {
        let said = said(version, "");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }
    let said = said("9.1", "Table:TwoIndependentVariables,T,BiQuadratic;");
    assert!(said.contains("`T`") && said.contains("Transition"), "{said}");
    let mut same = idf::parse("Version,25.2;Zone,A;").unwrap();
    assert_eq!(convert(&mut same, ENGINE), Ok(Found::Same));
    let mut none = idf::parse("Zone,A;").unwrap();
    assert_eq!(convert(&mut none, ENGINE), Ok(Found::Assumed("25.2".into())));
}
