//! Actuator response check: whether the simulated equipment follows the command of every actuator.
//!
//! On a winter day and a summer day every actuator is stepped through its range (low, middle, high, middle, low, and
//! zero for a flow), each value held for most of an hour, all systems at once:
//!
//! 1. air flows, with supply air at 20 °C;
//! 2. supply temperatures, at middle and at full flow;
//! 3. outdoor air of central air loops, then all dampers of a loop open;
//! 4. heating setpoints, into the next day: low, middle, low, high, low, two hours each.
//!
//! Setpoints of zones that are controlled through their thermostats are tested on the same days, starting at 8:00: nothing
//! called for, heating setpoints high, nothing, cooling setpoints low, nothing, two hours each. Their equipment keeps
//! the schedules of the model, which is why the time of day matters.
//!
//! Flows and supply temperatures are compared with the command at the end of every held step but the first, setpoints
//! over the hold:
//!
//! - air flow: within 1 % of the command; none at zero;
//! - supply air temperature: within 0.2 K;
//! - outdoor air flow: within 2 % of the command; none at zero;
//! - heating setpoint: a raised setpoint increases the delivered heat compared with the low setpoint before and after,
//!   and either raises the zone temperature or holds it at the setpoint; a zone above its setpoint gets no heat, a zone
//!   below it gets some;
//! - setpoints of a thermostat: at the high heating setpoint, the zone gets more heat than before and after and is
//!   warmer or at the setpoint; at the low cooling setpoint, it gets more cooling and is cooler or at the setpoint.
//!
//! A miss counts as [`Verdict::AtCapacity`] only if the equipment shows that it is at its limit:
//!
//! - **supply temperature**: after each missed step the command moves halfway to the reached value for one step, and
//!   the outlet changes with it by less than a fifth of the command change, relative to the mean of the steps before
//!   and after (plus a quarter of its drift between these, and what it moves back and forth under the same command, as
//!   with a plant that cycles): a coil with capacity left would follow. If the nearer command is met at once, the coil
//!   is catching up while its inlet air settles (a lagging control would not meet it), and it must meet the original
//!   command by the end of the hold. An outlet that never moves fails: at the same flow and in the same season, some
//!   hold must end at its command.
//! - **damper**: the total flow of the loop's terminals equals the fan's design flow, and more was commanded.
//! - **outdoor air**: all supply air is outdoor air, and more was commanded; or outdoor air makes up for exhaust fans
//!   in the zones of the loop, within their design flow, and less was commanded.
//! - **heating setpoint**: the zone is above it without any heat, or gets heat and ends more than 0.5 K below it.
//! - **setpoints of a thermostat**: the zone is beyond it without more heat or cooling than before and after, or gets
//!   more and ends more than 0.5 K short of it, or misses the lowest heating or the highest cooling setpoint as well; or
//!   a schedule of the model switches equipment of the zone off for at least 90 % of the month.
//!
//! If the engine aborts the run of thermostat setpoints, each one that is not tested fails with the engine's message.

mod bench;
mod heat;
mod hold;
mod reading;
mod report;
mod thermostat;

use std::path::Path;
use std::sync::Arc;

use b2b_building::{PreparedBuilding, RunPeriod};
use b2b_energyplus::Library;

pub use report::{Condition, Level, Limit, Report, Row, Season, Verdict};

use crate::Result;
use crate::env::Env;
use crate::setpoints::calendar::{self, Seasons};
use crate::spaces::EpisodeConfig;
use crate::task::Task;
use crate::zones::ventilation::Ventilation;
use bench::Bench;
use hold::follow_holds;

const STEPS_PER_HOUR: u32 = 12;

/// Checks the response of every actuator of a building.
///
/// # Errors
/// The errors of [`Env::new`], [`Env::reset`] and [`Env::step`].
pub fn measure(library: &Library, building: &Arc<PreparedBuilding>, weather: &Path) -> Result<Report> {
    let mut rows = Vec::new();
    for season in [Season::Winter, Season::Summer] {
        if !hold::drives_all(building) {
            rows.extend(measure_season(library, building, weather, season)?);
        }
        if !hold::setpoints(building).is_empty() {
            rows.extend(bench(library, building, weather, season)?.thermostats()?);
        }
    }
    let order = |row: &Row| building.actuators().position(|a| a.name == row.actuator);
    rows.sort_by_key(order);
    Ok(Report { building: building.name.clone(), rows })
}

fn measure_season(
    library: &Library,
    building: &Arc<PreparedBuilding>,
    weather: &Path,
    season: Season,
) -> Result<Vec<Row>> {
    let mut bench = bench(library, building, weather, season)?;
    for hold in follow_holds(building) {
        bench.hold(&hold)?;
    }
    let mut rows = reading::rows(&bench.readings);
    if !heat::heated_zones(building).is_empty() {
        rows.extend(bench.heat()?);
    }
    Ok(rows)
}

/// Returns a building at the start of the days of a season.
fn bench<'a>(
    library: &Library,
    building: &'a Arc<PreparedBuilding>,
    weather: &Path,
    season: Season,
) -> Result<Bench<'a>> {
    let period = season.days(Seasons::of(weather, building.calendar())?);
    let episode = EpisodeConfig {
        weather: weather.to_owned(),
        period,
        steps_per_hour: STEPS_PER_HOUR,
        // The interlock would prevent zero flow.
        task: Task { ventilation: Ventilation::Free, ..Task::default() },
    };
    let mut bench = Bench {
        env: Env::new(library.clone(), Arc::clone(building), episode)?.observe_effects(),
        building,
        season,
        month: period.first().month_and_day()[0] as usize - 1,
        readings: Vec::new(),
    };
    bench.env.reset()?;
    Ok(bench)
}

impl Season {
    /// Returns its days at a site.
    fn days(self, seasons: Seasons) -> RunPeriod {
        let wanted = match self {
            Season::Winter => calendar::Season::Winter,
            Season::Summer => calendar::Season::Summer,
        };
        let days = if seasons.on(16) == wanted { "01-16..01-17" } else { "07-17..07-18" };
        days.parse().expect("a run period in the calendar")
    }
}
