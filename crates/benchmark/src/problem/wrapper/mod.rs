//! A wrapper that gives a policy the observation and action spaces of a problem's side.

mod previous_step;

use b2b_base::digest::sha256;
use b2b_building::Controls;
use b2b_building::morphology::COMMON;
use b2b_control::Controller;
use b2b_env::{ActionSpace, RoleObservation, Spaces, Task, attribute_name, attributes};
use b2b_evaluate::problem::{Attributes, Fallback, Memory, Problem, RestrictedAction, Restriction, Side};
use b2b_evaluate::{EpisodeContext, Policy, PolicyForm, PolicyInterface, controller_parameters};
use serde_json::Value;

use crate::Result;
use previous_step::PreviousStep;

/// A policy behind the observation and action spaces of a problem's side: observations have the problem's form (or the
/// other form if the policy expects its width), followed by the building's attributes; withheld actuators are
/// controlled by their fallback. A policy that keeps its memory over several episodes also observes the previous step,
/// unless it expects the width without it.
pub struct WrappedPolicy<'a> {
    policy: &'a dyn Policy,
    problem: &'a Problem,
    side: &'a Side,
}

/// The observation and actions of a policy on a problem's side.
struct Access {
    restricted: Option<RestrictedAction>,
    /// Attributes that follow the observation.
    attributes: Vec<f64>,
    previous: PreviousStep,
    form: PolicyForm,
    action: ActionSpace,
}

impl Access {
    /// Returns what the policy observes and controls.
    fn interface(&self, spaces: &Spaces) -> PolicyInterface {
        let attributes = COMMON.iter().take(self.attributes.len()).map(|slot| attribute_name(slot.quantity));
        let names = self.form.names(spaces).into_iter().chain(attributes);
        let observation = names.chain(self.previous.names(&self.action)).collect();
        PolicyInterface { observation, action: self.action.clone() }
    }
}

impl<'a> WrappedPolicy<'a> {
    /// Wraps a policy for a side of a problem.
    pub fn new(policy: &'a dyn Policy, problem: &'a Problem, side: &'a Side) -> Self {
        Self { policy, problem, side }
    }

    /// Returns the common attributes of the building in the order of [`COMMON`], scaled to [-1, 1].
    fn attributes(&self, context: &EpisodeContext<'_>) -> Result<Vec<f64>> {
        if self.problem.protocol.attributes == Attributes::Withheld {
            return Ok(Vec::new());
        }
        let EpisodeContext { subject, spaces, .. } = context;
        Ok(attributes(spaces, subject.placement.origin(&subject.name))?)
    }

    /// Returns the observation and actions of a policy on the problem's side.
    fn access(&self, context: &EpisodeContext<'_>) -> Result<Access> {
        let EpisodeContext { subject, site, spaces, .. } = context;
        let parameters = controller_parameters(subject, site, &spaces.episode.task);
        let restricted = self.side.restriction.map(|each| each.apply(spaces, &parameters)).transpose()?;
        let attributes = self.attributes(context)?;
        let action = match &restricted {
            Some(restricted) => spaces.action.select(restricted.kept()),
            None => spaces.action.clone(),
        };
        let (form, previous) = self.form(spaces, attributes.len(), &action)?;
        // Own controls have no interface.
        if self.policy.controls() != Controls::Own
            && let Some(building_type) = subject.name.building_type()
            && let Some(why) = self.side.size_mismatch(building_type, spaces, action.len())
        {
            return Err(self.problem.error(why).into());
        }
        Ok(Access { restricted, attributes, previous, form, action })
    }

    /// Returns the form of a building's observations, and the previous step that follows them and the `attributes`
    /// values. It is empty for a policy that does not keep its memory or whose width leaves no room for it.
    fn form(
        &self,
        spaces: &Spaces,
        attributes: usize,
        action: &ActionSpace,
    ) -> Result<(PolicyForm, PreviousStep)> {
        let (slots, roles) = (spaces.observation.len(), RoleObservation::of(spaces));
        let role_width = roles.as_ref().map(|_| RoleObservation::WIDTH);
        let default = match roles.filter(|_| self.problem.protocol.observation.is_roles()) {
            Some(roles) => PolicyForm::Roles(roles),
            None => PolicyForm::Raw { padding: self.padding(slots)? },
        };
        let width = self.policy.observation_width().and_then(|width| width.checked_sub(attributes));
        let forms = [Some(default.width(spaces)), Some(slots), role_width];
        let has_room = width.is_none() || !forms.contains(&width);
        let previous = match self.keeps_memory() && has_room {
            true => PreviousStep::of(action),
            false => PreviousStep::default(),
        };
        let width = width.and_then(|width| width.checked_sub(previous.len()));
        Ok((PolicyForm::of_width(spaces, width, default), previous))
    }

    /// Returns the number of zeros that pad an observation of `slots` values.
    fn padding(&self, slots: usize) -> Result<usize> {
        let Some(width) = self.problem.protocol.observation_width else { return Ok(0) };
        let too_long = || format!("an observation has {slots} values, more than observation_width, {width}");
        width.checked_sub(slots).ok_or_else(|| self.problem.error(too_long()).into())
    }
}

impl Policy for WrappedPolicy<'_> {
    fn name(&self) -> String {
        self.policy.name()
    }

    fn identity(&self) -> String {
        let wrapper = (
            &self.side.restriction,
            self.problem.protocol.attributes,
            self.problem.protocol.observation_width,
            self.problem.protocol.observation,
        );
        let wrapper = serde_json::to_vec(&wrapper).unwrap_or_default();
        let memory = if self.keeps_memory() { ", memory of a building" } else { "" };
        format!("{}, interface {}{memory}", self.policy.identity(), &sha256(wrapper)[..16])
    }

    fn is_baseline(&self, task: &Task) -> bool {
        // The baseline of operation is the guideline, which does not control the withheld actuators.
        let differs = |restriction: Restriction| restriction.fallback == Fallback::Pin || task.is_operation();
        self.policy.is_baseline(task) && !self.side.restriction.is_some_and(differs)
    }

    fn controls(&self) -> Controls {
        self.policy.controls()
    }

    fn has_memory(&self) -> bool {
        self.policy.has_memory()
    }

    fn keeps_memory(&self) -> bool {
        self.problem.protocol.memory == Memory::Building && self.policy.has_memory()
    }

    fn description(&self, context: &EpisodeContext<'_>) -> b2b_evaluate::Result<Option<Value>> {
        if !self.policy.ignores_interface() || self.side.restriction.is_some() {
            return Ok(None);
        }
        self.access(context)?;
        self.policy.description(context)
    }

    fn controller(&self, context: EpisodeContext<'_>) -> b2b_evaluate::Result<Box<dyn Controller>> {
        let EpisodeContext { subject, site, spaces, seed, .. } = context;
        let access = self.access(&context)?;
        let interface = access.interface(spaces);
        let Access { restricted, attributes, previous, form, action } = access;
        let mut row = vec![0.0; form.width(spaces)];
        row.extend(attributes);
        row.resize(interface.observation.len(), 0.0);
        let bypass = self.policy.ignores_interface();
        let partial_action = vec![0.0; interface.action.len()];
        if bypass && restricted.is_some() && !self.policy.is_baseline(&spaces.episode.task) {
            let why = format!(
                "{} controls all actuators; it cannot run with some of them withheld",
                self.policy.name()
            );
            return Err(self.problem.error(why));
        }
        let inner = self.policy.controller(EpisodeContext {
            subject,
            site,
            spaces,
            interface: &interface,
            seed,
            ..context
        })?;
        Ok(Box::new(WrappedController {
            inner,
            bypass,
            restricted,
            form,
            row,
            previous,
            action,
            partial_action,
        }))
    }
}

/// The controller of a wrapped policy.
struct WrappedController {
    inner: Box<dyn Controller>,
    /// Whether the inner controller observes and controls the whole building; withheld actuators are overwritten.
    bypass: bool,
    restricted: Option<RestrictedAction>,
    form: PolicyForm,
    /// Observation in its form, attributes and previous step.
    row: Vec<f64>,
    previous: PreviousStep,
    /// Space of the remaining actuators.
    action: ActionSpace,
    /// Action of the remaining actuators.
    partial_action: Vec<f64>,
}

impl WrappedController {
    /// Resets the previous step and the control of the withheld actuators.
    fn begin(&mut self) {
        self.previous.reset();
        if let Some(restricted) = &mut self.restricted {
            restricted.reset();
        }
    }
}

impl Controller for WrappedController {
    fn reset(&mut self) {
        self.inner.reset();
        self.begin();
    }

    fn next_episode(&mut self) {
        self.inner.next_episode();
        self.begin();
    }

    fn reward(&mut self, reward: f64) {
        self.previous.rewarded(reward);
        self.inner.reward(reward);
    }

    fn act(&mut self, observation: &[f64], action: &mut [f64]) {
        if self.bypass {
            self.inner.act(observation, action);
            if let Some(restricted) = &mut self.restricted {
                restricted.overwrite(observation, action);
            }
            return;
        }
        self.form.write(observation, &mut self.row);
        let place = self.row.len() - self.previous.len();
        self.previous.write(&mut self.row[place..]);
        self.inner.act(&self.row, &mut self.partial_action);
        self.previous.acted(&self.partial_action, &self.action);
        match &mut self.restricted {
            None => action.copy_from_slice(&self.partial_action),
            Some(restricted) => restricted.complete(observation, &self.partial_action, action),
        }
    }
}
