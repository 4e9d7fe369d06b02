//! The shipped tariffs and emission profiles: one file and one line each.

use std::path::Path;

use b2b_base::suggestion::nearest;

use crate::emissions::Emissions;
use crate::error::{Error, Result};
use crate::tariff::Tariff;

/// The shipped tariffs by name.
const TARIFFS: [(&str, &str); 18] = [
    ("flat", include_str!("../data/tariffs/generic/flat.toml")),
    ("tou", include_str!("../data/tariffs/generic/tou.toml")),
    ("dynamic", include_str!("../data/tariffs/generic/dynamic.toml")),
    ("hq-d", include_str!("../data/tariffs/hydro_quebec/hq-d.toml")),
    ("hq-flex-d", include_str!("../data/tariffs/hydro_quebec/hq-flex-d.toml")),
    ("hq-dt", include_str!("../data/tariffs/hydro_quebec/hq-dt.toml")),
    ("hq-g", include_str!("../data/tariffs/hydro_quebec/hq-g.toml")),
    ("hq-flex-g", include_str!("../data/tariffs/hydro_quebec/hq-flex-g.toml")),
    ("hq-m", include_str!("../data/tariffs/hydro_quebec/hq-m.toml")),
    ("hq-flex-m", include_str!("../data/tariffs/hydro_quebec/hq-flex-m.toml")),
    ("hq-g9", include_str!("../data/tariffs/hydro_quebec/hq-g9.toml")),
    ("fpl-gsdt-1", include_str!("../data/tariffs/united_states/fpl-gsdt-1.toml")),
    ("teco-gst", include_str!("../data/tariffs/united_states/teco-gst.toml")),
    ("georgia-tou-eo-11", include_str!("../data/tariffs/united_states/georgia-tou-eo-11.toml")),
    ("rpu-medium-gs-tou", include_str!("../data/tariffs/united_states/rpu-medium-gs-tou.toml")),
    ("minnesota-power-gs", include_str!("../data/tariffs/united_states/minnesota-power-gs.toml")),
    ("gvea-gs-1", include_str!("../data/tariffs/united_states/gvea-gs-1.toml")),
    ("pge-b10", include_str!("../data/tariffs/united_states/pge-b10.toml")),
];

/// The shipped emission profiles by name.
const EMISSIONS: [(&str, &str); 13] = [
    ("us", include_str!("../data/emissions/us.toml")),
    ("alaska", include_str!("../data/emissions/alaska.toml")),
    ("quebec", include_str!("../data/emissions/quebec.toml")),
    ("frcc-average", include_str!("../data/emissions/frcc-average.toml")),
    ("frcc-marginal", include_str!("../data/emissions/frcc-marginal.toml")),
    ("srso-average", include_str!("../data/emissions/srso-average.toml")),
    ("srso-marginal", include_str!("../data/emissions/srso-marginal.toml")),
    ("nyst-average", include_str!("../data/emissions/nyst-average.toml")),
    ("nyst-marginal", include_str!("../data/emissions/nyst-marginal.toml")),
    ("mrow-average", include_str!("../data/emissions/mrow-average.toml")),
    ("mrow-marginal", include_str!("../data/emissions/mrow-marginal.toml")),
    ("rmpa-average", include_str!("../data/emissions/rmpa-average.toml")),
    ("rmpa-marginal", include_str!("../data/emissions/rmpa-marginal.toml")),
];

impl Tariff {
    /// Returns the names of the shipped tariffs.
    pub fn names() -> impl Iterator<Item = &'static str> {
        TARIFFS.into_iter().map(|(name, _)| name)
    }

    /// Returns a shipped tariff by name, or reads a TOML file.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the most similar name; the errors of [`Tariff::read`].
    pub fn named(name: &str) -> Result<Self> {
        match TARIFFS.into_iter().find(|(known, _)| *known == name) {
            Some((known, text)) => Self::parse(known, known, text),
            None if is_path(name) => Self::read(Path::new(name)),
            None => Err(unknown("tariff", name, &TARIFFS)),
        }
    }
}

impl Emissions {
    /// Returns the names of the shipped emission profiles.
    pub fn names() -> impl Iterator<Item = &'static str> {
        EMISSIONS.into_iter().map(|(name, _)| name)
    }

    /// Returns a shipped emission profile by name, or reads a TOML file.
    ///
    /// # Errors
    /// [`Error::Unknown`] with the most similar name; the errors of [`Emissions::read`].
    pub fn named(name: &str) -> Result<Self> {
        match EMISSIONS.into_iter().find(|(known, _)| *known == name) {
            Some((known, text)) => Self::parse(known, known, text),
            None if is_path(name) => Self::read(Path::new(name)),
            None => Err(unknown("emission profile", name, &EMISSIONS)),
        }
    }
}

/// Returns the text of a shipped tariff or emission profile by name; `None` for other names.
pub fn shipped_text(name: &str) -> Option<&'static str> {
    TARIFFS.into_iter().chain(EMISSIONS).find_map(|(known, text)| (known == name).then_some(text))
}

/// Returns whether a name is the path of a file.
fn is_path(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension == "toml")
}

fn unknown(what: &'static str, name: &str, known: &[(&'static str, &str)]) -> Error {
    let names: Vec<_> = known.iter().map(|(known, _)| *known).collect();
    Error::Unknown {
        what,
        name: name.to_owned(),
        near: nearest(name, names.iter().copied()),
        known: names.join(", "),
    }
}
