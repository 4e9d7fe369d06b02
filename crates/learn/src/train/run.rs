//! A training run in its folder.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use b2b_agent::{Agent, AgentInfo, FORMAT, NodeSpaces, Pilot, TrainingInfo};
use b2b_base::aside::write_whole;
use b2b_building::Period;
use b2b_building::morphology::NodeType;
use b2b_control::{Versions, linear_supervisor};
use b2b_dataset::Catalog;
use b2b_evaluate::{Baselines, Evaluation};
use b2b_workers::{Launcher, WorkerOptions};

use super::calibration::calibrate;
use super::checkpoint::Checkpoint;
use super::config::{Budget, CONFIG, Keep, TrainConfig, TrainingSet};
use super::environments::{Environments, Evaluated, days, learner};
use super::judge::{AgentScores, BuildingScores, Judge, Measures, Rating};
use super::lock::{self, LAST};
use super::monitor::Monitor;
use super::progress::{ProgressFiles, ProgressRow, curve};
use super::summary::RunSummary;
use crate::collector::Collector as _;
use crate::comfort_weights::ComfortWeights;
use crate::error::{Error, Result, at};
use crate::fragments::{FragmentCollector, spaces_of};
use crate::learner::Learner;
use crate::rollout::Rollout;

/// Name of the folder of the stages in a run's folder: `stages/1` has the agent after the first `stage_every` steps.
pub const STAGES: &str = "stages";

/// Limit to which the cost of travel grows: at this cost and 12 steps per hour, five strokes a day cost 174 times the
/// baseline's penalty.
const LARGEST_TRAVEL_COST: f32 = 1e4;

/// Where and how a run is carried out. None of it changes the result.
pub struct RunOptions<'a> {
    /// Folder of the run.
    pub out: PathBuf,
    /// Source of buildings.
    pub catalog: Arc<Catalog>,
    /// Starts worker processes, whose program calls [`run_if_worker`](crate::fragments::run_if_worker).
    pub launcher: Launcher,
    /// Episodes of an evaluation that run at a time.
    pub jobs: usize,
    /// Polled between updates; if true, the run writes a checkpoint and ends with [`Error::Interrupted`].
    pub interrupted: fn() -> bool,
    /// Watches the run.
    pub monitor: &'a mut (dyn Monitor + Send),
}

/// Begins a run in a folder, or continues the folder's run from its last checkpoint. Returns its result.
///
/// # Errors
/// The errors of [`TrainConfig::check`]; [`Error::Resume`] when the folder has another run; [`Error::NotFinite`] with
/// the last good agent kept; [`Error::Interrupted`] after a checkpoint; errors from environments and evaluations.
pub fn train(config: &TrainConfig, options: RunOptions<'_>) -> Result<RunSummary> {
    config.check()?;
    let _lock = lock::acquire(&options.out, lock::PATIENCE, options.interrupted)?;
    begin_folder(config, &options.out)?;
    let RunOptions { out, catalog, launcher, jobs, interrupted, monitor } = options;
    let evaluation = Evaluation { catalog: &catalog, launcher: launcher.clone(), jobs, interrupted };
    // An interrupt waits for the evaluations of training, which take seconds: a checkpoint follows each.
    let uninterrupted =
        Evaluation { catalog: &catalog, launcher: launcher.clone(), jobs, interrupted: || false };
    let baselines = Baselines::open()?;
    let environments = Environments::new(config, Arc::clone(&catalog));
    environments.check_memory()?;
    let evaluated = environments.evaluated()?;
    let episodes = |days: &dyn Fn(Period) -> Period| {
        let scored = |each: &Evaluated| {
            environments.scored(&each.name, &each.task, days(each.period), &evaluation, &baselines)
        };
        evaluated.iter().map(scored).collect::<Result<Vec<_>>>()
    };

    monitor.stage("computing baselines");
    let whole = config.evaluation.whole_period.then(|| episodes(&|whole| whole)).transpose()?;
    let whole = whole.map(|episodes| Judge::new(&evaluation, episodes));
    let windows = || episodes(&|whole| days::evaluated(config, whole));
    let judge = (config.evaluation.every > 0).then(windows).transpose()?;
    let judge = judge.map(|episodes| Judge::new(&uninterrupted, episodes));
    monitor.stage("preparing environments");
    let workers = WorkerOptions::new(launcher, catalog.library().path());
    let scale = environments.scale(&evaluation, &baselines)?;
    let collector = environments.fragments(workers, scale)?;
    let mut run = Run::new(config, &out, collector, monitor)?;
    if judge.is_some() && config.rewards.comfort_rate > 0.0 {
        let held = evaluated.iter().map(|each| (each.name.to_string(), each.period));
        run.collector.comfort_weights = ComfortWeights::new(held.collect(), config.rewards.comfort_weight);
    }
    run.resume()?;
    run.learn(judge.as_ref(), interrupted)?;
    run.finish(whole.as_ref())
}

/// Checks that a run already in the folder has this configuration, except for the number of steps, and writes it.
fn begin_folder(config: &TrainConfig, out: &Path) -> Result<()> {
    let path = out.join(CONFIG);
    if path.exists() {
        let before = TrainConfig::of_run(out)?;
        let (steps, before_steps) = (config.budget.steps, before.budget.steps);
        // More steps continue a run. Permissions of models are in no file.
        let budget = Budget { steps, ..before.budget.clone() };
        let allow_external = config.training_set.allow_external;
        let training_set = TrainingSet { allow_external, ..before.training_set.clone() };
        if (TrainConfig { budget, training_set, ..before }) != *config {
            let why = format!("its {CONFIG} differs from this run's; choose another folder");
            return Err(Error::Resume { path: out.to_owned(), why });
        }
        let done = |checkpoint: Checkpoint| checkpoint.steps;
        let done = if steps < before_steps { Checkpoint::read(out)?.map_or(0, done) } else { 0 };
        if steps < done {
            let why = format!("it has {done} steps, more than `steps`, {steps}; expected at least {done}");
            return Err(Error::Resume { path: out.to_owned(), why });
        }
    }
    write_whole(&path, config.to_toml().as_bytes()).map_err(at(&path))
}

/// A run in progress.
struct Run<'a> {
    config: &'a TrainConfig,
    out: &'a Path,
    collector: FragmentCollector,
    learner: Box<dyn Learner>,
    monitor: &'a mut dyn Monitor,
    /// Names of what could not be saved at the last attempt.
    unsaved: Vec<&'static str>,
    /// Description of its agents.
    info: AgentInfo,
    steps: u64,
    /// Rating of the best agent of the evaluations.
    best: Rating,
    /// Seconds spent on collection and learning.
    seconds: f64,
    /// Logarithm of the standard deviation of actions when training began.
    log_std: f64,
}

impl<'a> Run<'a> {
    fn new(
        config: &'a TrainConfig,
        out: &'a Path,
        collector: FragmentCollector,
        monitor: &'a mut dyn Monitor,
    ) -> Result<Self> {
        let spaces = spaces_of(collector.environments(), 0)?;
        let interface = config.agent.interface();
        let (slots, actuators) = match interface.nodes {
            None => {
                let pilot = Pilot::new(interface, spaces)?;
                (pilot.observation().names(), pilot.action_names().to_vec())
            }
            Some(_) => (NodeSpaces::of(interface).slots(), NodeSpaces::of(interface).actuators()),
        };
        let learner = learner(config, collector.widths(), spaces)?;
        let actor = learner.actor();
        let info = AgentInfo {
            format: FORMAT,
            interface,
            slots,
            actuators,
            node_types: collector.node_types(),
            network: actor.shape,
            memory_episodes: config.agent.policy.recurrent().map(|policy| policy.memory_episodes),
            distribution: actor.distribution,
            task: spaces.episode.task.clone(),
            training: training_info(config),
            weights: String::new(),
        };
        Ok(Self {
            config,
            out,
            collector,
            learner,
            monitor,
            unsaved: Vec::new(),
            info,
            steps: 0,
            best: Rating::default(),
            seconds: 0.0,
            log_std: config.learner.abilities().noise.unwrap_or(0.0).into(),
        })
    }

    /// Continues from the last checkpoint, if there is one.
    fn resume(&mut self) -> Result<()> {
        let Some(checkpoint) = Checkpoint::read(self.out)? else { return Ok(()) };
        if let Ok(last) = Agent::read(&self.out.join(LAST)) {
            check_versions(&last.info().training, &self.info.training)
                .map_err(|why| Error::Resume { path: self.out.to_owned(), why })?;
        }
        self.monitor.stage(&format!("resuming at {} steps", checkpoint.steps));
        let other = |error: Error| Error::Resume { path: self.out.to_owned(), why: error.to_string() };
        self.learner.restore(&checkpoint.learner).map_err(other)?;
        self.collector.restore(&checkpoint.collector, &self.learner.actor())?;
        let Checkpoint { steps, best, seconds, log_std, travel_cost, comfort_weights, .. } = checkpoint;
        (self.steps, self.best, self.seconds, self.log_std) = (steps, best, seconds, log_std);
        self.collector.set_travel_cost(travel_cost);
        self.collector.comfort_weights.set(&comfort_weights);
        Ok(())
    }

    /// Collects and learns until the run has made its steps.
    fn learn(&mut self, judge: Option<&Judge<'_>>, interrupted: fn() -> bool) -> Result<()> {
        if self.steps == 0 && self.config.noise.noise_cost > 0.0 {
            self.monitor.stage("calibrating exploration noise");
            self.log_std = calibrate(self.config, &mut *self.learner, &mut self.collector)?.into();
        }
        let (mut progress, warning) = ProgressFiles::open(self.out, self.steps)?;
        if let Some(warning) = warning {
            self.monitor.warn(&warning);
        }
        if let Some(judge) = judge.filter(|_| self.steps == 0) {
            let learned = self.learner.columns().into_iter().map(|name| (name, f64::NAN)).collect();
            let mut row = self.row([f64::NAN; 8], learned);
            self.evaluate(judge, &mut row);
            let written = progress.write(&row);
            self.warn_of(written, "the first evaluation");
        }
        self.monitor.learning(self.steps);
        let mut rollout = Rollout::default();
        while self.steps < self.config.budget.steps {
            let before = self.steps;
            self.follow_schedules();
            let mut row = match self.update(&mut rollout) {
                Ok(row) => row,
                Err(error) => return Err(self.give_up(error)),
            };
            self.keep_stages(before);
            let is_last = self.steps >= self.config.budget.steps;
            let after = self.steps;
            let due = |every: u64| every > 0 && (is_last || before / every != after / every);
            let judge = judge.filter(|_| due(self.config.evaluation.every));
            match judge {
                Some(judge) => self.evaluate(judge, &mut row),
                None => row.values.extend(Measures::UNKNOWN.named()),
            }
            let written = progress.write(&row);
            self.warn_of(written, "the progress of this update");
            // After every reported evaluation, the run can be resumed.
            let is_saved = is_last || judge.is_some() || due(self.config.checkpoints.checkpoint_every);
            if is_saved {
                self.save_or_warn();
            }
            self.monitor.update(&row);
            if interrupted() {
                if !is_saved {
                    self.save_or_warn();
                }
                return Err(Error::Interrupted);
            }
        }
        Ok(())
    }

    /// Lowers the exploration noise and the learning rate according to the share of the run that is done.
    fn follow_schedules(&mut self) {
        let done = self.steps as f64 / self.config.budget.steps as f64;
        self.learner.set_done(done);
        if self.config.noise.final_noise < 1.0 {
            self.learner.set_log_std((self.log_std + done * self.config.noise.final_noise.ln()) as f32);
        }
    }

    /// Collects a rollout and learns from it.
    fn update(&mut self, rollout: &mut Rollout) -> Result<ProgressRow> {
        let began = Instant::now();
        self.collector.collect(&self.learner.actor(), self.config.learner.steps_per_rollout(), rollout)?;
        let collected = began.elapsed().as_secs_f64();
        let learned = self.learner.learn(rollout)?;
        let seconds = began.elapsed().as_secs_f64();
        let hold = self.config.hold();
        let steps = (rollout.rows() * hold) as u64;
        self.steps += steps;
        self.seconds += seconds;
        let counts = [
            self.seconds,
            steps as f64 / seconds,
            collected / seconds,
            rollout.mean_penalty() / hold as f64,
            self.collector.ended() as f64,
            self.collector.lost() as f64,
            self.collector.travel_cost().into(),
            self.collector.comfort_weights.mean().into(),
        ];
        Ok(self.row(counts, learned))
    }

    /// Returns the row of an update without its evaluation.
    fn row(&self, counts: [f64; 8], learned: Vec<(&'static str, f64)>) -> ProgressRow {
        let names = [
            "seconds",
            "steps_per_s",
            "collection_share",
            "training_penalty",
            "episodes",
            "lost_episodes",
            "travel_cost",
            "comfort_weight",
        ];
        ProgressRow { steps: self.steps, values: names.into_iter().zip(counts).chain(learned).collect() }
    }

    /// Scores the agent as it is now, adapts the rewards to its travel and discomfort, and keeps it if it is the best
    /// and the best is kept. A failure is a warning: training goes on.
    fn evaluate(&mut self, judge: &Judge<'_>, row: &mut ProgressRow) {
        let (info, actor) = (self.info(), self.learner.averaged_actor());
        self.monitor.evaluating(self.steps);
        let measures = match judge.judge(&Agent::new("agent", info.clone(), actor.clone())) {
            Ok(scores) => {
                self.hold_comfort(&scores);
                scores.mean
            }
            Err(error) => {
                self.monitor
                    .warn(&format!("the agent could not be evaluated at {} steps: {error}", self.steps));
                Measures::UNKNOWN
            }
        };
        row.values.extend(measures.named());
        if measures.relative_travel > 1.0 {
            let grown = self.collector.travel_cost() * self.config.rewards.travel_cost_growth;
            self.collector
                .set_travel_cost(grown.min(LARGEST_TRAVEL_COST.max(self.config.rewards.travel_cost)));
        }
        if self.config.checkpoints.keep == Keep::Best && measures.rating().is_better_than(self.best) {
            let written = Agent::write(self.out, info, &actor);
            if written.is_ok() {
                self.best = measures.rating();
            }
            self.warn_of(written.map_err(Error::from), "the best agent");
        }
    }

    /// Keeps the agent for the stages that the steps since `before` completed. A failure is a warning.
    fn keep_stages(&mut self, before: u64) {
        let Some(completed) = self.steps.checked_div(self.config.checkpoints.stage_every) else { return };
        let first = before / self.config.checkpoints.stage_every + 1;
        for stage in first..=completed {
            let folder = self.out.join(STAGES).join(stage.to_string());
            let written = Agent::write(&folder, self.info(), &self.learner.averaged_actor());
            self.warn_of(written.map_err(Error::from), "the agent of this stage");
        }
    }

    /// Lets the multipliers of discomfort follow an evaluation.
    fn hold_comfort(&mut self, scores: &AgentScores) {
        let rate = self.config.rewards.comfort_rate;
        if rate > 0.0 {
            for (number, BuildingScores { measures, .. }) in scores.buildings.iter().enumerate() {
                let Measures { discomfort, baseline_discomfort, .. } = *measures;
                self.collector.comfort_weights.follow(number, discomfort, baseline_discomfort, rate);
            }
        }
    }

    /// Writes the last agent, a checkpoint and the learning curve. A failure is a warning: training can continue.
    fn save_or_warn(&mut self) {
        let saved = self.save();
        self.warn_of(saved, "this checkpoint");
        self.warn_of(curve::write(self.out, self.config, None), "the learning curve");
    }

    /// Writes the last agent and a checkpoint.
    fn save(&mut self) -> Result<()> {
        Agent::write(&self.out.join(LAST), self.info(), &self.learner.averaged_actor())?;
        let checkpoint = Checkpoint {
            steps: self.steps,
            best: self.best,
            seconds: self.seconds,
            log_std: self.log_std,
            travel_cost: self.collector.travel_cost(),
            comfort_weights: self.collector.comfort_weights.weights().to_vec(),
            learner: self.learner.state(),
            collector: self.collector.state(),
        };
        checkpoint.write(self.out)
    }

    /// Writes the last agent to the run's folder if that one is kept or none is rated, scores the kept agent over the
    /// whole run period if there is a judge, and writes the result.
    fn finish(mut self, whole: Option<&Judge<'_>>) -> Result<RunSummary> {
        if self.config.checkpoints.keep == Keep::Last || self.best == Rating::default() {
            Agent::write(self.out, self.info(), &self.learner.averaged_actor())?;
        } else if !self.best.is_within_travel_limit() {
            self.monitor.warn(&format!(
                "the actuators of every evaluated agent hunt; even the best agent's travel is {:.1} times the limit; raise \
                 `travel_cost`",
                self.best.relative_travel
            ));
        }
        let kept = Agent::read(self.out)?;
        if kept.info().training.steps == 0 && self.steps > 0 {
            self.monitor.warn("training did not improve on the first agent, which is kept");
        }
        let summary = RunSummary {
            scores: whole.map(|judge| self.score(judge, &kept)).transpose()?,
            steps: self.steps,
            steps_per_s: self.steps as f64 / self.seconds.max(f64::MIN_POSITIVE),
            seed: self.config.budget.seed,
            buildings: self.config.training_set.buildings_text(),
            task: self.config.training_set.task.to_string(),
            period: self.config.training_set.period.clone(),
            lost_episodes: self.collector.lost(),
            out: self.out.to_owned(),
        };
        summary.write(self.out)?;
        self.warn_of(curve::write(self.out, self.config, Some(&summary)), "the learning curve");
        Ok(summary)
    }

    /// Returns the scores of the agent in the run's folder.
    fn score(&mut self, judge: &Judge<'_>, agent: &Agent) -> Result<AgentScores> {
        self.monitor.stage("evaluating the agent over the whole run period");
        judge.judge(agent)
    }

    /// Keeps the last good agent where learning cannot continue.
    fn give_up(&mut self, error: Error) -> Error {
        if matches!(error, Error::NotFinite { .. }) && self.best == Rating::default() {
            let written = Agent::write(self.out, self.info(), &self.learner.averaged_actor());
            self.warn_of(written.map_err(Error::from), "the last good agent");
        }
        error
    }

    /// Warns about something that cannot be saved, once until it can be saved again.
    fn warn_of(&mut self, written: Result<()>, what: &'static str) {
        let known = self.unsaved.iter().position(|each| *each == what);
        match (written, known) {
            (Err(error), None) => {
                self.unsaved.push(what);
                self.monitor.warn(&format!("{what} could not be saved: {error}"));
            }
            (Ok(()), Some(known)) => drop(self.unsaved.remove(known)),
            (Err(_), Some(_)) | (Ok(()), None) => {}
        }
    }

    /// Returns the description of the agent as it is now.
    fn info(&self) -> AgentInfo {
        let training = TrainingInfo { steps: self.steps, ..self.info.training.clone() };
        let distribution = self.learner.averaged_actor().distribution;
        let mut info = AgentInfo { distribution, training, ..self.info.clone() };
        if self.steps > 0 {
            let seen = self.learner.seen_types();
            info.node_types = seen.into_iter().map(|index| NodeType::ALL[index].name().to_owned()).collect();
        }
        info
    }
}

/// Checks that a run was trained by what this program would train on: it would be an agent of neither.
fn check_versions(there: &TrainingInfo, here: &TrainingInfo) -> std::result::Result<(), String> {
    let [theirs, ours] = [there, here].map(|info| {
        let TrainingInfo { generator, engine, base_controllers, .. } = info;
        let base = base_controllers.as_ref().map_or_else(String::new, |base| format!(", {base}"));
        format!("dataset {generator}, EnergyPlus {engine}{base}")
    });
    match theirs == ours {
        true => Ok(()),
        false => Err(format!(
            "it was trained with {theirs}; this program has {ours}: train anew in another folder"
        )),
    }
}

fn training_info(config: &TrainConfig) -> TrainingInfo {
    let Versions { package, generator, engine, controllers, guideline36 } = Versions::current();
    let acting = config.agent.acting;
    let base_controllers = match acting.is_supervision() {
        true => {
            let rules = acting.starts_from_rule().then(|| format!(", {}", linear_supervisor::identity()));
            Some(format!("guideline36 revision {guideline36}{}", rules.unwrap_or_default()))
        }
        false => acting.has_base().then_some(controllers),
    };
    TrainingInfo {
        algorithm: config.learner.name().into(),
        buildings: config.training_set.buildings_text(),
        tasks: config.training_set.task.to_string(),
        problem: config.training_set.problem.clone(),
        period: config.training_set.period.clone(),
        steps_per_hour: config.training_set.steps_per_hour,
        steps: 0,
        seed: config.budget.seed,
        package,
        generator,
        engine,
        base_controllers,
    }
}
