//! The page that reports are embedded in.

use std::io::Write;

use plotly::Plot;
use serde_json::Value;

const PAGE: &str = include_str!("report.html");

/// Marks in a template.
const PLOTLY: &str = "{{PLOTLY}}";
const DATA: &str = "{{DATA}}";

/// Writes the page of a report.
pub fn write_page(file: &mut impl Write, data: &Value) -> std::io::Result<()> {
    file.write_all(fill(PAGE, data).as_bytes())
}

/// Returns a template with its data, a script element's JSON, and with plotly's script if it has a place for it.
pub fn fill(template: &str, data: &Value) -> String {
    let page = if template.contains(PLOTLY) {
        template.replace(PLOTLY, &plotly_script())
    } else {
        template.to_owned()
    };
    // An unescaped `<` in a name could end the script element.
    page.replace(DATA, &data.to_string().replace('<', "\\u003c"))
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
        for mark in [DATA, PLOTLY] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word), "{word}");
        }
    }

    #[test]
    fn a_page_embeds_plotly_as_one_script() {
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.ends_with("</script>"));
        assert_eq!(script.matches("</script>").count(), 1);
        assert!(script.contains("mesh3d") && script.len() > 1_000_000);
    }

    #[test]
    fn data_cannot_end_its_script_element() {
        let page = fill("<script>{{DATA}}</script>", &Value::from("</script>"));
        assert_eq!(page, "<script>\"\\u003c/script>\"</script>");
    }
}
