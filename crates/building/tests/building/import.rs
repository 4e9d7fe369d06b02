//! Users' models, read and prepared on the real engine.

use std::path::{Path, PathBuf};

use b2b_building::description::Origin;
use b2b_building::hvac::{Kind, Unsupported};
use b2b_building::import::{Imported, Notes};
use b2b_building::{Conditioning, Description, Error, PreparedBuilding, RunPeriod, design_days, import};
use b2b_climate::{EpwFile, Site};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};
use serde_json::{Value, json};

use crate::room::room;

const CHICAGO: &str = "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw";

struct Stock {
    library: Library,
    models: PathBuf,
    weather: PathBuf,
}

impl Stock {
    fn new() -> Self {
        let engine = Engine::ensure(&mut Quiet).unwrap();
        let models = engine.models.unwrap();
        let weather = models.parent().unwrap().join("weather").join(CHICAGO);
        Self { library: Library::load(&engine.library).unwrap(), models, weather }
    }

    fn chicago(&self, name: &str) -> PathBuf {
        self.models.join(format!("RefBldg{name}New2004_Chicago.idf"))
    }

    fn prepare(&self, path: &Path) -> b2b_building::Result<PreparedBuilding> {
        let model = import::read(path, &self.library, false)?;
        PreparedBuilding::as_far_as_possible("imported", model, &self.weather, &self.library)
    }

    fn text(&self, name: &str) -> String {
        String::from_utf8_lossy(&std::fs::read(self.chicago(name)).unwrap()).into_owned()
    }

    /// The error for a file with this name and content.
    fn refusal(&self, name: &str, content: &str) -> String {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, content).unwrap();
        import::read(&path, &self.library, false).unwrap_err().to_string()
    }
}

fn assert_says(said: &str, words: &[&str]) {
    for word in words {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}

#[test]
fn every_model_that_ships_with_the_engine_is_accepted() {
    let stock = Stock::new();
    let files = std::fs::read_dir(&stock.models).unwrap().map(|entry| entry.unwrap().path());
    let models: Vec<_> = files.filter(|path| import::is_model_file(path)).collect();
    assert_eq!(models.len(), 32);
    for model in models {
        import::read(&model, &stock.library, false).unwrap();
    }
}

#[test]
fn the_supported_systems_of_a_hotel_are_controlled() {
    let stock = Stock::new();
    let hotel = stock.prepare(&stock.chicago("SmallHotel")).unwrap();
    let count = |id: &str| hotel.systems.iter().filter(|system| system.kind().id == id).count();
    // The guest rooms have packaged units.
    assert_eq!([count("unitary"), count("heating_only"), count("room_unit")], [12, 13, 35]);
    let left: Vec<_> = hotel.zones.iter().filter(|zone| zone.own_controls).collect();
    // Three heaters have no capacity.
    let heaters = hotel.uncontrolled.iter().filter(|item| item.object.class == "ZoneHVAC:UnitHeater").count();
    assert_eq!(heaters, 3);
    assert_eq!(left.len(), 3);
    assert!(left.iter().all(|zone| zone.conditioning == Conditioning::None));
    let judged: f64 = hotel.controlled_zones().map(|zone| zone.floor_area).sum();
    let left: f64 = left.iter().map(|zone| zone.floor_area).sum();
    assert!((hotel.conditioned_floor_area - judged - left).abs() < 1e-6);
    let described = Description::of(&hotel, &stock.weather, Origin::default()).unwrap();
    assert!((described.conditioned_floor_area - hotel.conditioned_floor_area).abs() < 1e-6);
}

#[test]
fn the_error_of_a_building_without_systems_and_thermostats_lists_what_it_has() {
    let stock = Stock::new();
    let model = import::read(&stock.chicago("SmallOffice"), &stock.library, false).unwrap();
    let kinds = Kind::find("heating_only").map(|kind| [kind]).unwrap();
    let left_alone = Unsupported::LeftAlone;
    let prepared =
        PreparedBuilding::with_kinds("office", model, &stock.weather, &stock.library, &kinds, left_alone);
    let said = prepared.unwrap_err().to_string();
    assert_says(&said, &["no controllable system", "5 × AirLoopHVAC", "unsupported component"]);
    assert!(said.lines().count() <= 4, "{said}");
}

#[test]
fn a_truncated_model_is_rejected() {
    let stock = Stock::new();
    let text = stock.text("SmallOffice");
    let half = &text[..text.len() / 2];
    let in_an_object = &half[..=half.rfind(',').unwrap()];
    assert_says(&stock.refusal("half.idf", in_an_object), &["half.idf", "truncated", "line "]);
    // Truncated between two objects, it is a valid IDF of an incomplete building.
    let whole_objects = &half[..=half.rfind(';').unwrap()];
    assert_says(&stock.refusal("less.idf", whole_objects), &["less.idf", "missing", "complete"]);
    let json = stock.library.convert_idf(&stock.chicago("SmallOffice")).unwrap();
    assert_says(&stock.refusal("half.epJSON", &json[..json.len() / 2]), &["half.epJSON", "line"]);
}

#[test]
fn zones_with_the_same_name_are_rejected() {
    let stock = Stock::new();
    let text = stock.text("SmallOffice");
    let twice = |name: &str| format!("{text}\nZone,\n  {name};\n");
    assert_says(&stock.refusal("same.idf", &twice("Core_ZN")), &["Duplicate name", "Core_ZN"]);
    assert_says(&stock.refusal("case.idf", &twice("CORE_ZN")), &["`CORE_ZN`", "`Core_ZN`", "rename"]);
    let json = r#"{"Zone": {"Core": {}, "Core": {}}}"#;
    assert_says(&stock.refusal("same.epJSON", json), &["`Core`", "rename"]);
}

#[test]
fn models_of_the_previous_version_are_updated() {
    let stock = Stock::new();
    let text = stock.text("SmallOffice").replacen("Version,25.2", "Version,25.1", 1);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("previous.idf");
    std::fs::write(&file, text).unwrap();
    let model = import::read(&file, &stock.library, false).unwrap();
    let [(_, version)] = model.objects("Version")[..] else { panic!("one version") };
    assert_eq!(version["version_identifier"], "25.2");
}

#[test]
fn models_of_another_version_and_other_files_are_rejected() {
    let stock = Stock::new();
    let old = stock.text("SmallOffice").replacen("Version,25.2", "Version,7.2", 1);
    assert_says(&stock.refusal("old.idf", &old), &["7.2", "8.8 to 25.2", "IDFVersionUpdater"]);
    let new = stock.text("SmallOffice").replacen("Version,25.2", "Version,26.1", 1);
    assert_says(&stock.refusal("new.idf", &new), &["26.1", "newer than the engine"]);
    let template = "Version,25.2;Zone,Room;HVACTemplate:Thermostat,T,,20,,26;";
    assert_says(&stock.refusal("template.idf", template), &["HVACTemplate:Thermostat", "ExpandObjects"]);
    assert_says(&stock.refusal("empty.idf", "! nothing\n"), &["empty"]);
    assert_says(&stock.refusal("noise.idf", "what is this;"), &["noise.idf"]);
    let shed = "Version,25.2;\nBuilding,Shed;\nGlobalGeometryRules,UpperLeftCorner,Clockwise,Relative;";
    assert_says(&stock.refusal("shed.idf", shed), &["no Zone"]);
    assert_says(&stock.refusal("list.epJSON", "[1, 2]"), &["not a JSON object"]);
    assert_says(&stock.refusal("model.txt", ""), &[".idf", ".epJSON"]);
    for (path, words) in [("/nowhere/a.idf", "does not exist"), (".", "it is a folder")] {
        let error = import::read(Path::new(path), &stock.library, false).unwrap_err();
        assert!(matches!(error, Error::Import { .. }), "{error}");
        assert_says(&error.to_string(), &[path, words]);
    }
}

/// Reads a model of this name and content.
fn read(stock: &Stock, name: &str, content: &[u8]) -> b2b_building::Result<Imported> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, content).unwrap();
    import::read_with_notes(&path, &stock.library, import::Options::default())
}

fn read_room(stock: &Stock, room: &Value) -> b2b_building::Result<Imported> {
    read(stock, "room.epJSON", room.to_string().as_bytes())
}

#[test]
fn windows_may_be_in_walls_of_any_class() {
    let stock = Stock::new();
    let mut model = room();
    let mut wall = model["BuildingSurface:Detailed"].as_object_mut().unwrap().remove("South").unwrap();
    wall.as_object_mut().unwrap().remove("surface_type");
    model["Wall:Detailed"] = json!({"South": wall});
    let window = |wall: &str| json!({"Pane": {"surface_type": "Window", "construction_name": "Wall", "building_surface_name": wall}});
    model["FenestrationSurface:Detailed"] = window("South");
    read_room(&stock, &model).unwrap();
    model["FenestrationSurface:Detailed"] = window("Gone");
    assert_says(&read_room(&stock, &model).unwrap_err().to_string(), &["`Pane`", "`Gone`"]);
}

#[test]
fn a_missing_schedule_file_and_a_missing_version_are_named() {
    let stock = Stock::new();
    let mut model = room();
    model.as_object_mut().unwrap().remove("Version");
    let notes = read_room(&stock, &model).unwrap().notes;
    assert_says(&notes.warnings.join(" "), &["no Version", "25.2 is assumed"]);
    model["Schedule:File"] =
        json!({"F": {"file_name": "absent.csv", "column_number": 1, "rows_to_skip_at_top": 0}});
    assert_says(&read_room(&stock, &model).unwrap_err().to_string(), &["`F`", "`absent.csv`", "is missing"]);
}

#[test]
fn an_old_idf_in_latin_1_is_converted_and_its_errors_name_the_users_file() {
    let stock = Stock::new();
    let text = |algorithm: &str| {
        let text = format!(
            "Version,9.4;\nBuilding,B;\nGlobalGeometryRules,UpperLeftCorner,CounterClockWise,World;\nZone,B\u{fc}ro;\n\
             Material,Block,Rough,0.2,0.1,600,900;\nConstruction,Wall,Block;\nHeatBalanceAlgorithm,{algorithm};\n\
             BuildingSurface:Detailed,South,Wall,Wall,B\u{fc}ro,Outdoors,,SunExposed,WindExposed,0.5,4,0,0,3,0,0,0,10,0,\
             0,10,0,3;\n"
        );
        text.chars().map(|character| character as u8).collect::<Vec<u8>>()
    };
    let Imported { model, notes } = read(&stock, "old.idf", &text("ConductionTransferFunction")).unwrap();
    let south = model.get("BuildingSurface:Detailed", "South").unwrap();
    assert_eq!((&south["zone_name"], &south["sun_exposure"]), (&json!("B\u{fc}ro"), &json!("SunExposed")));
    let conversion = notes.conversion.unwrap();
    assert_eq!((conversion.from.as_str(), conversion.to.as_str()), ("9.4", "25.2"));
    assert_says(&notes.warnings.join(" "), &["not UTF-8 (line 4)", "Latin-1"]);
    let said = read(&stock, "old.idf", &text("Guess")).unwrap_err().to_string();
    assert_says(&said, &["old.idf", "Guess"]);
    assert!(!said.contains("b2b-import"), "{said}");
}

#[test]
fn an_idf_with_a_byte_order_mark_is_read_as_without() {
    let text = "\u{feff}Version,25.2;\nBuilding,B;\nGlobalGeometryRules,UpperLeftCorner,CounterClockWise,World;\nZone,Room;\n";
    let Imported { model, notes } = read(&Stock::new(), "marked.idf", text.as_bytes()).unwrap();
    assert!(model.contains("Zone", "Room") && notes.is_empty(), "{notes:?}");
}

/// A tank that its own sizing sizes, and equipment that nothing uses.
#[test]
fn the_weather_decides_sizes_and_what_is_not_sized_is_left_alone() {
    let stock = Stock::new();
    let mut model = room();
    model.as_object_mut().unwrap().remove("SizingPeriod:DesignDay");
    model["ZoneHVAC:IdealLoadsAirSystem"] = json!({"Spare": {"zone_supply_air_node_name": "Nowhere",
        "maximum_heating_air_flow_rate": "Autosize", "heating_limit": "LimitFlowRate"}});
    model["WaterHeater:Mixed"] = json!({"Tank": {"tank_volume": 0.2, "setpoint_temperature_schedule_name": "Hot",
        "heater_control_type": "Cycle", "heater_maximum_capacity": "Autosize", "heater_fuel_type": "Electricity",
        "heater_thermal_efficiency": 1, "maximum_temperature_limit": 80, "ambient_temperature_indicator": "Zone",
        "ambient_temperature_zone_name": "Room", "peak_use_flow_rate": 0}});
    model["WaterHeater:Sizing"] = json!({"S": {"waterheater_name": "Tank", "design_mode": "ResidentialHUD-FHAMinimum",
        "number_of_bathrooms": 1, "number_of_bedrooms": 2}});
    model["Schedule:Constant"]["Hot"] = json!({"schedule_type_limits_name": "Any", "hourly_value": 55});
    let prepared = |weather: &Path| {
        let Imported { mut model, mut notes } = read_room(&stock, &model).unwrap();
        design_days::of_imported(&mut model, &Site::read(weather).unwrap(), false, &mut notes);
        assert_says(notes.design_days.as_deref().unwrap(), &["the weather file's"]);
        PreparedBuilding::as_far_as_possible("room", model, weather, &stock.library).unwrap()
    };
    let miami = stock.weather.with_file_name("USA_FL_Miami.Intl.AP.722020_TMY3.epw");
    let buildings = [prepared(&stock.weather), prepared(&miami)];
    let capacity = |building: &PreparedBuilding| {
        let heater = building.model().get("ZoneHVAC:Baseboard:Convective:Electric", "Heater").unwrap();
        heater["heating_design_capacity"].as_f64().unwrap()
    };
    // 21 °C inside: 41 K above the heating design day of Chicago and 12 K above Miami's.
    let [chicago, miami] = [&buildings[0], &buildings[1]].map(capacity);
    assert!(chicago > 2.5 * miami, "{chicago} {miami} W");
    let left = &buildings[0].notes.left_autosized;
    assert!(left.iter().any(|field| field.contains("`Spare`: maximum_heating_air_flow_rate")), "{left:?}");
    // HUD-FHA, one bathroom and two bedrooms: 3.5 kW.
    for building in &buildings {
        let tank = building.model().get("WaterHeater:Mixed", "Tank").unwrap();
        assert_eq!(tank["heater_maximum_capacity"], 3500.0);
    }
}

/// The design days of Miami in the model, under the weather of Chicago.
#[test]
fn design_days_of_another_place_do_not_decide_sizes_unless_they_are_kept() {
    let stock = Stock::new();
    let site = Site::read(&stock.weather).unwrap();
    let capacity = |model: &Value, keep: bool| {
        let Imported { mut model, mut notes } = read_room(&stock, model).unwrap();
        design_days::of_imported(&mut model, &site, keep, &mut notes);
        let building =
            PreparedBuilding::as_far_as_possible("room", model, &stock.weather, &stock.library).unwrap();
        let heater = building.model().get("ZoneHVAC:Baseboard:Convective:Electric", "Heater").unwrap();
        heater["heating_design_capacity"].as_f64().unwrap()
    };
    let mut miami = room();
    let cold = &mut miami["SizingPeriod:DesignDay"]["Cold"];
    for field in ["maximum_dry_bulb_temperature", "wetbulb_or_dewpoint_at_maximum_dry_bulb"] {
        cold[field] = json!(9.0);
    }
    miami["Site:Location"] =
        json!({"Miami": {"latitude": 25.8, "longitude": -80.3, "time_zone": -5, "elevation": 10}});
    let mut without = room();
    without.as_object_mut().unwrap().remove("SizingPeriod:DesignDay");
    let of_weather = capacity(&without, false);
    assert_eq!(capacity(&miami, false), of_weather);
    let kept = capacity(&miami, true);
    // 21 °C inside: 41 K above the design day of Chicago, 12 K above Miami's.
    assert!(of_weather > 2.5 * kept && kept > 0.0, "{of_weather} and {kept} W");
}

/// Six hours of missing temperatures on each of 30 days, from 10 February on.
#[test]
fn missing_temperatures_are_neither_in_degree_days_nor_in_design_days() {
    let stock = Stock::new();
    let bytes = std::fs::read(&stock.weather).unwrap();
    let lines = String::from_utf8_lossy(&bytes).lines().map(str::to_owned).collect::<Vec<_>>();
    let missing = |(number, line): (usize, &String)| {
        let mut columns: Vec<&str> = line.split(',').collect();
        match number {
            968..1688 if number % 24 < 6 => columns[6] = "99.9",
            1 => columns = vec!["DESIGN CONDITIONS", "0"],
            _ => {}
        }
        columns.join(",") + "\n"
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing.epw");
    std::fs::write(&path, lines.iter().enumerate().map(missing).collect::<String>()).unwrap();
    let of = |path: &Path| EpwFile::open(path).unwrap().degree_days().unwrap();
    // The engine repeats the last temperature.
    assert!((of(&stock.weather).cooling - 1743.4).abs() < 0.1, "{:?}", of(&stock.weather));
    assert!((of(&path).cooling - 1743.6).abs() < 0.1, "{:?}", of(&path));
    let site = Site::read(&path).unwrap();
    assert!(site.sized_by_hours && site.cooling.dry_bulb < 40.0, "{} °C", site.cooling.dry_bulb);
}

/// Features of a model that episodes change, such as daylight saving time, are noted for its author.
#[test]
fn what_episodes_change_in_a_model_is_noted() {
    let stock = Stock::new();
    let mut model = room();
    let prepared = |model: &Value| {
        let Imported { model, .. } = read_room(&stock, model).unwrap();
        PreparedBuilding::as_far_as_possible("room", model, &stock.weather, &stock.library).unwrap()
    };
    assert_eq!(prepared(&model).notes.changed, [""; 0]);
    model["RunPeriodControl:DaylightSavingTime"] =
        json!({"D": {"start_date": "2nd Sunday in March", "end_date": "1st Sunday in November"}});
    model["ZoneControl:Thermostat:OperativeTemperature"] = json!({"O": {
        "thermostat_name": "T", "radiative_fraction_input_mode": "Constant", "fixed_radiative_fraction": 0.5}});
    let building = prepared(&model);
    let said = building.notes.changed.join("\n");
    assert_says(&said, &["daylight saving", "OperativeTemperature `O`", "air temperatures"]);
    assert!(building.model().objects("ZoneControl:Thermostat:OperativeTemperature").is_empty());
}

#[test]
fn design_days_that_are_kept_are_compared_with_the_weather() {
    let stock = Stock::new();
    let site = Site::read(&stock.weather).unwrap();
    let mut model = read_room(&stock, &room()).unwrap().model;
    let mut notes = Notes::default();
    design_days::of_imported(&mut model, &site, true, &mut notes);
    assert_eq!(model.names("SizingPeriod:DesignDay"), ["Cold", "Hot"]);
    assert_says(notes.design_days.as_deref().unwrap(), &["the model's, -20.0 and 33.0 °C"]);
    assert_eq!(notes.warnings, [""; 0]);
    model.get_mut("SizingPeriod:DesignDay", "Cold").unwrap()["maximum_dry_bulb_temperature"] = json!(9.0);
    design_days::of_imported(&mut model, &site, true, &mut notes);
    assert_says(&notes.warnings.join(" "), &["another climate", "--keep-design-days"]);
    model.remove_class("SimulationControl");
    design_days::of_imported(&mut model, &site, true, &mut notes);
    assert_says(notes.design_days.as_deref().unwrap(), &["none used", "gives the sizes"]);
    assert_says(&notes.warnings.join(" "), &["--keep-design-days has no effect"]);
}

#[test]
fn the_calendar_follows_the_run_period_or_else_the_measured_year() {
    let stock = Stock::new();
    let site = Site::read(&stock.weather).unwrap();
    let mut model = room();
    let said = |model: &Value, site: &Site| {
        let model = read_room(&stock, model).unwrap().model;
        let calendar = import::calendar::of(&model, site);
        (calendar.weekday(1), calendar.is_leap(), import::calendar::note(&model, site).unwrap_or_default())
    };
    model["RunPeriod"]["R"]["day_of_week_for_start_day"] = json!("Thursday");
    let (weekday, _, notes) = said(&model, &site);
    assert_eq!(weekday, 3);
    assert_says(&notes, &["1 January is a Thursday, by the model's run period"]);
    let skipping = Site { year: Some(2020), skips_leap_day: true, ..site.clone() };
    assert_says(&import::calendar::skipped_leap_day(&skipping).unwrap(), &["29 February", "2020", "to Yes"]);
    assert_eq!(import::calendar::skipped_leap_day(&site), None);
    let measured = Site { year: Some(2020), has_leap_day: true, ..site };
    let (weekday, is_leap, notes) = said(&model, &measured);
    assert_eq!((weekday, is_leap), (3, true));
    assert_says(&notes, &["not a Wednesday as in 2020, the year of the weather file", "29 February"]);
    model["RunPeriod"]["R"].as_object_mut().unwrap().remove("day_of_week_for_start_day");
    let (weekday, _, notes) = said(&model, &measured);
    assert_eq!(weekday, 2);
    assert_says(&notes, &["1 January is a Wednesday, as in 2020, the year of the weather file"]);
}

/// The run period of the model is a year, of which the weather file has June.
#[test]
fn a_weather_file_of_a_month_is_enough_for_sizes() {
    let stock = Stock::new();
    let folder = tempfile::tempdir().unwrap();
    let june = folder.path().join("june.epw");
    let text = String::from_utf8_lossy(&std::fs::read(&stock.weather).unwrap()).into_owned();
    let line = |(index, line): (usize, &str)| match index {
        7 => Some("DATA PERIODS,1,1,Data,Sunday, 6/ 1, 6/30\n".to_owned()),
        0..7 => Some(format!("{line}\n")),
        _ => (line.split(',').nth(1) == Some("6")).then(|| format!("{line}\n")),
    };
    std::fs::write(&june, text.lines().enumerate().filter_map(line).collect::<String>()).unwrap();
    let mut model = room();
    let heater = |model: &Value, weather: &Path| {
        let model = read_room(&stock, model).unwrap().model;
        let room = PreparedBuilding::as_far_as_possible("room", model, weather, &stock.library).unwrap();
        room.model().get("ZoneHVAC:Baseboard:Convective:Electric", "Heater").cloned()
    };
    let expected = heater(&model, &stock.weather);
    assert_eq!(heater(&model, &june), expected);
    model.as_object_mut().unwrap().remove("RunPeriod");
    assert_eq!(heater(&model, &stock.weather), expected);
}

#[test]
fn programs_that_convert_idf_are_refused_for_an_old_epjson() {
    let stock = Stock::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("room.epJSON");
    let options = import::Options { transition: Some(folder.path()), ..Default::default() };
    let mut model = room();
    std::fs::write(&path, model.to_string()).unwrap();
    import::read_with_notes(&path, &stock.library, options).unwrap();
    model["Version"]["V"]["version_identifier"] = json!("24.2");
    std::fs::write(&path, model.to_string()).unwrap();
    let error = import::read_with_notes(&path, &stock.library, options).unwrap_err().to_string();
    assert_says(&error, &["--transition", "24.2", "export it as IDF"]);
}

#[test]
fn a_model_for_another_program_keeps_the_initial_values_of_its_schedules() {
    let stock = Stock::new();
    let mut model = room();
    model["Schedule:Constant"].as_object_mut().unwrap().remove("Warm");
    model["ExternalInterface"] = json!({"I": {"name_of_external_interface": "PtolemyServer"}});
    model["ExternalInterface:Schedule"] =
        json!({"Warm": {"schedule_type_limits_name": "Any", "initial_value": 20}});
    let Imported { model, notes } = read_room(&stock, &model).unwrap();
    assert_eq!(model.get("Schedule:Constant", "Warm").unwrap()["hourly_value"], json!(20));
    assert_says(&notes.warnings.join(" "), &["another program", "1 schedules"]);
}

#[test]
fn ceiling_heights_count_in_a_users_model_and_not_in_a_generated_building() {
    let stock = Stock::new();
    let mut room = room();
    room["Zone"]["Room"] = json!({"ceiling_height": 5.0});
    let model = read_room(&stock, &room).unwrap().model;
    let (weather, library) = (&stock.weather, &stock.library);
    let own = PreparedBuilding::as_far_as_possible("room", model.clone(), weather, library).unwrap();
    let generated = PreparedBuilding::new("room", model, weather, library).unwrap();
    let volumes = [own, generated].map(|building| building.shape().unwrap().volume(0));
    assert_eq!(volumes, [400.0, 240.0]);
}

#[test]
fn a_thermostat_of_stages_has_a_comfort_band() {
    let stock = Stock::new();
    let mut room = room();
    room.as_object_mut().unwrap().remove("ZoneControl:Thermostat");
    room["Schedule:Constant"]["Cool"] = json!({"hourly_value": 26.0});
    room["ZoneControl:Thermostat:StagedDualSetpoint"] = json!({"T": {
        "zone_or_zonelist_name": "Room", "number_of_heating_stages": 1, "number_of_cooling_stages": 1,
        "heating_temperature_setpoint_schedule_name": "Warm", "heating_throttling_temperature_range": 0.5,
        "cooling_temperature_setpoint_base_schedule_name": "Cool", "cooling_throttling_temperature_range": 0.5,
        "stage_1_heating_temperature_offset": -0.5, "stage_1_cooling_temperature_offset": 0.5}});
    let model = read_room(&stock, &room).unwrap().model;
    let building =
        PreparedBuilding::as_far_as_possible("room", model, &stock.weather, &stock.library).unwrap();
    let span = building.years[0].at(1, 12.0);
    assert_eq!((span.heating, span.cooling), (Some(21.0), Some(26.0)));
    assert_eq!(building.notes.warnings, [""; 0]);
}

#[test]
fn a_holiday_on_a_weekend_is_kept_on_monday_if_the_model_asks_for_it() {
    let stock = Stock::new();
    let mut room = room();
    room["RunPeriodControl:SpecialDays"] =
        json!({"New Year": {"start_date": "1/1", "duration": 1, "special_day_type": "Holiday"}});
    room["RunPeriod"]["R"]["apply_weekend_holiday_rule"] = json!("Yes");
    let model = read_room(&stock, &room).unwrap().model;
    let building =
        PreparedBuilding::as_far_as_possible("room", model, &stock.weather, &stock.library).unwrap();
    assert_eq!(building.holidays, [2, 366], "1 January is a Sunday, and a Monday in the following year");
    let episode = building.model_for(RunPeriod::WINTER, 4);
    assert_eq!(episode.require("RunPeriod", "Episode").unwrap()["apply_weekend_holiday_rule"], "Yes");
}
