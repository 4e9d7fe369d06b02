//! The page that reports are embedded in.

use std::io::Write;

use plotly::Plot;
use serde_json::Value;

const PAGE: &str = include_str!("report.html");

/// Writes the page with its data.
pub(super) fn write_page(file: &mut impl Write, data: &Value) -> std::io::Result<()> {
    // An unescaped `<` in a name could end the script element.
    let data = data.to_string().replace('<', "\\u003c");
    file.write_all(PAGE.replace("{{PLOTLY}}", &plotly_script()).replace("{{DATA}}", &data).as_bytes())
}

/// Returns the script element of plotly, without the one for formulas, which reports do not contain.
fn plotly_script() -> String {
    const END: &str = "</script>";
    let scripts = Plot::offline_js_sources();
    let end = scripts.find(END).map_or(scripts.len(), |at| at + END.len());
    scripts[..end].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_no_network() {
        for mark in ["{{DATA}}", "{{PLOTLY}}"] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.matches("</script>").count() == 1);
    }
}
