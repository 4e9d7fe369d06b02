//! Agents above the sequences of Guideline 36, on the real engine.

use std::sync::Arc;

use b2b_agent::{Acting, Interface, ObservationForm, Pilot};
use b2b_control::{Controller, Guideline36, Guideline36Parameters};
use b2b_env::{Env, rollout};

use crate::agent::{actor, env};

const NO_SETPOINTS: Acting = Acting::Supervisory { every: 60, shared: true, setpoints: false, rule: false };

fn interface(every: u32, shared: bool) -> Interface {
    let acting = Acting::Supervisory { every, shared, setpoints: true, rule: false };
    Interface { observation: ObservationForm::Features.into(), acting, nodes: None }
}

/// Runs an episode under the decisions of `decide`, which gets their number and the agent's observation. Returns the
/// return.
fn episode(env: &mut Env, pilot: &mut Pilot, mut decide: impl FnMut(usize, &[f32], &mut [f32])) -> f64 {
    let mut observation = env.reset().unwrap().to_vec();
    let mut decision = vec![0.0; pilot.widths().1];
    let mut decisions = 0;
    let mut total = 0.0;
    for _ in 0..env.episode_steps() {
        let seen = pilot.observe(&observation).to_vec();
        if pilot.is_due() {
            decide(decisions, &seen, &mut decision);
            decisions += 1;
        }
        let action = pilot.act(&decision).to_vec();
        let step = env.step(&action).unwrap();
        total += step.reward.total();
        observation.copy_from_slice(step.observation);
    }
    total
}

#[test]
fn a_supervisor_that_decides_nothing_is_the_guideline_and_one_that_does_holds_its_decisions() {
    let mut env = env("OfficeSmall-0042", "operate+preview");
    let spaces = Arc::clone(env.spaces());
    let mut pilot = Pilot::new(interface(60, true), &spaces).unwrap();
    let names = pilot.observation().names();
    assert_eq!(
        pilot.action_names()[3..],
        ["heating setpoint shift", "cooling setpoint shift", "earlier start"]
    );
    let (mut hours, mut extremes) = (0, vec![0f32; names.len()]);
    let zeros = episode(&mut env, &mut pilot, |_, seen, _| {
        hours += 1;
        extremes.iter_mut().zip(seen).for_each(|(most, value)| *most = most.max(value.abs()));
    });
    assert_eq!(hours, 24, "a day of hours");
    for (name, most) in names.iter().zip(&extremes) {
        assert!(*most <= 6.0, "{name} reaches {most}");
    }
    let varied = ["occupancy", "change ahead", ": occupied", "heating loop", "outdoor temperature in 4 h"];
    for what in varied {
        let mut named = names.iter().zip(&extremes).filter(|(name, _)| name.ends_with(what));
        assert!(named.any(|(_, most)| *most > 0.0), "{what}");
    }
    let mut guideline = Guideline36::new(&spaces, &Guideline36Parameters::default());
    let alone = rollout(&mut env, &mut guideline, &mut ()).unwrap().episode_return;
    assert!((zeros - alone).abs() < 1e-9 * alone.abs(), "{zeros} {alone}");
    let [recorded, of_guideline] = [pilot.record(), guideline.record()].map(|record| &record.unwrap().values);
    assert_eq!(recorded, of_guideline, "what the sequences decided is recorded");

    let mut own = Pilot::new(interface(15, false), &spaces).unwrap();
    let points = guideline.supervisory_points();
    assert_eq!(own.action_names(), points.iter().map(|point| point.name.clone()).collect::<Vec<_>>());
    let mut quarters = 0;
    let colder = episode(&mut env, &mut own, |_, _, decision| {
        quarters += 1;
        let shifts = decision.iter_mut().zip(points);
        let heating = shifts.filter(|(_, point)| point.name.ends_with(" heating setpoint shift"));
        heating.for_each(|(value, _)| *value = -3.0);
    });
    assert_eq!(quarters, 96);
    assert!((colder - alone).abs() > 1e-3 * alone.abs(), "half a kelvin shows: {colder} {alone}");
}

#[test]
fn an_agent_without_setpoints_leaves_comfort_to_the_guideline() {
    let mut env = env("OfficeSmall-0042", "operate");
    let spaces = Arc::clone(env.spaces());
    let mut whole = interface(60, true);
    let written = serde_json::to_string(&whole.acting).unwrap();
    assert!(
        !written.contains("setpoints") && !written.contains("rule"),
        "as in the files of older agents: {written}"
    );
    whole.acting = NO_SETPOINTS;
    let mut pilot = Pilot::new(whole, &spaces).unwrap();
    assert_eq!(
        pilot.action_names(),
        [
            "minimum flow shift",
            "heating supply air temperature shift",
            "cooling supply air temperature shift"
        ]
    );
    let mut guideline = Guideline36::new(&spaces, &Guideline36Parameters::default());
    let alone = rollout(&mut env, &mut guideline, &mut ()).unwrap().episode_return;
    assert!((episode(&mut env, &mut pilot, |_, _, _| ()) - alone).abs() < 1e-9 * alone.abs());
    let blowing = episode(&mut env, &mut pilot, |_, _, decision| decision[0] = 1.0);
    assert!((blowing - alone).abs() > 1e-3 * alone.abs(), "more air shows: {blowing} {alone}");
}

#[test]
fn an_agent_repeats_its_action_until_its_next_decision() {
    use b2b_agent::AgentController;

    let mut env = env("OfficeSmall-0042", "operate");
    let spaces = Arc::clone(env.spaces());
    let pilot = Pilot::new(interface(30, true), &spaces).unwrap();
    let previous =
        |pilot: &Pilot, name: &str| pilot.observation().names().iter().position(|each| each == name).unwrap();
    let slot = previous(&pilot, "heating setpoint shift previous");
    let actor = Arc::new(actor(&pilot, 2.0));
    let mut controller = AgentController::new(pilot.clone(), Arc::clone(&actor));
    let mut shadow = pilot;
    controller.reset();
    let (mut observation, mut action) = (env.reset().unwrap().to_vec(), vec![0.0; spaces.action.len()]);
    let mut scratch = actor.scratch(None);
    let (mut decision, mut seen) = (vec![0.0; scratch.actions()], Vec::new());
    for _ in 0..24 {
        controller.act(&observation, &mut action);
        let row = shadow.observe(&observation).to_vec();
        seen.push(row[slot]);
        if shadow.is_due() {
            actor.mean(&row, &mut scratch, &mut decision);
        }
        assert_eq!(shadow.act(&decision), action);
        observation.copy_from_slice(env.step(&action).unwrap().observation);
    }
    let changes: Vec<usize> = (1..24).filter(|step| seen[*step] != seen[step - 1]).collect();
    assert_eq!(changes, [1, 7, 13, 19], "a decision every six steps");
}

#[test]
fn a_supervisor_from_the_rules_that_decides_nothing_is_the_rule_of_the_type() {
    use b2b_control::linear_supervisor::{LinearSupervisor, rule_of};

    let mut env = env("OfficeSmall-0042", "operate");
    let spaces = Arc::clone(env.spaces());
    let mut from = interface(60, true);
    from.acting = Acting::Supervisory { every: 60, shared: true, setpoints: false, rule: true };
    let mut pilot = Pilot::new(from, &spaces).unwrap();
    let mut rule = LinearSupervisor::new(&spaces, &[rule_of(&spaces.building)]).unwrap();
    let alone = rollout(&mut env, &mut rule, &mut ()).unwrap().episode_return;
    let zeros = episode(&mut env, &mut pilot, |_, _, _| ());
    assert!((zeros - alone).abs() < 1e-9 * alone.abs(), "{zeros} {alone}");
    assert_eq!(pilot.record().unwrap().values, rule.record().unwrap().values);
    let mut guideline = Guideline36::new(&spaces, &Guideline36Parameters::default());
    let without = rollout(&mut env, &mut guideline, &mut ()).unwrap().episode_return;
    assert!((zeros - without).abs() > 1e-6 * without.abs(), "the rule shows: {zeros} {without}");
    // Actions are added to the rule's shares.
    let weights = rule_of(&spaces.building).0;
    let constant = |name: &String| weights.get(name).map_or(0.0, |own| own.constant as f32);
    let constants: Vec<f32> = pilot.action_names().iter().map(constant).collect();
    assert_eq!(constants[0], -1.0);
    let mut original = Pilot::new(Interface { acting: NO_SETPOINTS, ..from }, &spaces).unwrap();
    let mut added = Pilot::new(from, &spaces).unwrap();
    let undone = episode(&mut env, &mut added, |_, _, decision| decision[0] = 0.25);
    let raised = episode(&mut env, &mut original, |_, _, decision| {
        decision.copy_from_slice(&constants);
        decision[0] += 0.25;
    });
    assert!((undone - raised).abs() < 1e-9 * raised.abs(), "{undone} {raised}");
}
