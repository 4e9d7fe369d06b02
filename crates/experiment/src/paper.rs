//! Numbers of the paper.

use b2b_building::BuildingType;

/// A row of the paper's table of PPO agents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PaperScore {
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
    /// Number of the eight buildings on which the agent beats the baseline.
    pub(crate) beats: u32,
}

/// Returns the paper's row for a type, task and period; `None` if the paper has none.
pub(crate) fn score(building_type: &str, task: &str, period: &str) -> Option<PaperScore> {
    let weight = match task.split_once('+') {
        None => "0",
        Some((_, energy)) => energy.strip_prefix("energy")?,
    };
    let setpoints = task.split('+').next()?;
    let row = include_str!("../data/paper-ppo.csv").lines().map(|line| line.split(',').collect::<Vec<_>>());
    let row = row.skip(1).find(|row| row[..4] == [building_type, setpoints, weight, period])?;
    let number = |column: usize| row[column].parse().ok();
    Some(PaperScore { median: number(4)?, min: number(5)?, max: number(6)?, beats: row[7].parse().ok()? })
}

/// Returns the paper's mean and standard deviation of the time of a step, ms.
pub(crate) fn step_time(building_type: BuildingType) -> [f64; 2] {
    match building_type {
        BuildingType::OfficeSmall => [0.170, 0.018],
        BuildingType::OfficeMedium => [0.410, 0.096],
        BuildingType::RetailStandalone => [0.153, 0.021],
        BuildingType::RestaurantFastFood => [0.059, 0.006],
        BuildingType::Warehouse => [0.209, 0.044],
        BuildingType::SingleFamilyHouse => [0.021, 0.002],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_table_is_found() {
        let mut found = 0;
        for building_type in BuildingType::ALL {
            for task in ["constant", "constant+energy0.5", "occupancy", "occupancy+energy0.5"] {
                for period in ["winter", "summer"] {
                    let row = score(building_type.name(), task, period).unwrap();
                    assert!(row.min <= row.median && row.median <= row.max && row.beats <= 8);
                    found += 1;
                }
            }
        }
        assert_eq!(found, include_str!("../data/paper-ppo.csv").lines().count() - 1);
        assert_eq!(score("OfficeSmall", "constant+energy1", "winter"), None);
        assert_eq!(score("OfficeSmall", "random", "winter"), None);
    }
}
