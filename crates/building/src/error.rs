//! Errors of building models.

use std::path::PathBuf;

use b2b_base::suggestion::did_you_mean;
use b2b_climate::TwoWeeks;

use crate::RunPeriod;
use crate::parameter::OutOfBounds;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that is not a valid model.
    #[error("{path}: {why}")]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A missing object that the model refers to or that an edit needs.
    #[error("missing object: the model has no {class} named `{name}`")]
    MissingObject {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
    },
    /// An HVAC component that cannot be made controllable, or a surface that cannot be read.
    #[error("{class} `{name}` cannot be made controllable: {why}")]
    Unsupported {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
        /// The reason.
        why: String,
    },
    /// An object that an edit cannot change.
    #[error("{class} `{name}` cannot be changed: {why}")]
    Edit {
        /// EnergyPlus class.
        class: String,
        /// Object name.
        name: String,
        /// The reason, and the remedy.
        why: String,
    },
    /// An edit of a model that has no object for it.
    #[error("cannot change {change}: the model has no {what}")]
    NothingToChange {
        /// The change.
        change: &'static str,
        /// The missing objects.
        what: &'static str,
    },
    /// An unknown change of a model.
    #[error("unknown parameter `{text}`; expected one of {known}")]
    UnknownChange {
        /// The name.
        text: String,
        /// Every change.
        known: String,
    },
    /// A parameter that is not within its bounds.
    #[error(transparent)]
    Parameter(#[from] OutOfBounds),
    /// A file name for an edited model that does not end in `.epJSON`.
    #[error("{path} is not a name for the edited model; expected a name that ends in .epJSON")]
    OutputName {
        /// The file.
        path: PathBuf,
    },
    /// An output file that is the model which it is made from.
    #[error("{path} is the model itself; choose another file")]
    OutputIsModel {
        /// The file.
        path: PathBuf,
    },
    /// An unknown building type.
    #[error(
        "unknown building type `{text}`{}; expected one of {known}",
        did_you_mean(near.unwrap_or_default())
    )]
    UnknownType {
        /// The name.
        text: String,
        /// The most similar type.
        near: Option<&'static str>,
        /// Every type.
        known: String,
    },
    /// Text that is not a day of the year.
    #[error("invalid date `{text}`; expected MM-DD without a year, for example 02-28")]
    Date {
        /// The text.
        text: String,
    },
    /// Text that is not a run period.
    #[error(
        "invalid run period `{text}`{}; expected winter, summer, full_year or MM-DD..MM-DD, from the first day to the last, which \
         may be after New Year",
        near_period(text, &[])
    )]
    RunPeriod {
        /// The text.
        text: String,
    },
    /// A period that the calendar of a building does not have.
    #[error("{name} cannot run {period}: {why}")]
    PeriodOfCalendar {
        /// Name of the building.
        name: String,
        /// The period.
        period: String,
        /// The reason and the remedy.
        why: &'static str,
    },
    /// A weather file of part of a year, where a year is simulated.
    #[error("{weather} has only days of {days}; a year of metered energy needs weather of every day", weather = weather.display())]
    PartOfYear {
        /// The weather file.
        weather: PathBuf,
        /// Its days, from the first to the last.
        days: RunPeriod,
    },
    /// Text that is neither a run period nor a named two-week period.
    #[error(
        "invalid run period `{text}`{}; expected winter, summer, full_year, MM-DD..MM-DD from the first day to the last, which \
         may be after New Year, or two weeks chosen from the weather: {}",
        near_period(text, &TWO_WEEKS), TWO_WEEKS.join(", ")
    )]
    Period {
        /// The text.
        text: String,
    },
    /// A weather file without the hours of a year.
    #[error(
        "{weather} does not cover a year, from which two weeks are chosen; give the days as MM-DD..MM-DD"
    )]
    NotOneYear {
        /// The weather file.
        weather: PathBuf,
    },
    /// A file that could not be read or written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A user's model that is rejected, for example for problems that the engine would silently accept.
    #[error("{path} cannot be imported:{}", problems.iter().map(|p| format!("\n  {p}")).collect::<String>())]
    Import {
        /// The file.
        path: PathBuf,
        /// The problems, each with its remedy.
        problems: Vec<String>,
    },
    /// A model without any HVAC system that can be made controllable.
    #[error("{name} has no controllable system:{}", lines(reasons))]
    NothingToControl {
        /// Name of the building.
        name: String,
        /// Its uncontrolled systems with the reason, one line for all systems of a class with the same reason.
        reasons: Vec<String>,
    },
    /// A model whose conditioned zones have no floor area.
    #[error(
        "the conditioned zones of {name} have a floor area of 0 m², by which energy is divided; give them floors, or enter \
         a `floor_area` above 0 in their Zone objects"
    )]
    NoFloorArea {
        /// Name of the building.
        name: String,
    },
    /// The engine rejected a model or failed.
    #[error(transparent)]
    Engine(#[from] b2b_energyplus::Error),
    /// The engine's table of sizes could not be read.
    #[error("the sizes in {path} cannot be read: {source}")]
    SizeTable {
        /// The engine's SQLite output.
        path: PathBuf,
        /// The error of SQLite.
        source: rusqlite::Error,
    },
    /// The engine's values of schedules could not be read.
    #[error("the values of schedules in {path} cannot be read: {source}")]
    ScheduleTable {
        /// The engine's SQLite output.
        path: PathBuf,
        /// The error of SQLite.
        source: rusqlite::Error,
    },
    /// The engine's table of monthly energy could not be read.
    #[error("the energy in {path} cannot be read: {source}")]
    EnergyTable {
        /// The engine's SQLite output.
        path: PathBuf,
        /// The error of SQLite.
        source: rusqlite::Error,
    },
    /// A table of metered energy with an error.
    #[error("{path}, line {line}: {why}")]
    Metered {
        /// The file.
        path: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// The problem, and the remedy.
        why: String,
    },
    /// More parameters of a calibration than metered values.
    #[error(
        "{parameters} parameters cannot be found from {values} metered values; give more months, or name fewer with \
         --parameter (`parameters` in Python)"
    )]
    FewMeteredValues {
        /// Number of parameters.
        parameters: usize,
        /// Number of metered values.
        values: usize,
    },
    /// A place or weather file that cannot be used.
    #[error(transparent)]
    Climate(#[from] b2b_climate::Error),
}

impl Error {
    /// An [`Error::Edit`] for an object.
    pub fn edit(class: &str, name: &str, why: &str) -> Self {
        Self::Edit { class: class.to_owned(), name: name.to_owned(), why: why.to_owned() }
    }

    /// Describes the work of a lost process: see [`b2b_energyplus::Error::while_doing`].
    #[must_use]
    pub fn while_doing(self, doing: impl Into<String>) -> Self {
        match self {
            Self::Engine(error) => Self::Engine(error.while_doing(doing)),
            other => other,
        }
    }

    /// Names the model of a failed run: see [`b2b_energyplus::Error::on_model`].
    #[must_use]
    pub fn on_model(self, model: &str) -> Self {
        match self {
            Self::Engine(error) => Self::Engine(error.on_model(model)),
            other => other,
        }
    }

    /// Names the zones of an [`Error::Unsupported`].
    pub(crate) fn in_zones(self, zones: &[String]) -> Self {
        match self {
            Self::Unsupported { class, name, why } if !zones.is_empty() => {
                Self::Unsupported { class, name, why: format!("{why} (zone `{}`)", zones.join("`, `")) }
            }
            other => other,
        }
    }

    /// An [`Error::Unsupported`] for an object.
    pub fn unsupported(class: &str, name: &str, why: &str) -> Self {
        Self::Unsupported { class: class.to_owned(), name: name.to_owned(), why: why.to_owned() }
    }
}

/// A result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// The names of two-week periods chosen from the weather.
const TWO_WEEKS: [&str; TwoWeeks::ALL.len()] = {
    let [a, b, c, d, e] = TwoWeeks::ALL;
    [a.name(), b.name(), c.name(), d.name(), e.name()]
};

/// Returns the named run period that a text resembles, as part of a message. `others` are names in addition to winter,
/// summer and the full year.
fn near_period(text: &str, others: &[&str]) -> String {
    let is_near = |name: &&str| strsim::damerau_levenshtein(name, &text.to_lowercase()) <= 2;
    let names = ["winter", "summer", "full_year"].into_iter();
    let near = names.chain(others.iter().copied()).find(is_near);
    did_you_mean(near.unwrap_or_default())
}

/// The reasons, one per line.
fn lines(reasons: &[String]) -> String {
    if reasons.is_empty() {
        return " it has no air loop, unit heater or baseboard".to_owned();
    }
    reasons.iter().map(|reason| format!("\n  {reason}")).collect()
}
