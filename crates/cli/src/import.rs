//! `b2b import`: what an agent can drive in a building of the user's own.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use b2b_building::hvac::{System, Uncontrolled};
use b2b_building::{Conditioning, PreparedBuilding, RunPeriod, import};
use b2b_dataset::BuildingName;
use b2b_energyplus::Level;
use b2b_env::Task;
use serde::{Deserialize, Serialize};

use crate::controller::{Parameters, reactive};
use crate::prepare::{Location, Prepared};
use crate::progress::counter;
use crate::run::roll_out;
use crate::table::Table;
use crate::{child, interrupt, stdout};

/// Tell what an agent can drive in a model of yours, and what not and why
///
/// The model is sized as it is, then every system that can be driven is made to follow an agent: packaged
/// units and rooftop units that serve one zone, central air handlers with reheat boxes, and zone heaters.
/// The others keep their own thermostats and schedules. All zones are observed; those that the agent
/// drives are judged; energy is that of all HVAC.
///
/// Nothing is written: `b2b run`, `b2b show` and `b2b doctor --authority` take the model file itself and
/// prepare it in the same way.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  b2b import office.idf --weather boston.epw
  b2b import office.idf --weather boston.epw --run 01-08..01-14     and try it, for a week
  b2b import models/ --place Denver --run 01-08..01-14              a line for each model in a folder
  b2b run office.idf --weather boston.epw                           then, an episode")]
pub struct Arguments {
    /// Model file (.idf, .epJSON; EnergyPlus 25.2), several, or a folder of them
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<PathBuf>,
    #[command(flatten)]
    location: Location,
    /// Run these days under the reactive controller and tell how well the zones are held
    #[arg(long, value_name = "DAYS")]
    run: Option<RunPeriod>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// What was found in a model.
#[derive(Serialize, Deserialize)]
struct Report {
    model: String,
    place: String,
    conditioned_floor_area_m2: f64,
    zones: Vec<Zone>,
    systems: Vec<Driven>,
    uncontrolled: Vec<Uncontrolled>,
    episode: Option<Outcome>,
}

#[derive(Serialize, Deserialize)]
struct Zone {
    name: String,
    floor_area_m2: f64,
    driven: bool,
    own_controls: bool,
    equipment: String,
}

#[derive(Serialize, Deserialize)]
struct Driven {
    kind: String,
    name: String,
    zones: Vec<String>,
    actuators: Vec<String>,
}

/// What became of an episode.
#[derive(Serialize, Deserialize)]
struct Outcome {
    period: String,
    /// Over the driven zones that have heating and cooling.
    rms_deviation_k: f64,
    /// The driven zone that is furthest from target.
    worst_zone: String,
    worst_zone_rms_k: f64,
    warnings: usize,
    severes: usize,
    severe_message: Option<String>,
}

/// Runs the command; exit code 1 when one of several models is no environment, or runs with severe messages.
pub fn import(arguments: &Arguments) -> Result<ExitCode> {
    if let [model] = &arguments.models[..]
        && !model.is_dir()
    {
        let report = Report::of(model, arguments)?;
        let command = Next { model, location: &arguments.location };
        if arguments.json {
            stdout::print_json(&report)?
        } else {
            stdout::print(&report.text(&command))?
        }
        return Ok(ExitCode::SUCCESS);
    }
    let models = models(&arguments.models)?;
    let bar = counter(models.len(), "models", arguments.json);
    let mut reports = Vec::new();
    for model in models {
        reports.push((name(&model), arguments.in_process(&model)?));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let sound = |report: &Result<Report, String>| {
        report.as_ref().is_ok_and(|r| r.episode.as_ref().is_none_or(|e| e.severes == 0))
    };
    let all_sound = reports.iter().all(|(_, report)| sound(report));
    if arguments.json {
        let values = reports.iter().map(|(name, report)| match report {
            Ok(report) => serde_json::to_value(report),
            Err(error) => Ok(serde_json::json!({"model": name, "error": error})),
        });
        stdout::print_json(&values.collect::<Result<Vec<_>, _>>()?)?;
    } else {
        stdout::print(&table(&reports))?;
    }
    Ok(if all_sound { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The models among files and folders, in order of their names within a folder.
fn models(paths: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut models = Vec::new();
    for path in paths {
        if !path.is_dir() {
            models.push(path.clone());
            continue;
        }
        let cannot = || format!("{} cannot be read", path.display());
        let entries = std::fs::read_dir(path).with_context(cannot)?;
        let mut files = entries.map(|e| Ok(e?.path())).collect::<Result<Vec<_>>>().with_context(cannot)?;
        files.retain(|file| import::is_model_file(file));
        if files.is_empty() {
            bail!("{} has no model in it: a model file ends in .idf or .epJSON", path.display());
        }
        files.sort();
        models.append(&mut files);
    }
    Ok(models)
}

fn name(model: &Path) -> String {
    BuildingName::Model(model.to_owned()).to_string()
}

impl Arguments {
    /// The report on one model from a process of its own, or what that said when it failed.
    fn in_process(&self, model: &Path) -> Result<Result<Report, String>> {
        interrupt::check()?;
        let mut arguments = vec!["import".into(), model.as_os_str().to_owned(), "--json".into()];
        arguments.extend(self.location.arguments());
        arguments.extend(self.run.map(|days| format!("--run={days}").into()));
        match child::run(arguments)? {
            Ok(text) => Ok(Ok(serde_json::from_str(&text)?)),
            Err(complaint) => Ok(Err(complaint)),
        }
    }
}

impl Report {
    fn of(model: &Path, arguments: &Arguments) -> Result<Self> {
        let name = BuildingName::Model(model.to_owned());
        let prepared = Prepared::new(&name, &arguments.location, arguments.json)?;
        let building = &prepared.building;
        Ok(Self {
            model: name.to_string(),
            conditioned_floor_area_m2: building.conditioned_floor_area,
            zones: building.zones.iter().map(Zone::of).collect(),
            systems: building.systems.iter().map(Driven::of).collect(),
            uncontrolled: building.uncontrolled.clone(),
            episode: arguments.run.map(|days| Outcome::of(&prepared, days, arguments.json)).transpose()?,
            place: prepared.place,
        })
    }

    fn driven_zones(&self) -> usize {
        self.zones.iter().filter(|zone| zone.driven).count()
    }

    fn actuators(&self) -> usize {
        self.systems.iter().map(|system| system.actuators.len()).sum()
    }

    fn count(&self, kind: &str) -> usize {
        self.systems.iter().filter(|system| system.kind == kind).count()
    }

    /// For people.
    fn text(&self, next: &Next) -> String {
        let head = format!(
            "{} in {}: {} of {} zones are driven, by {} actuators; {:.0} m² conditioned",
            self.model,
            self.place,
            self.driven_zones(),
            self.zones.len(),
            self.actuators(),
            self.conditioned_floor_area_m2
        );
        let mut parts = vec![head, format!("Driven\n{}", self.systems_text())];
        if !self.uncontrolled.is_empty() {
            parts.push(format!("Left as it is\n{}", self.uncontrolled_text()));
        }
        parts.push(format!("Zones\n{}", self.zones_text()));
        parts.extend(self.episode.as_ref().map(Outcome::text));
        parts.push(next.text());
        parts.join("\n\n")
    }

    fn systems_text(&self) -> String {
        let mut table = Table::new(["system", "kind", "zones", "actuators"]);
        for system in &self.systems {
            table.row([
                system.name.clone(),
                system.kind.clone(),
                system.zones.len().to_string(),
                system.actuators.len().to_string(),
            ]);
        }
        table.text()
    }

    fn left_text(&self) -> String {
        let mut table = Table::new(["", "what", "zones", "why"]);
        for group in groups(&self.uncontrolled) {
            table.row([
                format!("{} ×", group.members.len()),
                match &group.members[..] {
                    [one] => format!("{} `{}`", group.class, one.object.name),
                    _ => group.class.to_owned(),
                },
                group.members.iter().map(|left| left.zones.len()).sum::<usize>().to_string(),
                group.why.to_owned(),
            ]);
        }
        table.text()
    }

    fn zones_text(&self) -> String {
        let mut table = Table::new(["zone", "floor, m²", "equipment"]);
        for zone in &self.zones {
            table.row([zone.name.clone(), format!("{:.1}", zone.floor_area_m2), zone.equipment.clone()]);
        }
        table.text()
    }
}

impl Zone {
    fn of(zone: &b2b_building::Zone) -> Self {
        let equipment = match zone.conditioning {
            Conditioning::HeatingAndCooling => "driven: heating and cooling",
            Conditioning::Heating => "driven: heating",
            Conditioning::None if zone.own_controls => "under its own controls",
            Conditioning::None => "none",
        };
        Self {
            name: zone.name.clone(),
            floor_area_m2: zone.floor_area,
            driven: zone.conditioning != Conditioning::None,
            own_controls: zone.own_controls,
            equipment: equipment.to_owned(),
        }
    }
}

const UNITARY: &str = "unitary";
const AIR_LOOP: &str = "central air loop";
const HEATER: &str = "heater";

impl Driven {
    fn of(system: &System) -> Self {
        let (kind, name) = match system {
            System::Unitary(unit) => (UNITARY, &unit.zone),
            System::AirLoop(air_loop) => (AIR_LOOP, &air_loop.name),
            System::HeatingOnly(heater) => (HEATER, &heater.zone),
        };
        Self {
            kind: kind.to_owned(),
            name: name.clone(),
            zones: system.zones().into_iter().map(str::to_owned).collect(),
            actuators: system.actuators().into_iter().map(|actuator| actuator.name.clone()).collect(),
        }
    }
}

impl Outcome {
    fn of(prepared: &Prepared, period: RunPeriod, quiet: bool) -> Result<Self> {
        let mut env = prepared.env(period, 12, Task::default())?;
        let mut controller = reactive(&env, &Parameters::Tuned)?;
        roll_out(&mut env, &mut controller, quiet)?;
        let (building, metrics): (&PreparedBuilding, _) = (env.building(), env.metrics());
        let rms = |zone: &b2b_env::ZoneMetrics| zone.rms_deviation(metrics.steps);
        let worst = metrics.zones.iter().max_by(|a, b| rms(a).total_cmp(&rms(b)));
        let worst = worst.context("no zone is driven")?;
        Ok(Self {
            period: period.to_string(),
            rms_deviation_k: metrics.rms_deviation(),
            worst_zone: building.zones[worst.slot].name.clone(),
            worst_zone_rms_k: rms(worst),
            warnings: env.message_count(Level::Warning),
            severes: env.message_count(Level::Severe),
            severe_message: env.messages().at_least(Level::Severe).next().map(|m| m.text.clone()),
        })
    }

    fn text(&self) -> String {
        let severe = self.severe_message.iter().map(|m| format!("\n  severe: {}", m.replace('\n', " ")));
        format!(
            "{} under the reactive controller, 21 °C\n  RMS deviation {:.2} K over the zones with heating and cooling; \
             worst zone {}, {:.2} K\n  engine: {} warnings, {} severe{}",
            self.period,
            self.rms_deviation_k,
            self.worst_zone,
            self.worst_zone_rms_k,
            self.warnings,
            self.severes,
            severe.collect::<String>()
        )
    }
}

/// How to go on from here.
struct Next<'a> {
    model: &'a Path,
    location: &'a Location,
}

impl Next<'_> {
    fn text(&self) -> String {
        let arguments = self.location.arguments().into_iter().map(|a| quoted(&a.to_string_lossy()));
        let words: Vec<_> = [quoted(&self.model.to_string_lossy())].into_iter().chain(arguments).collect();
        let words = words.join(" ");
        format!(
            "Next\n  b2b run {words}\n  b2b show {words}     every actuator with its bounds\n  \
             b2b doctor --authority {words}     whether every actuator bites"
        )
    }
}

fn quoted(word: &str) -> String {
    if word.contains([' ', '(', ')', '\'', '&', ';']) { format!("{word:?}") } else { word.to_owned() }
}

/// What is left for one reason.
struct Group<'a> {
    class: &'a str,
    why: &'a str,
    members: Vec<&'a Uncontrolled>,
}

fn groups(uncontrolled: &[Uncontrolled]) -> Vec<Group<'_>> {
    let mut groups: Vec<Group> = Vec::new();
    for item in left {
        match groups.iter_mut().find(|g| g.class == item.object.class && g.why == item.reason) {
            Some(group) => group.members.push(item),
            None => groups.push(Group { class: &item.object.class, why: &item.reason, members: vec![item] }),
        }
    }
    groups
}

/// A line for each model.
fn table(reports: &[(String, Result<Report, String>)]) -> String {
    let mut table = Table::new([
        "model",
        "zones",
        "driven",
        "unitary",
        "air loops",
        "heaters",
        "actuators",
        "left",
        "RMS, K",
        "worst, K",
        "severe",
    ]);
    let mut notes = String::new();
    for (name, report) in reports {
        match report {
            Err(error) => {
                let mut row = [const { String::new() }; 11].map(|_| "–".to_owned());
                row[0].clone_from(name);
                table.row(row);
                notes +=
                    &format!("\n  {name}: {}", error.trim_start_matches("error: ").replace('\n', "\n  "));
            }
            Ok(report) => {
                let of_episode = |value: fn(&Outcome) -> String| {
                    report.episode.as_ref().map_or_else(|| "–".to_owned(), value)
                };
                table.row([
                    name.clone(),
                    report.zones.len().to_string(),
                    report.driven_zones().to_string(),
                    report.count(UNITARY).to_string(),
                    report.count(AIR_LOOP).to_string(),
                    report.count(HEATER).to_string(),
                    report.actuators().to_string(),
                    report.uncontrolled.len().to_string(),
                    of_episode(|e| format!("{:.2}", e.rms_deviation_k)),
                    of_episode(|e| format!("{:.2}", e.worst_zone_rms_k)),
                    of_episode(|e| e.severes.to_string()),
                ]);
                notes += &note(name, report);
            }
        }
    }
    let sound = reports.iter().filter(|(_, report)| report.is_ok()).count();
    format!("{}\n\n{sound} of {} models are environments{notes}", table.text(), reports.len())
}

/// What is left alone in a model, and why; its worst zone.
fn note(name: &str, report: &Report) -> String {
    let mut lines: Vec<String> = groups(&report.uncontrolled)
        .iter()
        .map(|g| format!("{} × {}: {}", g.members.len(), g.class, g.why))
        .collect();
    lines.extend(report.episode.iter().filter_map(|e| e.severe_message.clone()));
    lines.extend(
        report
            .episode
            .iter()
            .filter(|e| e.worst_zone_rms_k >= 1.0)
            .map(|e| format!("worst zone: {}", e.worst_zone)),
    );
    if lines.is_empty() { String::new() } else { format!("\n  {name}\n    {}", lines.join("\n    ")) }
}
