use b2b_building::*;
use b2b_control::*;
use b2b_energyplus::{
    Level, Library,
    install::{Engine, Quiet},
};
use b2b_env::*;
use std::sync::Arc;
fn v(name: &str, d: &mut f64) {
    if let Ok(x) = std::env::var(name) {
        *d = x.parse().unwrap();
    }
}
fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let t: BuildingType = a[1].parse()?;
    let engine = Engine::ensure(&mut Quiet)?;
    let library = Library::load(&engine.library)?;
    let weather =
        climate::Place::find(std::env::var("PLACE").as_deref().unwrap_or(t.home()))?.epw(&mut Quiet)?;
    let site = climate::Site::read(&climate::Place::find(t.home())?.epw(&mut Quiet)?)?;
    let model = t.base_model(&engine, &library, &site)?;
    let b = Arc::new(PreparedBuilding::new(t.name(), model, &weather, &library)?);
    let mut p = ReactiveParameters::default();
    v("KP", &mut p.unitary.gains.proportional);
    v("KI", &mut p.unitary.gains.integral);
    v("SPLIT", &mut p.unitary.temperature_share);
    v("MIN", &mut p.unitary.least_flow);
    v("LIFT", &mut p.unitary.heating_lift);
    v("DROP", &mut p.unitary.cooling_drop);
    v("RESP", &mut p.unitary.trim_respond.respond);
    v("TRIM", &mut p.unitary.trim_respond.trim);
    v("TH", &mut p.unitary.trim_respond.threshold);
    v("AKP", &mut p.air_loop.gains.proportional);
    v("AKI", &mut p.air_loop.gains.integral);
    v("AMIN", &mut p.air_loop.least_opening);
    v("AWARM", &mut p.air_loop.warmest_supply);
    v("ACOLD", &mut p.air_loop.coldest_supply);
    v("ARESP", &mut p.air_loop.trim_respond.respond);
    v("ATRIM", &mut p.air_loop.trim_respond.trim);
    v("ATH", &mut p.air_loop.trim_respond.threshold);
    v("ADB", &mut p.air_loop.deadband);
    v("AHO", &mut p.air_loop.heating_opening);
    v("AOA", &mut p.air_loop.least_outdoor_air);
    for period in a[2..].iter() {
        let period: RunPeriod = period.parse()?;
        let mut env = Env::new(
            library.clone(),
            b.clone(),
            Episode { weather: weather.clone(), period, steps_per_hour: 12, task: Task::default() },
        )?;
        let mut c = Reactive::new(&b, 21.0, 12, &p);
        let mut obs = env.reset()?.to_vec();
        let mut act = vec![0.0; env.action_space().len()];
        let show = std::env::var("SHOW")
            .ok()
            .map(|s| s.split(',').map(|x| x.parse::<usize>().unwrap()).collect::<Vec<_>>());
        let mut k = 0;
        loop {
            c.act(&obs, &mut act);
            let s = env.step(&act)?;
            obs.copy_from_slice(s.observation);
            k += 1;
            if let Some(r) = &show {
                if k >= r[0] && k < r[1] {
                    let z = r[2];
                    println!(
                        "{k} h{:.2} T {:.2} out {:.1} act {:.3} {:.2} E {:.2} {:.2}",
                        obs[b.zones.len() + 2],
                        obs[z],
                        obs[b.zones.len()],
                        act[r[3]],
                        act[r[3] + 1],
                        obs[b.zones.len() + 5],
                        obs[b.zones.len() + 6]
                    );
                }
            }
            if s.truncated {
                break;
            }
        }
        let m = env.metrics();
        print!("{} {period}: RMS {:.3} |", t, m.rms_deviation());
        for z in &m.zones {
            print!(
                " {} {:.2}{}",
                b.zones[z.slot].name,
                z.rms_deviation(m.steps),
                if z.fully_conditioned { "" } else { "*" }
            );
        }
        println!(
            " | kWh/m2 e {:.1} g {:.1} | w {} s {}",
            m.electricity / 1e3,
            m.gas / 1e3,
            env.message_count(Level::Warning),
            env.message_count(Level::Severe)
        );
        if std::env::var("MSG").is_ok() {
            for x in env.messages().at_least(Level::Warning) {
                println!(
                    "  {}: {}",
                    x.level,
                    x.text
                        .lines()
                        .take(3)
                        .collect::<Vec<_>>()
                        .join(" | ")
                        .chars()
                        .take(230)
                        .collect::<String>()
                );
            }
        }
    }
    Ok(())
}
