use b2b_agent::{Acting, ObservationForm};
use b2b_building::BuildingType;
use b2b_dataset::BuildingId;

use super::{TrainConfig, TrainingSet};
use crate::ppo::PpoConfig;
use crate::sac::SacConfig;

const NAMED: &str = "buildings = ['OfficeSmall-0042']";

fn changed(base: &TrainConfig, changes: &str) -> TrainConfig {
    base.with_changes(changes).unwrap()
}

#[test]
fn every_preset_is_complete_and_valid() {
    for name in TrainConfig::presets() {
        let named = changed(&TrainConfig::preset(name).unwrap(), NAMED);
        named.check().unwrap();
        assert_eq!(changed(&TrainConfig::default(), &named.to_toml()), named, "{}", named.to_toml());
    }
    let said = TrainConfig::preset("papper").unwrap_err().to_string();
    assert!(
        said.contains("expected `direct` or `graph` or `paper` or `recurrent` or `residual` or `supervisory` or `supervisory-graph`; did you mean `paper`?"),
        "{said}"
    );
}

#[test]
fn a_configuration_is_written_with_the_options_of_its_learner_alone() {
    let residual = TrainConfig::preset("residual").unwrap();
    let text = residual.to_toml();
    assert!(text.starts_with("algorithm = \"ppo\"") && text.contains("gamma = 0.98\n"), "{text}");
    assert!(text.contains("[ppo]") && !text.contains("[sac]"), "{text}");
    let sac = changed(&residual, "algorithm = 'sac'\n[sac]\ngamma = 0.9\n[ppo]\ngamma = 0.8");
    assert!(sac.to_toml().contains("[sac]") && !sac.to_toml().contains("[ppo]"));
    assert_eq!(sac.learner.options::<SacConfig>().unwrap().gamma, 0.9);
    assert_eq!(changed(&TrainConfig::default(), &sac.to_toml()), sac);
    // Tables of the other learners are read too, so that a mistake in them is an error.
    assert!(residual.with_changes("[sac]\ngama = 0.9").unwrap_err().contains("did you mean `gamma`?"));
}

#[test]
fn a_run_that_names_no_preset_has_the_one_for_its_tasks_acting_and_buildings() {
    let folder = tempfile::tempdir().unwrap();
    let preset_of = |options: &str, file: &str| {
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, file).unwrap();
        let config = TrainConfig::of_json(options, None, Some(&path)).unwrap();
        let is_of = |name: &&str| {
            let named = TrainConfig::of_json(options, Some(name), Some(&path)).unwrap();
            named == config
        };
        TrainConfig::presets().find(is_of).unwrap()
    };
    assert_eq!(preset_of("{}", ""), "residual");
    assert_eq!(preset_of(r#"{"task": "operate"}"#, ""), "supervisory");
    assert_eq!(preset_of("{}", "task = 'operate+tou'"), "supervisory");
    assert_eq!(preset_of(r#"{"task": "constant"}"#, "task = 'operate'"), "residual");
    assert_eq!(preset_of(r#"{"task": ["operate", "occupancy"]}"#, ""), "residual");
    let offices = r#"{"building_type": ["OfficeMedium"]}"#;
    assert_eq!(preset_of(offices, "task = 'operate'"), "supervisory-graph");
    assert_eq!(preset_of(r#"{"task": "operate"}"#, "building_type = 'OfficeMedium'"), "supervisory-graph");
    let named = r#"{"task": "operate", "buildings": ["OfficeSmall-0042"], "building_type": []}"#;
    assert_eq!(preset_of(named, "building_type = 'OfficeMedium'"), "supervisory");
    assert_eq!(preset_of(r#"{"task": "operate", "acting": "residual:0.3"}"#, ""), "residual");
    assert_eq!(preset_of(r#"{"acting": {"kind": "supervisory", "every": 30}}"#, ""), "supervisory");
    assert_eq!(preset_of(r#"{"task": "operate"}"#, "preset = 'paper'"), "paper");
    let path = folder.path().join("wrong.toml");
    std::fs::write(&path, "task = 'occupency'").unwrap();
    let said = TrainConfig::of_json("{}", None, Some(&path)).unwrap_err().to_string();
    assert!(said.contains("`task`: ") && said.contains("did you mean occupancy?"), "{said}");
}

#[test]
fn acting_is_a_text_or_a_table() {
    let acting = |text: &str| TrainConfig::default().with_changes(text).map(|config| config.agent.acting);
    let hourly = Acting::Supervisory { every: 60, shared: true, setpoints: true, rule: false };
    assert_eq!(acting("acting = 'supervisory:60'").unwrap(), hourly);
    assert_eq!(acting("acting = { kind = 'supervisory', every = 60 }").unwrap(), hourly);
    let said = acting("acting = 'supervise'").unwrap_err();
    assert!(said.contains("unknown acting `supervise`; expected direct, residual:0.5"), "{said}");
}

#[test]
fn options_of_arguments_are_ignored_in_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, "preset = 'residual'\nseed = 7\nalgorithm = 'ppo'\nsac = { gamma = 0.9 }").unwrap();
    let paper = TrainConfig::preset("paper").unwrap();
    assert_eq!(paper.with_file(&path, &["preset"]).unwrap(), changed(&paper, "seed = 7"));
    let residual = TrainConfig::preset("residual").unwrap();
    assert_eq!(paper.with_file(&path, &[]).unwrap(), changed(&residual, "seed = 7"));
    let sac = paper.with_algorithm("sac").unwrap().with_file(&path, &["preset", "algorithm"]).unwrap();
    assert_eq!(sac.learner.options::<SacConfig>().unwrap().gamma, 0.9);
}

#[test]
fn the_preset_of_the_paper_has_the_numbers_of_its_table() {
    let TrainConfig { learner, budget, agent, .. } = TrainConfig::preset("paper").unwrap();
    let ppo: &PpoConfig = learner.options().unwrap();
    assert_eq!((ppo.learning_rate, ppo.batch_size, ppo.n_steps, ppo.epochs), (5e-5, 336, 672, 5));
    assert_eq!((ppo.target_kl, ppo.gamma, ppo.gae_lambda), (Some(0.02), 0.98, 0.95));
    assert_eq!((ppo.clip_range, ppo.entropy_coefficient, ppo.value_coefficient), (0.2, 0.01, 0.5));
    assert_eq!((ppo.max_grad_norm, ppo.initial_log_std, budget.environments), (0.5, -1.0, 14));
    assert_eq!((&ppo.actor_hidden, &ppo.critic_hidden), (&vec![256, 256], &vec![256, 256]));
    assert_eq!((agent.acting, agent.observation), (Acting::Direct, ObservationForm::Raw.into()));
}

#[test]
fn the_direct_preset_is_the_papers_with_features() {
    let direct = TrainConfig::preset("direct").unwrap();
    assert_eq!(changed(&TrainConfig::preset("paper").unwrap(), "observation = 'features'"), direct);
}

/// A run that does not read its own options cannot be resumed.
#[test]
fn a_run_with_other_controls_and_faults_reads_its_own_file() {
    let options = "control = 'setpoints'\nkeep_design_days = true\ntask = 'constant+bias1'\nfault_seeds = 8";
    let config = changed(&TrainConfig::default(), options);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("config.toml"), config.to_toml()).unwrap();
    assert_eq!(TrainConfig::of_run(folder.path()).unwrap(), config);
}

#[test]
fn a_wrong_key_or_value_is_an_error_that_names_it() {
    let base = TrainConfig::default();
    for (changes, said) in [
        ("enviroments = 3", &["unknown field `enviroments`", "did you mean `environments`?"][..]),
        ("[ppo]\ngama = 0.9", &["`ppo`", "did you mean `gamma`?"]),
        ("[evaluation]\nevry = 3", &["`evaluation`", "did you mean `every`?"]),
        ("[pppo]\ngamma = 0.9", &["did you mean `ppo`?"]),
        ("steps = \"many\"", &["`steps`", "many"]),
        ("keep = \"bst\"", &["`keep`", "did you mean `best`?"]),
        ("evaluation = 3", &["`evaluation` is 3; expected a table"]),
        ("algorithm = 'pop'", &["unknown algorithm `pop`; expected ppo or sac"]),
        ("algorithm = 3", &["`algorithm` is 3; expected a name"]),
        (
            "policy = { kind = 'graph' }\n[ppo]\nactor_hidden = [8]",
            &["`ppo.actor_hidden` has no effect: it is for other networks", "`policy.embedding`"],
        ),
        ("policy = { kind = 'graph' }\n[ppo]\nactivation = 'relu'", &["`ppo.activation` has no effect"]),
        ("noise_cost = 2.5\n[ppo]\ninitial_log_std = -1.8", &["`ppo.initial_log_std` has no effect"]),
        ("[ppo]\nnormalize_values = false\nvalue_rate = 0.2", &["`ppo.value_rate` has no effect"]),
        ("travel_cost_growth = 10.0", &["`travel_cost_growth` has no effect: `travel_cost` is 0"]),
        ("window_starts = 6", &["`window_starts` has no effect", "`window_days`"]),
        ("acting = { kind = 'direct', every = 60 }", &["`acting`: unknown field `every`; \"direct\" has no"]),
        ("policy = { kind = 'flat', width = 64 }", &["`policy`: unknown field `width`; \"flat\" has no"]),
    ] {
        let error = base.with_changes(changes).unwrap_err();
        assert!(said.iter().all(|part| error.contains(part)), "{changes}: {error}");
    }
    let changed = changed(&base, "preset = \"paper\"\nseed = 7\n[ppo]\ngamma = 0.9");
    let ppo: &PpoConfig = changed.learner.options().unwrap();
    assert_eq!((changed.budget.seed, ppo.gamma, ppo.epochs), (7, 0.9, 5));
}

#[test]
fn a_task_in_a_table_is_the_one_in_a_text() {
    let of = |text: &str| changed(&TrainConfig::default(), text).training_set.task;
    assert_eq!(of("task = { setpoints = { mode = 'band' }, tariff = 'tou' }"), of("task = 'operate+tou'"));
    let both = "task = { tariff = 'tou', prices = { electricity = 1, gas = 1 } }";
    assert!(
        TrainConfig::default().with_changes(both).unwrap_err().contains("`tariff` replaces its `prices`")
    );
}

#[test]
fn the_file_of_a_graph_run_can_be_given_with_another_preset() {
    let graph = changed(&TrainConfig::preset("paper").unwrap(), "policy = { kind = 'graph' }");
    assert_eq!(changed(&TrainConfig::preset("residual").unwrap(), &graph.to_toml()), graph);
}

#[test]
fn what_a_file_asks_for_is_not_turned_off_by_the_caller_s_algorithm() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.toml");
    std::fs::write(&path, format!("{NAMED}\nmirrored_noise = true")).unwrap();
    let of = |options| TrainConfig::of_json(options, None, Some(&path)).unwrap();
    assert!(of("{}").check().is_ok());
    let said = of(r#"{"algorithm": "sac"}"#).check().unwrap_err().to_string();
    assert!(said.contains("`mirrored_noise` is for ppo"), "{said}");
    std::fs::write(&path, format!("{NAMED}\nalgorithm = 'ppo'")).unwrap();
    let sac = of(r#"{"algorithm": "sac"}"#);
    assert!(sac.check().is_ok() && sac.learner.name() == "sac");
}

#[test]
fn the_caller_s_options_of_a_learner_that_is_not_chosen_are_an_error() {
    let of = |options| TrainConfig::of_json(options, None, None);
    let said = of(r#"{"sac": {"gamma": 0.9}}"#).unwrap_err().to_string();
    assert!(said.contains("`sac` has no effect: `algorithm` is ppo; choose sac, or remove it"), "{said}");
    let said = of(r#"{"algorithm": "sac", "ppo": {"epochs": 2}}"#).unwrap_err().to_string();
    assert!(said.contains("`ppo` has no effect"), "{said}");
    assert!(of(r#"{"algorithm": "sac", "sac": {"gamma": 0.9}, "ppo": {}}"#).is_ok());
}

#[test]
fn values_that_do_not_go_together_are_errors() {
    let named = changed(&TrainConfig::default(), NAMED);
    for (changes, said) in [
        ("environments = 0", "`environments` is 0"),
        ("window_days = 100", "0 for the whole run period"),
        ("fault_seeds = 8", "`fault_seeds` is 8 and a task has no faults"),
        ("buildings = []", "building_type"),
        ("buildings = ['OfficeSmall-0042', 'Warehouse']", "choose the preset graph, or one type"),
        ("travel_cost = -1", "`travel_cost` is -1"),
        ("travel_cost = 1\ntravel_cost_growth = 0.5", "`travel_cost_growth` is 0.5"),
        ("evaluation = { days = 0 }", "`evaluation.days` is 0"),
        ("noise_cost = 0.5", "`noise_cost` is 0.5"),
        ("ppo = { gamma = 2.0 }", "`gamma` is 2"),
        ("place = 'Miami'\nweather = 'x.epw'", "either `place` or `weather`"),
        ("acting = { kind = 'residual', authority = 1.5 }", "`acting.authority` is 1.5"),
        ("acting = { kind = 'supervisory', every = 60 }", "choose `task` = operate"),
        ("task = 'operate'\nacting = { kind = 'supervisory', every = 20 }", "expected 15, 30 or 60 min"),
        ("acting = { kind = 'targets', every = 20, shift = 1 }", "expected 15, 30 or 60 min"),
        ("acting = { kind = 'targets', every = 60, shift = 9 }", "`acting.shift` is 9"),
        (
            "acting = { kind = 'targets', every = 60, shift = 1 }\npolicy = { kind = 'graph' }",
            "`acting` shifts targets, which graph networks cannot",
        ),
        (
            "task = 'operate'\nacting = { kind = 'supervisory', every = 15 }\nsteps_per_hour = 6",
            "a whole number of steps, 6 per hour",
        ),
        ("comfort_rate = 0.5", "`comfort_rate` is for tasks of operation"),
        ("task = 'operate'\ncomfort_weight = 0.1", "requires a `comfort_rate` above 0"),
        (
            "task = 'operate'\ncomfort_rate = 0.5\ncomfort_weight = 0",
            "`comfort_weight` is 0; expected 0.03 to 30",
        ),
        ("task = 'operate'\ncomfort_rate = 2", "`comfort_rate` is 2; expected 0 to 1"),
        ("task = 'operate'\ncomfort_rate = 0.5\nevaluation.every = 0", "`evaluation.every` is 0"),
        ("task = 'constant,random'\nobservation = 'raw'", "the observation `features`"),
        (
            "algorithm = 'sac'\nmirrored_noise = true",
            "`mirrored_noise` is for ppo; with sac it must be false",
        ),
        ("algorithm = 'sac'\ncredit_by_zone = true", "`credit_by_zone` is for ppo"),
        (
            "algorithm = 'sac'\ntravel_cost = 1\ntravel_cost_growth = 10",
            "`travel_cost_growth` is for ppo: sac learns from rewards",
        ),
        ("algorithm = 'sac'\ntask = 'operate'\ncomfort_rate = 1", "`comfort_rate` is for ppo: sac learns"),
        ("ppo = { desired_kl = 0.01, epochs = 1, batch_size = 100000 }", "need two minibatches in an update"),
        ("algorithm = 'sac'\npolicy = { kind = 'graph' }", "`algorithm` with graph networks: it must be ppo"),
        ("ppo = { credit = [[1.0]] }", "`ppo.credit` follows from `credit_by_zone`"),
        ("window_days = 7\nwindow_starts = 0", "`window_starts` is 0"),
        ("building_episodes = 7", "`building_episodes` is 7, for a drawn `building_type`"),
        ("final_noise = 0.0001", "-9.21, is below `ppo.minimum_log_std`, -5"),
        ("policy = { kind = 'graph', heads = 3 }", "`policy.heads` is 3"),
        (
            "policy = { kind = 'graph', memory_episodes = 2 }",
            "`policy.memory_episodes` is 2 and `policy.memory` is 0",
        ),
        ("policy = { kind = 'graph', sequence = 24 }", "`policy.sequence` is 24 and `policy.memory` is 0"),
        ("policy = { kind = 'graph', memory = 8, sequence = 100 }", "a multiple of `policy.sequence`, 100"),
        (
            "algorithm = 'sac'\npolicy = { kind = 'recurrent' }",
            "`algorithm` with recurrent networks: it must be ppo",
        ),
        ("policy = { kind = 'recurrent', width = 0 }", "`policy.width` is 0"),
        (
            "policy = { kind = 'recurrent', sequence = 96 }\nppo = { n_steps = 100 }",
            "`ppo.n_steps` is 100; expected a multiple of `policy.sequence`, 96",
        ),
        (
            "policy = { kind = 'graph' }\nobservation = { form = 'raw', feedback = true }",
            "`observation.feedback` with graph networks: `form` must be features",
        ),
        ("ppo = { log_std = 'of_state' }\nfinal_noise = 0.5", "with `ppo.log_std` = of_state"),
        ("excluded_climate_zones = ['1']", "`excluded_climate_zones` are for `building_type`"),
    ] {
        let error = changed(&named, changes).check().unwrap_err().to_string();
        assert!(error.contains(said), "{changes}: {error}");
    }
}

#[test]
fn buildings_of_excluded_climate_zones_are_not_drawn() {
    let of = |zones: &str| {
        changed(
            &TrainConfig::default(),
            &format!("building_type = 'OfficeSmall'\nexcluded_climate_zones = [{zones}]"),
        )
    };
    let (all, some) = (of(""), of("'5B', '8'"));
    let drawn = |config: &TrainConfig| config.training_set.drawn(BuildingType::OfficeSmall);
    let zone = |id: &BuildingId| b2b_dataset::row(*id).building.location().ashrae_zone().unwrap();
    assert_eq!(drawn(&all).len(), 900);
    assert!(drawn(&all).iter().any(|id| zone(id) == "5B"));
    assert!(drawn(&some).iter().all(|id| !["5B", "8"].contains(&zone(id))));
    assert!(drawn(&some).iter().any(|id| zone(id) == "5A"));
    let text = "OfficeSmall of the training split outside of the climate zones 5B, 8";
    assert_eq!(some.training_set.buildings_text(), text);
    of("'1', '5B'").check().unwrap();
    let error = |zones: &str| of(zones).check().unwrap_err().to_string();
    assert!(error("'9'").contains("`9`, which no OfficeSmall is in"));
    assert!(error("'1', '2', '3', '4', '5', '6', '7', '8'").contains("leave no OfficeSmall"));
}

#[test]
fn a_preset_with_sac_leaves_out_what_is_for_ppo() {
    let residual = TrainConfig::preset("residual").unwrap();
    let changes = format!("{NAMED}\nalgorithm = \"sac\"");
    let sac = changed(&residual, &changes);
    sac.check().unwrap();
    assert_eq!(sac.learner.name(), "sac");
    let error = changed(&residual, &format!("{changes}\nnoise_cost = 2.0")).check().unwrap_err();
    assert!(error.to_string().contains("noise_cost"), "{error}");
}

/// Earlier runs wrote the options of both learners, in another order.
#[test]
fn a_configuration_of_an_earlier_run_is_read() {
    let config = TrainConfig::preset("residual").unwrap();
    let sac = crate::learners::LearnerKind::find("sac").unwrap();
    let earlier = format!("{}\n{}", config.to_toml(), crate::learners::LearnerChoice::from(sac).to_toml());
    assert_eq!(changed(&TrainConfig::default(), &earlier), config);
}

#[test]
fn only_the_caller_permits_a_model_to_run_code() {
    let allowed = TrainConfig::default().with_json(r#"{"allow_external": true}"#).unwrap();
    assert!(allowed.training_set.allow_external);
    assert!(allowed.with_changes("seed = 7").unwrap().training_set.allow_external);
    assert!(!allowed.to_toml().contains("allow_external"));
    TrainConfig::default().with_changes("allow_external = false").unwrap();
    let said = TrainConfig::default().with_changes("allow_external = true").unwrap_err();
    assert!(said.contains("pass --allow-external"), "{said}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("config.toml");
    std::fs::write(&path, "allow_external = true").unwrap();
    let said = TrainConfig::default().with_file(&path, &[]).unwrap_err().to_string();
    assert!(said.contains("pass --allow-external"), "{said}");
    assert!(!TrainConfig::of_run(folder.path()).unwrap().training_set.allow_external);
}

#[test]
fn the_preset_for_many_buildings_draws_some_of_the_training_split_and_holds_comfort_in_every_period() {
    let preset = TrainConfig::preset("supervisory-graph").unwrap();
    let config = changed(&preset, "building_type = ['OfficeMedium', 'Warehouse']");
    config.check().unwrap();
    let drawn = config.training_set.drawn(BuildingType::OfficeMedium);
    assert_eq!(drawn.len(), 24);
    assert!(drawn.iter().all(|id| b2b_dataset::row(*id).split == b2b_dataset::Split::Train));
    let spread = drawn.windows(2).all(|pair| (30..60).contains(&(pair[1].number() - pair[0].number())));
    assert!(spread, "{drawn:?}");
    assert_eq!(config.training_set.periods().unwrap().len(), 5);
    let turns = changed(&config, "type_turns = { OfficeMedium = 3 }").training_set.turns().unwrap();
    assert_eq!(
        turns.iter().map(|each| each.name()).collect::<Vec<_>>().join(" "),
        "OfficeMedium Warehouse OfficeMedium OfficeMedium"
    );
    changed(&config, "ppo = { balance_buildings = true }").check().unwrap();
    let flat = "policy = { kind = \"flat\" }\nbuilding_type = [\"OfficeMedium\"]\ncredit_by_zone = false\nppo = { balance_buildings = true }";
    let said = changed(&config, flat).check().unwrap_err().to_string();
    assert!(said.contains("`ppo.balance_buildings` is for graph networks"), "{said}");
    let said = changed(&config, "type_turns = { Warehouse = 0 }").check().unwrap_err().to_string();
    assert!(said.contains("`type_turns` of Warehouse is 0"), "{said}");
    let said = changed(&config, "type_turns = { OfficeSmall = 2 }").check().unwrap_err().to_string();
    assert!(
        said.contains("`OfficeSmall`, which is not in `building_type` (OfficeMedium, Warehouse)"),
        "{said}"
    );
    let said = changed(&config, "period = 'peak-heating,wintr'").check().unwrap_err().to_string();
    assert!(said.contains("wintr"), "{said}");
    let said = changed(&config, "window_days = 20").check().unwrap_err().to_string();
    assert!(said.contains("14 days"), "{said}");
}

#[test]
fn a_window_that_nobody_chose_is_at_most_the_shortest_period() {
    for (period, days) in [("winter", 14), ("peak-heating,01-01..01-03", 3), ("wintr", 0)] {
        let mut set = TrainingSet { window_days: 14, period: period.into(), ..TrainingSet::default() };
        set.shorten_window();
        assert_eq!(set.window_days, days, "{period}");
    }
}
