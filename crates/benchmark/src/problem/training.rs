//! Training environments of a problem, as a batch that draws a building for every episode.

use std::sync::Arc;

use b2b_building::morphology::COMMON;
use b2b_control::ReactiveParameters;
use b2b_dataset::{BuildingName, Control, Placement};
use b2b_env::{ActionSpace, Spaces, attribute_name, attributes};
use b2b_evaluate::problem::{Attributes, Problem, RestrictedAction, Restriction};
use b2b_evaluate::{Error, Result};
use b2b_workers::{Arranged, Arrangement, EpisodeForm, Form, Padded, RowSlot, check_width};

/// The observations and actions of a problem's training side, in the form in which a policy is tested on the problem:
/// padded, with the building's attributes if they are given, and without the withheld actuators.
#[derive(Clone, Debug)]
pub struct TrainingForm {
    restriction: Option<Restriction>,
    attributes: bool,
    arrangement: Arrangement,
    /// Number of values in a row of actions, and in a row of observations without attributes.
    widths: (usize, usize),
}

impl TrainingForm {
    /// Returns the form of a problem for these buildings. The problem's own width applies to observations in model
    /// order.
    ///
    /// # Errors
    /// [`Error::Problem`] if the problem's restriction does not apply to one of them.
    pub fn new(problem: &Problem, buildings: &[Arc<Spaces>], arrangement: Arrangement) -> Result<Self> {
        let restriction = problem.train.restriction;
        let (mut actions, observations) = Padded::fitting(buildings, arrangement).widths;
        if let Some(restriction) = restriction {
            let kept = |spaces: &Arc<Spaces>| {
                let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
                Ok(restriction.apply(spaces, &parameters)?.kept().len())
            };
            let kept = buildings.iter().map(kept).collect::<Result<Vec<usize>>>()?;
            actions = kept.into_iter().max().unwrap_or(0);
        }
        let by_role = buildings.iter().any(|spaces| arrangement.of(spaces).is_by_role());
        let own = problem.protocol.observation_width.filter(|_| !by_role);
        let observations = own.unwrap_or(observations);
        let attributes = problem.protocol.attributes == Attributes::Given;
        Ok(Self { restriction, attributes, arrangement, widths: (actions, observations) })
    }

    /// Returns the attributes of a building, from the dataset if it has an id.
    fn attributes(&self, spaces: &Spaces) -> Result<Vec<f64>> {
        if !self.attributes {
            return Ok(Vec::new());
        }
        let name = Control::split_name(&spaces.building.name).0.parse::<BuildingName>();
        let origin = name.map(|name| Placement::default().origin(&name)).unwrap_or_default();
        Ok(attributes(spaces, origin)?)
    }
}

impl Form for TrainingForm {
    fn widths(&self) -> (usize, usize) {
        let attributes = if self.attributes { COMMON.len() } else { 0 };
        (self.widths.0, self.widths.1 + attributes)
    }

    fn episode(&mut self, spaces: &Arc<Spaces>) -> b2b_env::Result<Box<dyn EpisodeForm>> {
        let wrong = |error: Error| b2b_env::Error::Template {
            name: spaces.building.name.clone(),
            why: error.to_string(),
        };
        let parameters = ReactiveParameters::tuned_for(&spaces.building, &spaces.episode.task);
        let restricted =
            self.restriction.map(|each| each.apply(spaces, &parameters)).transpose().map_err(wrong)?;
        let attributes = self.attributes(spaces).map_err(wrong)?;
        let actions = match &restricted {
            Some(restricted) => spaces.action.select(restricted.kept()),
            None => spaces.action.clone(),
        };
        let arranged = self.arrangement.of(spaces);
        check_width(spaces, "actuators", actions.len(), self.widths.0)?;
        check_width(spaces, "observation slots", arranged.width(), self.widths.1)?;
        Ok(Box::new(TrainingEpisode { arranged, actions, restricted, attributes, width: self.widths.1 }))
    }
}

struct TrainingEpisode {
    arranged: Arranged,
    actions: ActionSpace,
    restricted: Option<RestrictedAction>,
    attributes: Vec<f64>,
    /// Number of values in a row of observations without attributes.
    width: usize,
}

impl EpisodeForm for TrainingEpisode {
    fn actions(&self) -> &ActionSpace {
        &self.actions
    }

    fn slots(&self) -> Vec<RowSlot> {
        let slots = self.arranged.slots().into_iter();
        let attributes = COMMON.iter().take(self.attributes.len()).map(|slot| RowSlot {
            name: attribute_name(slot.quantity),
            unit: "1",
            low: -1.0,
            high: 1.0,
        });
        let padded = slots.chain(std::iter::repeat_with(RowSlot::padding)).take(self.width);
        padded.chain(attributes).collect()
    }

    fn act(&mut self, observation: &[f64], row: &[f64], action: &mut [f64]) {
        match &mut self.restricted {
            None => action.copy_from_slice(&row[..action.len()]),
            Some(restricted) => restricted.complete(observation, &row[..self.actions.len()], action),
        }
    }

    fn observe(&self, observation: &[f64], row: &mut [f64]) {
        let (padded, attributes) = row.split_at_mut(self.width);
        self.arranged.write(observation, padded);
        attributes.copy_from_slice(&self.attributes);
    }
}
