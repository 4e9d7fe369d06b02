//! Errors of the builder.

use building2building::{Error, make};

fn error_of(result: building2building::Result<building2building::Env>) -> String {
    result.expect_err("an error").to_string()
}

#[test]
fn unknown_names_are_errors_that_name_them() {
    assert!(make("Warehose").expect_err("unknown").to_string().contains("Warehose"));
    let office = || make("OfficeSmall").expect("a building");
    assert!(error_of(office().task("ocupancy").build()).contains("ocupancy"));
    assert!(error_of(office().period("01-01..13-01").build()).contains("13-01"));
    assert!(error_of(office().place("Atlantis").build()).contains("Atlantis"));
    let first = office().task("ocupancy").period("monsoon").build();
    assert!(matches!(first, Err(Error::Environment(_))), "the first error counts");
}
