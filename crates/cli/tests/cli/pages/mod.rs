//! Every page in a browser: at the widths of a telephone and of a desk, light and dark, without errors and without
//! scrolling sideways.

pub(crate) mod browser;

use self::browser::Browser;
use crate::program::{b2b, stderr};
use serde_json::json;

/// A command that writes a page, the page, and a script whose value is true once it is drawn.
const PAGES: [(&str, &str, &str); 11] = [
    ("run RestaurantFastFood --period 01-01..01-02 --task occupancy --out a", "a/picture.html", DRAWN),
    ("compare a b --out compare.html", "compare.html", DRAWN),
    ("dataset explore --out .", "dataset.html", "document.querySelectorAll('tbody tr').length === 25"),
    (
        "view RestaurantFastFood --out view.html",
        "view.html",
        "document.querySelectorAll('.main-svg').length > 2",
    ),
    (
        "evaluate SingleFamilyHouse-0014 --policy reactive --task constant --period 01-10..01-10 --out e",
        "e/report.html",
        "document.querySelectorAll('.grid .main-svg').length > 5",
    ),
    (
        "run RestaurantFastFood --period 01-01..01-02 --task operate+tou --controller guideline36 --out g",
        "g/picture.html",
        "document.querySelectorAll('.pair tbody tr').length > 3 && document.querySelector('.states') !== null",
    ),
    ("compare d g --out operate.html", "operate.html", DRAWN),
    (
        "evaluate SingleFamilyHouse-0014 --policy reactive --task operate --period 01-10..01-10 --out f",
        "f/report.html",
        "document.querySelectorAll('.grid .main-svg').length > 2",
    ),
    (
        "evaluate SingleFamilyHouse-0014 --policy random --period 01-10..01-10 07-10..07-10 --task constant \
         occupancy+energy0.5 --out several",
        "several/report.html",
        "document.querySelectorAll('.grid .main-svg').length > 5",
    ),
    (
        "train SingleFamilyHouse --config t.toml --period 01-01..01-02 --steps 2000 --environments 2 --out t",
        "t/curve.html",
        "document.querySelectorAll('.main-svg').length > 2",
    ),
    ("run SingleFamilyHouse --controller t --period 01-01..01-02 --out c", "c/picture.html", DRAWN),
];
/// A short training with an evaluation at its end.
const TRAINING: &str = "window_days = 1\n[evaluation]\nevery = 0\n";
const DRAWN: &str =
    "document.querySelector('canvas')?.height > 50 && document.querySelectorAll('.legend li').length > 3";

#[test]
fn every_page_opens_at_both_widths_and_in_both_schemes_without_an_error() {
    let Some(path) = browser::find() else {
        eprintln!("skipped: there is no Chromium on the path; B2B_BROWSER names one");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &str| {
        let output = b2b(folder.path(), arguments);
        assert!(output.status.success(), "{arguments}: {}", stderr(&output));
    };
    run("run RestaurantFastFood --period 01-01..01-02 --task occupancy --controller random --out b");
    run("run RestaurantFastFood --period 01-01..01-02 --task operate+tou --controller reactive --out d");
    std::fs::write(folder.path().join("t.toml"), TRAINING).unwrap();
    PAGES.iter().for_each(|(arguments, ..)| run(arguments));
    let mut browser = Browser::start(&path, folder.path());
    for (_, page, drawn) in PAGES {
        for (width, dark) in [(400, false), (1280, true)] {
            browser.emulate(width, dark);
            browser.open(&folder.path().join(page), drawn);
            assert_eq!(browser.value("document.documentElement.scrollWidth"), json!(width), "{page}");
            assert_eq!(browser.value(browser::OUTSIDE), json!([]), "{page} at {width} pixels");
            assert_eq!(browser.errors, [""; 0], "{page}");
        }
    }

    // All zones show their targets.
    browser.open(&folder.path().join("a/picture.html"), DRAWN);
    let legend =
        "[...document.querySelectorAll('.legend')[0].querySelectorAll('em')].map(name => name.textContent)";
    assert!(browser.value(legend).to_string().contains("target"), "{}", browser.value(legend));
    // An agent's values are next to the baseline's.
    browser.open(&folder.path().join("c/picture.html"), DRAWN);
    let beside = browser.value("document.querySelectorAll('.tile small').length");
    assert!(beside.as_u64().is_some_and(|count| count >= 10), "{beside}");
    // Several tasks and run periods are rows of one table.
    browser.open(&folder.path().join("several/report.html"), PAGES[8].2);
    let counts = browser.value(
        "['.tile', '.tables table', '.tables tbody tr'].map(what => document.querySelectorAll(what).length)",
    );
    assert_eq!(counts, json!([0, 1, 4]));
    // The result of a training run comes before its curves.
    browser.open(&folder.path().join("t/curve.html"), PAGES[9].2);
    let result = browser.value("document.querySelector('.tile').textContent");
    assert!(result.to_string().contains("resolved score, whole run period"), "{result}");

    // Zones, filters and the list of buildings respond.
    browser.open(&folder.path().join("compare.html"), DRAWN);
    let zones = browser.value("document.querySelector('select').options.length");
    assert_eq!(zones, json!(2));
    browser.value("document.querySelector('#worst tbody tr').click()");
    assert_eq!(browser.value("Math.round((view.to - view.from) / DAY)"), json!(2));
    browser.open(&folder.path().join("dataset.html"), PAGES[2].2);
    assert_eq!(browser.value("shown.length"), json!(6000));
    browser.value("document.querySelectorAll('.types button')[4].click()");
    assert_eq!(browser.value("shown.length"), json!(1000));
    browser.value(
        "filter.limits.set('floor_area', [500, 520]); update(); document.querySelector('tbody tr').click()",
    );
    let chosen = browser.value("document.querySelector('.commands code').textContent");
    assert!(chosen.as_str().unwrap().starts_with("b2b view OfficeSmall-"), "{chosen}");
    let fit = "shown.length > 0 && shown.every(b => value(b, 'floor_area') >= 500 && value(b, 'floor_area') <= 520)";
    assert_eq!(browser.value(fit), json!(true));
    assert_eq!(browser.errors, [""; 0]);
}
