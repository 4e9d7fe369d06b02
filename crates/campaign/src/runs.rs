//! Damaged models, weather files, trajectories and arguments, given to the commands.

use std::ffi::OsString;
use std::os::unix::ffi::OsStringExt;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

use crate::Campaign;
use crate::material::Material;
use crate::mutation::{mutate, mutate_value, pick};
use crate::program::{Ended, words};

/// Time after which a run counts as endless: simulating a day takes a second, and preparation at most ten minutes.
const LIMIT: Duration = Duration::from_secs(700);
/// Time after which a command with random arguments is interrupted: some are valid and run for long.
const PATIENCE: Duration = Duration::from_secs(20);
const ARGUMENTS: &str = "arguments";
/// A day of the model `m.epJSON` under the weather `w.epw`.
const RUN: &str = "run m.epJSON --weather w.epw --period 01-01..01-01 --out out --json";

/// A kind of attack: a function that writes files to a folder and returns the arguments of the program.
type Attack = fn(&Material, &Path, &mut ChaCha8Rng) -> Result<Vec<OsString>>;

const ATTACKS: [(&str, Attack); 4] = [
    ("run of a damaged model", damaged_model),
    ("run under damaged weather", damaged_weather),
    ("score of a damaged trajectory", damaged_trajectory),
    (ARGUMENTS, absurd_arguments),
];

/// Attacks the commands until a deadline.
pub fn attack(Campaign { program, material, deadline, mut random, ledger }: Campaign<'_>) -> Result<()> {
    while Instant::now() < deadline {
        let (kind, attack) = *pick(&ATTACKS, &mut random);
        let folder = tempfile::tempdir()?;
        let arguments = attack(material, folder.path(), &mut random)?;
        let mut run = program.start(folder.path(), "", &arguments)?;
        if kind == ARGUMENTS {
            run.interrupt_after(PATIENCE)?;
        }
        let ended = run.end(LIMIT)?;
        let broken = ended.broken(false).or_else(|| nonsense(&ended, &arguments));
        let broken = broken.map(|why| format!("{why}\narguments: {arguments:?}"));
        ledger.judge(kind, broken, ended.code(), folder.path())?;
    }
    Ok(())
}

/// Returns why the output of a successful run is invalid: no JSON, or metrics that are not numbers.
fn nonsense(ended: &Ended, arguments: &[OsString]) -> Option<String> {
    let has = |option: &str| arguments.iter().any(|argument| argument == option);
    let prints_metrics = arguments.first()? == "run" && has("--json") && !has("--help");
    if ended.code() != Some(0) || !prints_metrics {
        return None;
    }
    let Ok(summary) = serde_json::from_str::<Value>(&ended.output) else {
        return Some(format!("success without JSON: {}", ended.output));
    };
    let metrics = ["return", "rms_deviation_k", "electricity_wh_m2", "gas_wh_m2", "meter_relative_error"];
    let missing = metrics.iter().find(|name| !summary[**name].is_number());
    missing.map(|name| format!("success with {name} {}", summary[name]))
}

fn damaged_model(material: &Material, folder: &Path, random: &mut ChaCha8Rng) -> Result<Vec<OsString>> {
    let mut model: Value = serde_json::from_slice(&std::fs::read(pick(material.models(), random))?)?;
    for _ in 0..random.random_range(1..4) {
        // In a random object of a random class, so that large classes are not damaged more often than small ones.
        let classes = model.as_object_mut().context("a model is an object")?;
        let class = random.random_range(0..classes.len());
        let objects =
            classes.values_mut().nth(class).and_then(Value::as_object_mut).context("a class is an object")?;
        if !objects.is_empty() {
            let object = random.random_range(0..objects.len());
            objects.values_mut().nth(object).into_iter().for_each(|object| mutate_value(object, random));
        }
        classes.retain(|_, objects| objects.is_object());
    }
    std::fs::write(folder.join("m.epJSON"), model.to_string())?;
    std::fs::copy(material.path("weather.epw"), folder.join("w.epw"))?;
    Ok(words(RUN))
}

fn damaged_weather(material: &Material, folder: &Path, random: &mut ChaCha8Rng) -> Result<Vec<OsString>> {
    std::fs::copy(pick(material.models(), random), folder.join("m.epJSON"))?;
    let mut weather = material.bytes("weather.epw")?;
    // Half of the damage is in the header, most of the rest in the simulated day.
    let (header, day) = (2_000, 12_000);
    let end = if random.random_bool(0.5) { header } else { day };
    let rest = weather.split_off(end);
    weather = mutate(&weather, random);
    weather.extend(rest);
    std::fs::write(folder.join("w.epw"), weather)?;
    Ok(words(RUN))
}

fn damaged_trajectory(material: &Material, folder: &Path, random: &mut ChaCha8Rng) -> Result<Vec<OsString>> {
    std::fs::write(folder.join("t.parquet"), mutate(&material.bytes("run/trajectory.parquet")?, random))?;
    Ok(words("score t.parquet"))
}

/// Commands that absurd arguments are given to.
const COMMANDS: [&str; 14] = [
    "run",
    "show",
    "list",
    "generate",
    "evaluate",
    "score",
    "train",
    "import",
    "view",
    "baseline",
    "benchmark",
    "dataset",
    "collect",
    "experiment",
];

/// Arguments of any command, sensible or not.
const OTHERS: [&str; 44] = [
    "SingleFamilyHouse",
    "SingleFamilyHouse-0018",
    "OfficeSmall-9999",
    "types",
    "places",
    "--json",
    "--help",
    "--period",
    "01-01..01-01",
    "02-29..02-30",
    "12-31..01-01",
    "winter",
    "--task",
    "constant",
    "random+energy-1",
    "occupancy+pmv+energy0.5",
    "--out",
    "out",
    "/dev/null",
    ".",
    "--place",
    "Denver",
    "Atlantis",
    "--weather",
    "missing.epw",
    "--seed",
    "-1",
    "0",
    "18446744073709551616",
    "--steps-per-hour",
    "7",
    "60",
    "--policy",
    "reactive",
    "off",
    "--type",
    "--zone",
    "5",
    "9",
    "--set",
    "floor_area=1e9",
    "--jobs",
    "--count",
    "1",
];

/// Returns arguments that are plausible one by one, in random order.
fn absurd_arguments(_: &Material, _: &Path, random: &mut ChaCha8Rng) -> Result<Vec<OsString>> {
    let mut arguments = vec![OsString::from(*pick(&COMMANDS, random))];
    for _ in 0..random.random_range(0..8) {
        let mut argument = OsString::from(*pick(&OTHERS, random));
        if random.random_bool(0.05) {
            argument.push(OsString::from_vec(vec![0xff, b'x']));
        }
        arguments.push(argument);
    }
    // Limits valid commands to one day.
    if arguments[0] == "run" || arguments[0] == "evaluate" || arguments[0] == "collect" {
        arguments.extend(words("--period 01-01..01-01"));
    }
    Ok(arguments)
}
