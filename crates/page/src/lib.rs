//! Self-contained pages that need no network: templates with their data, one style and, for charts, plotly.

use std::io::Write;
use std::sync::LazyLock;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::GzEncoder;
use plotly::Plot;
use serde_json::Value;

const PAGE: &str = include_str!("report.html");
/// The style that all pages share.
const STYLE: &str = include_str!("look.css");
/// The script that pages share: their data, and functions for elements and colors.
const SCRIPT: &str = include_str!("page.js");

/// Marks in a template.
const PLOTLY: &str = "{{PLOTLY}}";
const LOOK: &str = "{{LOOK}}";
const PAGE_SCRIPT: &str = "{{PAGE}}";
const DATA: &str = "{{DATA}}";

/// The script that unpacks plotly.
const UNPACK: &str = include_str!("unpack.js");
/// The script of plotly, compressed once per process.
static PLOTLY_SCRIPT: LazyLock<String> = LazyLock::new(plotly_script);

/// Writes the page of a report.
pub fn write_page(file: &mut impl Write, data: &Value) -> std::io::Result<()> {
    file.write_all(fill(PAGE, data).as_bytes())
}

/// Returns a template filled with its data, inserted as JSON in a script element, with the shared style and, where it
/// has marks for them, plotly's script and the shared script.
pub fn fill(template: &str, data: &Value) -> String {
    let page = if template.contains(PLOTLY) {
        template.replace(PLOTLY, &PLOTLY_SCRIPT)
    } else {
        template.to_owned()
    };
    let page = page.replace(LOOK, STYLE).replace(PAGE_SCRIPT, SCRIPT);
    // An unescaped `<` in a name could end the script element.
    page.replace(DATA, &data.to_string().replace('<', "\\u003c"))
}

/// Returns plotly's script, compressed to less than half its size, with the script that unpacks it. Charts are drawn
/// once the promise `plotlyReady` resolves.
fn plotly_script() -> String {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    // Writing to memory never fails.
    let packed = encoder.write_all(plotly_source().as_bytes()).and_then(|()| encoder.finish());
    let packed = BASE64_STANDARD.encode(packed.unwrap_or_default());
    format!("<script type=\"text/plain\" id=\"plotly\">{packed}</script>\n<script>\n{UNPACK}</script>")
}

/// Returns the source of plotly, without the part for formulas, which reports do not contain.
fn plotly_source() -> String {
    let scripts = Plot::offline_js_sources();
    let start = scripts.find('>').map_or(0, |at| at + 1);
    let end = scripts.find("</script>").unwrap_or(scripts.len());
    scripts[start..end].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_needs_no_network() {
        for mark in [DATA, PLOTLY, LOOK, PAGE_SCRIPT] {
            assert_eq!(PAGE.matches(mark).count(), 1);
        }
        for word in ["http://", "https://", "src=", "@import", "<link"] {
            assert!(!PAGE.contains(word) && !SCRIPT.contains(word), "{word}");
        }
    }

    #[test]
    fn a_page_embeds_plotly_compressed() {
        let script = plotly_script();
        assert!(script.starts_with("<script") && script.ends_with("</script>"));
        assert_eq!(script.matches("</script>").count(), 2);
        assert!((500_000..2_200_000).contains(&script.len()), "{}", script.len());
        let source = plotly_source();
        assert!(source.contains("mesh3d") && !source.contains("<script") && source.len() > 1_000_000);
    }

    #[test]
    fn data_cannot_end_its_script_element() {
        let page = fill("<script>{{DATA}}</script>", &Value::from("</script>"));
        assert_eq!(page, "<script>\"\\u003c/script>\"</script>");
    }
}
