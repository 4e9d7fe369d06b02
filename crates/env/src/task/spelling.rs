//! The short text form of a task: see [`Task`].

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use b2b_base::suggestion::did_you_mean;
use b2b_tariff::Tariff;

use super::{DataFile, OPERATION_WEIGHT, Task};
use crate::preview::Preview;
use crate::setpoints::Setpoints;
use crate::setpoints::band::Band;
use crate::terms::Resource;
use crate::zones::carbon_dioxide::CarbonDioxide;
use crate::zones::comfort::{Comfort, Pmv};
use crate::zones::ventilation::Ventilation;
use crate::{Error, Result};

/// The part of a task with a preview.
const PREVIEW: &str = "preview";
/// The part of a task with the CO₂ balance.
const CARBON_DIOXIDE: &str = "co2";
/// The part of a task without the ventilation interlock.
const FREE_VENTILATION: &str = "free-ventilation";
/// The part of a task whose faults differ between buildings.
const OWN_FAULTS: &str = "own-faults";

impl Task {
    /// The numbers of random presence and faults, by keyword.
    fn disturbances(&mut self) -> [(&'static str, &mut f64); 5] {
        let [noise, bias, stuck, fouling] = self.faults.parts();
        [("presence", &mut self.presence.hours), noise, bias, stuck, fouling]
    }

    /// Turns on the option that a word names. Returns whether it was off; `None` if the word names no option.
    fn turn_on(&mut self, word: &str) -> Option<bool> {
        match word {
            FREE_VENTILATION => {
                Some(std::mem::replace(&mut self.ventilation, Ventilation::Free) != Ventilation::Free)
            }
            PREVIEW => Some(self.preview.replace(Preview::default()).is_none()),
            CARBON_DIOXIDE => Some(self.carbon_dioxide.replace(CarbonDioxide::default()).is_none()),
            OWN_FAULTS => Some(!std::mem::replace(&mut self.faults.own, true)),
            _ => None,
        }
    }

    /// Returns the text form of the nearest task that has one.
    fn spelling(&self) -> String {
        let setpoints = match &self.setpoints {
            Setpoints::Constant { target } if *target == 21.0 => "constant".to_owned(),
            Setpoints::Constant { target } => format!("constant:{target}"),
            Setpoints::Occupancy { .. } => "occupancy".to_owned(),
            Setpoints::Random { seed: 0, .. } => "random".to_owned(),
            Setpoints::Random { seed, .. } => format!("random:{seed}"),
            Setpoints::Band { band } => spelled_band(band),
        };
        let comfort = match &self.comfort {
            Comfort::Band { weight } if self.is_operation() && *weight == OPERATION_WEIGHT => String::new(),
            Comfort::Band { weight } => format!("+band{weight}"),
            Comfort::Squared => String::new(),
            Comfort::Deadband { half_width: 1.0 } => "+deadband".to_owned(),
            Comfort::Deadband { half_width } => format!("+deadband{half_width}"),
            Comfort::Pmv(_) => "+pmv".to_owned(),
        };
        let resource = match self.resource {
            Resource::COST if self.is_operation() && self.energy_weight == 1.0 => String::new(),
            Resource::ENERGY if self.energy_weight == 0.0 => String::new(),
            resource => format!("+{}{}", resource.penalty().word, self.energy_weight),
        };
        let tariff = self.tariff.as_ref().map_or_else(String::new, |tariff| format!("+{}", tariff.name()));
        let preview = self.preview.map_or_else(String::new, |_| format!("+{PREVIEW}"));
        let air = self.carbon_dioxide.map_or_else(String::new, |_| format!("+{CARBON_DIOXIDE}"));
        let ventilation = match self.ventilation {
            Ventilation::Code => String::new(),
            Ventilation::Free => format!("+{FREE_VENTILATION}"),
        };
        let mut task = self.clone();
        let disturbances = task.disturbances().into_iter().filter(|(_, value)| **value != 0.0);
        let disturbances: String = disturbances.map(|(word, value)| format!("+{word}{value}")).collect();
        let own = if self.faults.own { format!("+{OWN_FAULTS}") } else { String::new() };
        format!("{setpoints}{comfort}{resource}{tariff}{preview}{air}{ventilation}{disturbances}{own}")
    }
}

impl fmt::Display for Task {
    /// Writes the short text form. A task without a text form gets the nearest task's, followed by the start of its own
    /// hash, as in `occupancy#1a2b3c4d`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let spelling = self.spelling();
        match spelling.parse::<Self>() {
            Ok(task) if task == *self => f.write_str(&spelling),
            _ => write!(f, "{spelling}#{}", &self.hash()[..8]),
        }
    }
}

impl FromStr for Task {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let error = |why: String| Error::UnknownTask { text: text.to_owned(), why };
        let unknown = |part: &str| match of_preset(text) {
            Some(task) => error(format!(", which is called {task} here (docs/coming_from.md)")),
            None if part.starts_with("operate:") => error(format!(
                ": `{part}` needs the bands of occupied and of other hours, such as operate:21-24/15.6-28"
            )),
            None if part == text => error(suggestion(part)),
            None => error(format!(": unknown part `{part}`{}", suggestion(part))),
        };
        let twice = |word: &str| error(format!(": `{word}` is given twice"));
        let no_number = |word: &str| error(format!(": `{word}` needs a number, such as {word}0.5"));
        let mut parts = text.split('+');
        let setpoints = parts.next().unwrap_or_default();
        let mut task = match setpoints.parse().map_err(|()| unknown(setpoints))? {
            Setpoints::Band { band } => Self::operate(band),
            setpoints => Self { setpoints, ..Self::default() },
        };
        let (mut comfort, mut resource) = (false, false);
        for part in parts {
            if let Some(is_new) = task.turn_on(part) {
                if !is_new {
                    return Err(twice(part));
                }
                continue;
            }
            if let Some(tariff) = tariff_of(part)? {
                if task.tariff.replace(tariff).is_some() {
                    return Err(error(format!(": `{part}` is a second tariff")));
                }
                continue;
            }
            let (word, number) = word_and_number(part).ok_or_else(|| unknown(part))?;
            if let Some((_, value)) = task.disturbances().into_iter().find(|(known, _)| *known == word) {
                if std::mem::replace(value, number.ok_or_else(|| no_number(word))?) != 0.0 {
                    return Err(twice(word));
                }
                continue;
            }
            let seen = if let Some(chosen) = comfort_of(word, number) {
                task.comfort = chosen;
                &mut comfort
            } else {
                task.resource = Resource::of_word(word).ok_or_else(|| unknown(part))?;
                task.energy_weight = number.ok_or_else(|| no_number(word))?;
                &mut resource
            };
            if std::mem::replace(seen, true) {
                return Err(error(format!(": `{word}` is a second comfort or resource")));
            }
        }
        task.check().map(|()| task)
    }
}

/// Returns the text form of the nearest band that has one.
fn spelled_band(band: &Band) -> String {
    match band {
        Band::Presence { occupied: [heating, cooling], unoccupied: [setback, setup] } => {
            format!("operate:{heating}-{cooling}/{setback}-{setup}")
        }
        Band::Own | Band::Hours { .. } => "operate".to_owned(),
    }
}

/// Every word of a text form but the names of tariffs.
const WORDS: [&str; 20] = [
    PREVIEW,
    CARBON_DIOXIDE,
    "constant",
    "occupancy",
    "random",
    "operate",
    "band",
    "deadband",
    "pmv",
    "energy",
    "cost",
    "carbon",
    "peak",
    FREE_VENTILATION,
    "presence",
    "noise",
    "bias",
    "stuck",
    "fouling",
    OWN_FAULTS,
];

/// Returns a question with the word most similar to a misspelled one; empty if none is similar.
fn suggestion(part: &str) -> String {
    let given = word_and_number(part).map_or(part, |(word, _)| word);
    let words = WORDS.into_iter().map(|word| (word, given)).chain(Tariff::names().map(|name| (name, part)));
    let near = words.map(|(word, given)| (strsim::damerau_levenshtein(word, given), word)).min();
    let near = near.filter(|(distance, word)| *distance > 0 && distance * 3 <= word.len());
    did_you_mean(near.map_or("", |(_, word)| word))
}

/// Returns the text form of a preset of the original Python implementation, such as `task_occ_e05`.
fn of_preset(text: &str) -> Option<String> {
    let (mode, energy) = text.strip_prefix("task_")?.split_once('_')?;
    let setpoints = match mode {
        "const" => "constant",
        "occ" => "occupancy",
        "rand" => "random",
        _ => return None,
    };
    let rest = match energy {
        "e0" => "",
        "e05" => "+energy0.5",
        "emed" => "+deadband+energy1",
        "ehigh" => "+deadband+energy5",
        _ => return None,
    };
    Some(format!("{setpoints}{rest}"))
}

/// Splits `deadband0.5` into word and number, if it has one. Returns `None` if the rest of the text is not a number.
fn word_and_number(part: &str) -> Option<(&str, Option<f64>)> {
    let word = part.trim_end_matches(|c: char| c.is_ascii_digit() || ".-".contains(c));
    match &part[word.len()..] {
        "" => Some((word, None)),
        number => Some((word, Some(number.parse().ok()?))),
    }
}

/// Returns the tariff that a part names: one that ships with this software, or a file.
fn tariff_of(part: &str) -> Result<Option<DataFile>> {
    if part.ends_with(".toml") {
        return DataFile::read(Path::new(part)).map(Some);
    }
    let known = Tariff::names().find(|name| *name == part);
    Ok(known.map(|name| DataFile::Shipped(name.to_owned())))
}

fn comfort_of(word: &str, number: Option<f64>) -> Option<Comfort> {
    match (word, number) {
        ("band", weight) => Some(Comfort::Band { weight: weight.unwrap_or(OPERATION_WEIGHT) }),
        ("deadband", half_width) => Some(Comfort::Deadband { half_width: half_width.unwrap_or(1.0) }),
        ("pmv", None) => Some(Comfort::Pmv(Pmv::default())),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(text: &str) -> Task {
        text.parse().unwrap()
    }

    #[test]
    fn a_misspelled_word_gets_the_nearest() {
        for (text, near) in
            [("occupency", "occupancy"), ("constant+enregy0.5", "energy"), ("randon:3", "random")]
        {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(said.contains(&format!("did you mean {near}?")), "{said}");
        }
        let said = "warm".parse::<Task>().unwrap_err().to_string();
        assert!(!said.contains("did you mean"), "{said}");
    }

    #[test]
    fn a_text_form_parses_to_the_task_that_printed_it() {
        for text in Task::NAMED.iter().copied().chain([
            "constant:23.5",
            "random:7",
            "occupancy+deadband",
            "occupancy+deadband0.5+cost2",
            "random:3+pmv+carbon0.1",
            "constant+peak1",
            "constant+free-ventilation",
            "occupancy+energy0.5+noise0.2+bias0.5",
            "occupancy+presence2+noise0.2",
            "constant+stuck0.1+fouling0.25",
            "random+bias0.5+fouling0.25+own-faults",
            "random:3+deadband+energy0.5+free-ventilation",
            "operate",
            "operate:21-24/15.6-28",
            "operate+band30+cost2",
            "operate+energy0.5",
            "operate+tou",
            "operate+tou+preview",
            "operate+co2",
            "operate+pmv+tou+preview+co2",
            "operate:21-24/15.6-28+cost2+hq-m",
        ]) {
            assert_eq!(task(text).to_string(), text);
        }
        assert_eq!(task("constant"), Task::default());
        assert_eq!(task("occupancy+energy0.5").energy_weight, 0.5);
    }

    #[test]
    fn the_error_for_an_unknown_task_says_what_is_expected() {
        for text in
            ["", "occupied", "constant+energy", "constant+energy0.5+cost1", "constant+pmv2", "random:x"]
        {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(said.contains(&format!("unknown task `{text}`")), "{said}");
            assert!(said.contains("expected") && said.contains("occupancy+energy0.5"), "{said}");
        }
        for (text, why) in [
            ("occupancy+presence", "`presence` needs a number, such as presence0.5"),
            ("occupancy+presnce2", "unknown part `presnce2`"),
            ("occupancy+presence2h", "unknown part `presence2h`"),
            ("occupancy+noise1+noise2", "`noise` is given twice"),
            ("occupancy+own-faults", "`own-faults` has no faults to draw; add one, such as +bias0.5"),
            ("occupancy+bias1+own-faults+own-faults", "`own-faults` is given twice"),
            ("occupancy+bias1+own-fault", "did you mean own-faults?"),
            ("occupancy+cost1+energy2", "`energy` is a second comfort or resource"),
        ] {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(said.contains(why), "{said}");
        }
        for (text, words) in [
            ("constant:99", ["target", "99"]),
            ("constant+energy-1", ["energy_weight", "-1"]),
            ("constant+deadband-1", ["half_width", "-1"]),
        ] {
            let said = text.parse::<Task>().unwrap_err().to_string();
            assert!(words.iter().all(|word| said.contains(word)), "{said}");
        }
    }

    #[test]
    fn the_error_for_a_preset_of_the_original_implementation_names_a_valid_task() {
        for mode in ["const", "occ", "rand"] {
            for energy in ["e0", "e05", "emed", "ehigh"] {
                let preset = format!("task_{mode}_{energy}");
                let said = preset.parse::<Task>().unwrap_err().to_string();
                let now = of_preset(&preset).unwrap();
                assert!(said.contains(&format!("`{preset}`, which is called {now} here ")), "{said}");
                assert_eq!(task(&now).to_string(), now);
            }
        }
    }

    #[test]
    fn a_task_without_a_text_form_prints_the_start_of_its_hash() {
        let own = Task { comfort_band: 0.5, ..Task::default() };
        assert!(own.to_string().starts_with("constant#"), "{own}");
    }
}
