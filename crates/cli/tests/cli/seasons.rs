//! A winter and a summer of the six building types under the reactive controller.

use crate::program::json;

/// Asserts the sizes of the paper's table, and that zones stay near their target for a winter and a summer.
fn holds_its_target_all_season(building: &str, observations: usize, actions: usize) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shown = json(folder.path(), &format!("show {building} --task constant"));
    assert_eq!(shown["observation"].as_array().map(Vec::len), Some(observations));
    assert_eq!(shown["action"].as_array().map(Vec::len), Some(actions));

    for (period, steps) in [("winter", 25_920), ("summer", 26_496)] {
        let run =
            json(folder.path(), &format!("run {building} --task constant --period {period} --out {period}"));
        assert_eq!(run["steps"], steps, "{building} {period}");
        assert_eq!(run["engine_severes"], 0, "{building} {period}");
        let number = |key: &str| run[key].as_f64().unwrap_or(f64::NAN);
        assert!(number("meter_relative_error") < 1e-6, "{building} {period}: {run}");
        assert!(number("rms_deviation_k") <= 0.7, "{building} {period}: {run}");
        assert!(number("electricity_wh_m2") > 0.0, "{building} {period}: {run}");
    }
}

#[test]
fn a_house_holds_its_target_all_season() {
    holds_its_target_all_season("SingleFamilyHouse", 9, 2);
}

#[test]
fn a_restaurant_holds_its_target_all_season() {
    holds_its_target_all_season("RestaurantFastFood", 10, 4);
}

#[test]
fn a_warehouse_holds_its_target_all_season() {
    holds_its_target_all_season("Warehouse", 10, 5);
}

#[test]
fn a_shop_holds_its_target_all_season() {
    holds_its_target_all_season("RetailStandalone", 12, 9);
}

#[test]
fn a_small_office_holds_its_target_all_season() {
    holds_its_target_all_season("OfficeSmall", 13, 10);
}

#[test]
fn a_medium_office_holds_its_target_all_season() {
    holds_its_target_all_season("OfficeMedium", 25, 36);
}
