//! Exhaust fans of a controllable restaurant, by the engine's own flows.

use std::path::Path;

use b2b_building::model::text;
use b2b_building::{BuildingType, Model};
use b2b_climate::{Place, Site};
use b2b_dataset::{Preparation, archetype};
use b2b_energyplus::install::{Engine, Quiet};
use b2b_energyplus::{Event, Library, Run};

const FAN: &str = "Fan:ZoneExhaust";
const STEPS_PER_HOUR: usize = 12;

/// Mean flow of every exhaust fan in each hour of a day, kg/s.
fn flows(model: &Model, weather: &Path, library: &Library) -> Vec<[f64; 24]> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.epJSON");
    std::fs::write(&path, model.to_epjson()).unwrap();
    let nodes: Vec<String> = model
        .objects(FAN)
        .into_iter()
        .map(|(_, fan)| text(fan, "air_inlet_node_name").unwrap().to_owned())
        .collect();
    let mut run = Run::new(&path, weather);
    for node in &nodes {
        run = run.request("System Node Mass Flow Rate", node);
    }
    let mut simulation = run.start(library).unwrap();
    let variables: Vec<_> =
        nodes.iter().map(|node| simulation.variable("System Node Mass Flow Rate", node).unwrap()).collect();
    let mut means = vec![[0.0; 24]; nodes.len()];
    let mut step = 0;
    while let Some(event) = simulation.advance().unwrap() {
        if event == Event::Step {
            for (means, variable) in means.iter_mut().zip(&variables) {
                let hour = (step / STEPS_PER_HOUR).min(23);
                means[hour] += simulation.read(*variable) / STEPS_PER_HOUR as f64;
            }
            step += 1;
        }
    }
    assert_eq!(step, 24 * STEPS_PER_HOUR);
    means
}

#[test]
fn exhaust_fans_keep_the_schedule_of_the_prototype_at_every_hour() {
    let engine = Engine::ensure(&mut Quiet).unwrap();
    let library = Library::load(&engine.library).unwrap();
    let weather = Place::find("Denver").unwrap().epw(&mut Quiet).unwrap();
    let site = Site::read(&weather).unwrap();
    let restaurant = BuildingType::RestaurantFastFood;
    let prototype = archetype::base_model(restaurant, &engine, &library, &site).unwrap();
    let prepared = Preparation::new("restaurant", prototype).run(&weather, &library).unwrap();
    let day = "01-03..01-03".parse().unwrap();
    let flows = flows(&prepared.model_for(day, STEPS_PER_HOUR as u32), &weather, &library);
    assert_eq!(flows.len(), 2);
    for flow in flows {
        println!("{flow:.3?}");
        for (hour, flow) in flow.into_iter().enumerate() {
            // `Hours_of_operation`: closed from one to five.
            let closed = (1..5).contains(&hour);
            assert_eq!(flow == 0.0, closed, "hour {hour}: {flow}");
        }
    }
}
