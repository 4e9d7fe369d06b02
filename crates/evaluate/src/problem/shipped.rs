//! The shipped problems, and problems from files and types.

use std::path::Path;
use std::sync::OnceLock;

use b2b_building::{BuildingType, user_file};

use super::buildings::{Buildings, Subset};
use super::definition::Problem;
use super::list::joined;
use super::side::Side;
use crate::error::at;
use crate::{Error, Result};

/// The shipped problems.
pub(super) const SHIPPED: [&str; 28] = [
    include_str!("../../data/problems/operate-office-small.json"),
    include_str!("../../data/problems/operate-office-medium.json"),
    include_str!("../../data/problems/operate-retail.json"),
    include_str!("../../data/problems/operate-restaurant.json"),
    include_str!("../../data/problems/operate-warehouse.json"),
    include_str!("../../data/problems/operate-house.json"),
    include_str!("../../data/problems/operate-all.json"),
    include_str!("../../data/problems/operate-goal.json"),
    include_str!("../../data/problems/adapt-house.json"),
    include_str!("../../data/problems/adapt-office-small.json"),
    include_str!("../../data/problems/adapt-all.json"),
    include_str!("../../data/problems/adapt-house-faults.json"),
    include_str!("../../data/problems/adapt-office-small-faults.json"),
    include_str!("../../data/problems/goal-energy-weight.json"),
    include_str!("../../data/problems/goal-setpoint-mode.json"),
    include_str!("../../data/problems/goal-leave-one-out.json"),
    include_str!("../../data/problems/dynamics-house.json"),
    include_str!("../../data/problems/dynamics-office-small.json"),
    include_str!("../../data/problems/dynamics-office-medium.json"),
    include_str!("../../data/problems/unitary-5-10.json"),
    include_str!("../../data/problems/unitary-10-5.json"),
    include_str!("../../data/problems/central-33-36.json"),
    include_str!("../../data/problems/central-36-33.json"),
    include_str!("../../data/problems/retail-to-office-small.json"),
    include_str!("../../data/problems/retail-to-warehouse.json"),
    include_str!("../../data/problems/office-small-to-office-medium.json"),
    include_str!("../../data/problems/four-types.json"),
    include_str!("../../data/problems/small-to-offices.json"),
];

impl Problem {
    /// Returns the shipped problems: operation first, then memory, then the tracking problems family by family.
    pub fn all() -> &'static [Self] {
        static ALL: OnceLock<Vec<Problem>> = OnceLock::new();
        ALL.get_or_init(|| {
            SHIPPED
                .iter()
                .map(|text| serde_json::from_str(text).expect("a test reads every shipped problem"))
                .collect()
        })
    }

    /// Returns a shipped problem by name.
    ///
    /// # Errors
    /// [`Error::UnknownProblem`] with similar names.
    pub fn named(name: &str) -> Result<Self> {
        let found = Self::all().iter().find(|problem| problem.name == name);
        found.cloned().ok_or_else(|| {
            // Difficulties of the original Python implementation.
            let difficulty = match name {
                "easy" => Some("dynamics-house"),
                "medium" => Some("dynamics-office-small"),
                "hard" => Some("dynamics-office-medium"),
                _ => None,
            };
            if let Some(problem) = difficulty {
                return Error::UnknownProblem { text: name.to_owned(), near: problem.to_owned() };
            }
            let mut near: Vec<_> = Self::all().iter().map(|problem| problem.name.as_str()).collect();
            let similarity =
                |known: &str| strsim::jaro_winkler(known, &name.to_lowercase().replace('_', "-"));
            near.sort_by(|a, b| similarity(b).total_cmp(&similarity(a)));
            near.retain(|known| similarity(known) > 0.8);
            near.truncate(2);
            Error::UnknownProblem { text: name.to_owned(), near: near.join(" or ") }
        })
    }

    /// Reads a problem from a JSON file of the shipped format.
    ///
    /// # Errors
    /// [`Error::Io`](crate::Error::Io); [`Error::ProblemFile`]; errors from [`Problem::check`].
    pub fn read(path: &Path) -> Result<Self> {
        let text = user_file::read(path).map_err(at(path))?;
        let problem: Self = user_file::parse_object(&text)
            .map_err(|why| Error::ProblemFile { path: path.to_owned(), why })?;
        problem.check()?;
        Ok(problem)
    }

    /// Returns a problem from some building types to others, with the protocol of the shipped cross-domain problems.
    ///
    /// # Errors
    /// The errors of [`Problem::check`].
    pub fn cross_domain(train: &[BuildingType], test: &[BuildingType]) -> Result<Self> {
        let like = Self::named("retail-to-office-small")?;
        let side = |side: &Side, types: &[BuildingType], subset| {
            let buildings = Buildings::Subset { types: types.to_vec(), subset, count: None };
            Side { buildings, sizes: Vec::new(), ..side.clone() }
        };
        let names =
            |types: &[BuildingType]| types.iter().map(|each| each.name()).collect::<Vec<_>>().join("+");
        let problem = Self {
            name: format!("{}-to-{}", names(train), names(test)),
            question: format!(
                "A policy was trained in buildings of {}. How does it perform in those of {}?",
                joined(train),
                joined(test)
            ),
            train: side(&like.train, train, Subset::Train),
            test: side(&like.test, test, Subset::Test),
            ..like
        };
        problem.check()?;
        Ok(problem)
    }
}
