//! Random sequences of operations, checked against a model.
//!
//! - Nothing panics, and an operation succeeds unless the state of its own episode forbids it.
//! - An episode is lost only if its own process was killed. A killed template costs no episode.
//! - Equal actions give equal bits, in any process and with any operations in between.
//! - Any episode can be reset at the end, and no process or file is left after all drops.
//!
//! A failing sequence is shrunk and stored in `operations.regressions`, which runs first from then on.

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;

use b2b_building::BuildingType;
use b2b_env::Error;
use b2b_workers::{Episode, EpisodeSetting, Snapshot, Workers, recv};
use proptest::prelude::*;
use proptest::test_runner::{Config, FileFailurePersistence, TestRunner};

use crate::case::Case;
use crate::workers::{DAY, is_alive, kill, options, setting};

/// Number of sequences.
const CASES: u32 = 8;
/// Maximum length of a sequence.
const LENGTH: usize = 40;
/// Maximum number of episodes.
const EPISODES: usize = 4;
/// Maximum number of snapshots.
const SNAPSHOTS: usize = 2;

/// An operation. Episodes and snapshots are taken modulo their number.
#[derive(Clone, Copy, Debug)]
enum Operation {
    Prepare,
    Begin(usize),
    Reset(usize),
    Send(usize, bool),
    Step(usize, bool),
    Receive(usize),
    Snapshot(usize),
    Restore(usize, usize),
    Branch(usize),
    Drop(usize),
    DropSnapshot(usize),
    Kill(usize),
    KillTemplate,
}

fn operation() -> impl Strategy<Value = Operation> {
    use Operation::*;
    let (index, action) = (0..EPISODES, any::<bool>());
    prop_oneof![
        1 => Just(Prepare),
        2 => index.clone().prop_map(Begin),
        3 => index.clone().prop_map(Reset),
        3 => (index.clone(), action).prop_map(|(index, action)| Send(index, action)),
        6 => (index.clone(), action).prop_map(|(index, action)| Step(index, action)),
        4 => index.clone().prop_map(Receive),
        2 => index.clone().prop_map(Snapshot),
        2 => (index.clone(), 0..SNAPSHOTS).prop_map(|(index, snapshot)| Restore(index, snapshot)),
        2 => index.clone().prop_map(Branch),
        1 => index.clone().prop_map(Drop),
        1 => (0..SNAPSHOTS).prop_map(DropSnapshot),
        2 => index.prop_map(Kill),
        1 => Just(KillTemplate),
    ]
}

/// The actions since the reset.
type History = Vec<bool>;
/// Bits of observation and reward, by the actions that led there.
type Outcomes = RefCell<HashMap<History, Vec<u64>>>;

/// Expected state of an episode.
#[derive(Clone, Debug, PartialEq)]
enum State {
    New,
    /// In the last step of these actions.
    Busy(History),
    Ready(History),
    /// After its process was killed.
    Lost,
}

/// An episode and its expected state.
struct Known {
    episode: Episode,
    state: State,
    /// Whether its process was killed since it began.
    is_killed: bool,
    /// Number of killed templates when it began.
    templates_killed: usize,
}

struct Trial<'a> {
    workers: Workers,
    setting: &'a EpisodeSetting,
    actions: [Vec<f64>; 2],
    outcomes: &'a Outcomes,
    episodes: Vec<Known>,
    snapshots: Vec<(Snapshot, History)>,
    templates_killed: usize,
    /// Whether an episode began from the current template. A template killed before that eventually counts as broken.
    is_template_proven: bool,
}

impl<'a> Trial<'a> {
    fn new(workers: Workers, setting: &'a EpisodeSetting, outcomes: &'a Outcomes) -> Self {
        let space = workers.prepare(setting).unwrap().action.clone();
        let mut trial = Self {
            workers,
            setting,
            actions: [space.low().to_vec(), space.high().to_vec()],
            outcomes,
            episodes: Vec::new(),
            snapshots: Vec::new(),
            templates_killed: 0,
            is_template_proven: true,
        };
        trial.add_new();
        trial.add_new();
        trial
    }

    fn add_new(&mut self) {
        let episode = self.workers.episode(self.setting).unwrap();
        self.add(episode, State::New);
    }

    fn add(&mut self, episode: Episode, state: State) {
        let templates_killed = self.templates_killed;
        self.episodes.push(Known { episode, state, is_killed: false, templates_killed });
    }

    fn carry_out(&mut self, operation: Operation) {
        let count = self.episodes.len();
        match operation {
            Operation::Prepare => drop(self.workers.prepare(self.setting).unwrap()),
            Operation::Begin(index) => self.begin(index % count),
            Operation::Reset(index) => {
                self.begin(index % count);
                self.receive(index % count);
            }
            Operation::Send(index, action) => self.send(index % count, action),
            Operation::Step(index, action) => {
                self.send(index % count, action);
                self.receive(index % count);
            }
            Operation::Receive(index) => self.receive(index % count),
            Operation::Snapshot(index) => self.snapshot(index % count),
            Operation::Restore(index, snapshot) => self.restore(index % count, snapshot),
            Operation::Branch(index) => self.branch(index % count),
            Operation::Drop(index) => {
                drop(self.episodes.swap_remove(index % count));
                if self.episodes.is_empty() {
                    self.add_new();
                }
            }
            Operation::DropSnapshot(index) if index < self.snapshots.len() => {
                drop(self.snapshots.swap_remove(index));
            }
            Operation::DropSnapshot(_) => {}
            Operation::Kill(index) => {
                let known = &mut self.episodes[index % count];
                if let Some(process) = known.episode.process().filter(|process| is_alive(*process)) {
                    kill(process);
                    known.is_killed = true;
                }
            }
            Operation::KillTemplate => self.kill_template(),
        }
    }

    fn begin(&mut self, index: usize) {
        let known = &mut self.episodes[index];
        known.episode.begin().unwrap();
        known.state = State::Busy(History::new());
        known.is_killed = false;
        known.templates_killed = self.templates_killed;
    }

    fn send(&mut self, index: usize, action: bool) {
        let known = &mut self.episodes[index];
        let sent = known.episode.send(&self.actions[usize::from(action)]);
        if known.allows(&sent) {
            let State::Ready(history) = &known.state else { unreachable!() };
            let history = history.iter().copied().chain([action]).collect();
            known.state = State::Busy(history);
        }
    }

    fn receive(&mut self, index: usize) {
        let known = &mut self.episodes[index];
        recv(std::slice::from_mut(&mut known.episode), 1, &mut Vec::new()).unwrap();
        let State::Busy(history) = known.state.clone() else { return };
        let step = match known.episode.last_step() {
            Ok(step) => step,
            Err(error) => {
                assert!(known.is_killed, "{error}");
                assert!(matches!(error, Error::Lost { .. }), "{error}");
                known.state = State::Lost;
                return;
            }
        };
        let penalties = [step.reward.temperature_penalty, step.reward.energy_penalty];
        let bits: Vec<u64> = step.observation.iter().chain(&penalties).map(|value| value.to_bits()).collect();
        let mut outcomes = self.outcomes.borrow_mut();
        assert!(
            *outcomes.entry(history.clone()).or_insert_with(|| bits.clone()) == bits,
            "{history:?} differs"
        );
        if history.is_empty() && known.templates_killed == self.templates_killed {
            self.is_template_proven = true;
        }
        known.state = State::Ready(history);
    }

    fn snapshot(&mut self, index: usize) {
        let known = &self.episodes[index];
        let snapshot = known.episode.snapshot();
        if known.allows(&snapshot)
            && let (Ok(snapshot), State::Ready(history)) = (snapshot, &known.state)
        {
            self.snapshots.truncate(SNAPSHOTS - 1);
            self.snapshots.push((snapshot, history.clone()));
        }
    }

    fn restore(&mut self, index: usize, snapshot: usize) {
        let Some((snapshot, history)) = self.snapshots.get(snapshot) else { return };
        let known = &mut self.episodes[index];
        known.episode.restore(snapshot).unwrap();
        known.state = State::Ready(history.clone());
        known.is_killed = false;
    }

    fn branch(&mut self, index: usize) {
        let known = &self.episodes[index];
        let branches = known.episode.branch(2);
        if known.allows(&branches)
            && let (Ok(branches), state) = (branches, known.state.clone())
        {
            let room = EPISODES - self.episodes.len();
            branches.into_iter().take(room).for_each(|branch| self.add(branch, state.clone()));
        }
    }

    /// Kills the template, unless it was already killed or has not yet started an episode.
    fn kill_template(&mut self) {
        if let (true, Some(template)) = (self.is_template_proven, self.workers.template_processes().first()) {
            kill(*template);
            self.templates_killed += 1;
            self.is_template_proven = false;
        }
    }

    /// Checks that every episode can be reset and stepped.
    fn finish(&mut self) {
        for index in 0..self.episodes.len() {
            for operation in [Operation::Reset(index), Operation::Step(index, true)] {
                self.carry_out(operation);
                assert!(matches!(self.episodes[index].state, State::Ready(_)));
            }
        }
    }
}

impl Known {
    /// Returns whether an operation on a ready episode succeeded. Panics on an unexpected result.
    fn allows<T>(&self, outcome: &Result<T, Error>) -> bool {
        let error = outcome.as_ref().err();
        let expected = match (&self.state, error) {
            (State::New, error) => matches!(error, Some(Error::NotReset)),
            (State::Busy(_), error) => matches!(error, Some(Error::Busy)),
            (State::Lost, error) => matches!(error, Some(Error::Lost { .. })),
            // A killed process is detected when it is waited for.
            (State::Ready(_), Some(Error::Lost { .. })) => self.is_killed,
            (State::Ready(_), error) => error.is_none(),
        };
        assert!(expected, "{error:?} in {:?}, killed: {}", self.state, self.is_killed);
        error.is_none()
    }
}

/// Processes started with a file in a folder, and their copies.
fn processes_of(folder: &Path) -> Vec<u32> {
    let folder = folder.to_str().unwrap();
    let one = |entry: std::fs::DirEntry| {
        let line = std::fs::read_to_string(entry.path().join("cmdline")).ok()?;
        let process = entry.file_name().to_str()?.parse().ok()?;
        (line.contains(folder) && is_alive(process)).then_some(process)
    };
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(one).collect()
}

#[test]
fn only_killed_episodes_are_lost() {
    let case = Case::at_home(BuildingType::SingleFamilyHouse);
    let setting = setting(&case, DAY);
    let outcomes = Outcomes::default();
    let config = Config {
        cases: CASES,
        max_shrink_iters: 60,
        source_file: Some(file!()),
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..Config::default()
    };
    let sequences = proptest::collection::vec(operation(), 1..=LENGTH);
    let outcome = TestRunner::new(config).run(&sequences, |operations| {
        let workers = Workers::new(options(&case)).unwrap();
        let folder = workers.folder();
        let mut trial = Trial::new(workers, &setting, &outcomes);
        operations.into_iter().for_each(|operation| trial.carry_out(operation));
        trial.finish();
        assert!(!processes_of(&folder).is_empty());
        drop(trial);
        assert_eq!(processes_of(&folder), Vec::<u32>::new());
        assert!(!folder.exists());
        Ok(())
    });
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
}
