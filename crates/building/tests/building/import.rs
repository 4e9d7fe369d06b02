//! Users' models, read and prepared on the real engine.

use std::path::{Path, PathBuf};

use b2b_building::hvac::{Kind, Unsupported};
use b2b_building::{Conditioning, Error, PreparedBuilding, import};
use b2b_energyplus::Library;
use b2b_energyplus::install::{Engine, Quiet};

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
    let count = |id: &str| hotel.systems.iter().filter(|system| system.kind().id() == id).count();
    // The guest rooms have packaged units, which follow the setpoints.
    assert_eq!([count("unitary"), count("heating_only"), count("setpoints")], [12, 13, 35]);
    let left: Vec<_> = hotel.zones.iter().filter(|zone| zone.own_controls).collect();
    let packaged = |class: &str| hotel.uncontrolled.iter().filter(|item| item.object.class == class).count();
    assert_eq!(packaged("ZoneHVAC:PackagedTerminalAirConditioner"), 35);
    // Three heaters have no capacity.
    assert_eq!(packaged("ZoneHVAC:UnitHeater"), 3);
    assert_eq!(left.len(), 3);
    assert!(left.iter().all(|zone| zone.conditioning == Conditioning::None));
    let judged: f64 = hotel.controlled_zones().map(|zone| zone.floor_area).sum();
    let left: f64 = left.iter().map(|zone| zone.floor_area).sum();
    assert!((hotel.conditioned_floor_area - judged - left).abs() < 1e-6);
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
    let old = stock.text("SmallOffice").replacen("Version,25.2", "Version,9.4", 1);
    assert_says(&stock.refusal("old.idf", &old), &["9.4", "25.2", "IDFVersionUpdater"]);
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
