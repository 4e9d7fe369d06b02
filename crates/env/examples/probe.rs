use b2b_building::*;
use b2b_energyplus::{
    Level, Library,
    install::{Engine, Quiet},
};
use b2b_env::*;
use std::sync::Arc;
fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let t: BuildingType = a[1].parse()?;
    let engine = Engine::ensure(&mut Quiet)?;
    let library = Library::load(&engine.library)?;
    let place = a.get(2).filter(|s| !s.is_empty()).map(|s| s.as_str()).unwrap_or(t.home());
    let weather = climate::Place::find(place)?.epw(&mut Quiet)?;
    let site = climate::Site::read(&climate::Place::find(t.home())?.epw(&mut Quiet)?)?;
    let t0 = std::time::Instant::now();
    let model = t.base_model(&engine, &library, &site)?;
    let b = Arc::new(PreparedBuilding::new(t.name(), model, &weather, &library)?);
    println!("prepared {:?} area {}", t0.elapsed(), b.conditioned_floor_area);
    for x in b.actuators() {
        println!("  {} [{:.3},{:.3}] {}", x.name, x.low, x.high, x.quantity.unit());
    }
    for z in &b.zones {
        println!("  {z:?}");
    }
    let period: RunPeriod = a.get(3).map(|s| s.parse()).transpose()?.unwrap_or("01-01..01-07".parse()?);
    if a.get(4).is_some() {
        std::fs::write(&a[4], b.model_for(period, 12).to_epjson())?;
    }
    let mut env =
        Env::new(library, b.clone(), Episode { weather, period, steps_per_hour: 12, task: Task::default() })?;
    let t0 = std::time::Instant::now();
    println!("{:.2?}", env.reset()?);
    println!("reset {:?}", t0.elapsed());
    let mut seed = 12345u64;
    let n = env.episode_steps();
    let (low, high) = (env.action_space().low().to_vec(), env.action_space().high().to_vec());
    let t0 = std::time::Instant::now();
    let mut act = vec![0.0; low.len()];
    let mut mn = 1e9f64;
    let mut mx = -1e9f64;
    for i in 0..n {
        for k in 0..act.len() {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            let u = (seed >> 33) as f64 / (1u64 << 31) as f64;
            act[k] = low[k] + u * (high[k] - low[k]);
        }
        let s = env.step(&act)?;
        for z in 0..b.zones.len() {
            mn = mn.min(s.observation[z]);
            mx = mx.max(s.observation[z]);
        }
        if i % (n / 4) == 0 {
            println!("{:.2?}", s.observation);
        }
    }
    println!("{:.4} ms/step; T {mn:.1}..{mx:.1}", t0.elapsed().as_secs_f64() * 1e3 / n as f64);
    let m = env.metrics();
    println!("elec {} gas {} engine {:?}", m.electricity, m.gas, env.engine_meters()?);
    let msg = env.messages();
    println!("warnings {} severe {}", msg.count(Level::Warning), msg.count(Level::Severe));
    for x in msg.at_least(Level::Warning).take(40) {
        println!(
            "  {}: {}",
            x.level,
            x.text.lines().take(3).collect::<Vec<_>>().join(" | ").chars().take(230).collect::<String>()
        );
    }
    Ok(())
}
