//! The file of an HTML page.

use std::path::PathBuf;

/// Parses the path of a page. Errors for another format, which would be written as HTML under a wrong name.
pub fn path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(format) if !["html", "htm"].iter().any(|known| format.eq_ignore_ascii_case(known)) => {
            Err("pages are written as HTML; choose a name that ends in .html".to_owned())
        }
        _ => Ok(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_html_and_no_other_format() {
        for text in ["a.html", "a.HTM", "folder/page", "v1.2/page.html"] {
            assert_eq!(path(text), Ok(PathBuf::from(text)));
        }
        for text in ["x.pdf", "x.png", "x.html.txt"] {
            assert!(path(text).unwrap_err().contains(".html"), "{text}");
        }
    }
}
