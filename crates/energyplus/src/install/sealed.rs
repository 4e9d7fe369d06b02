//! Sealed files: the SHA-256 of the content in hexadecimal, a line feed, and the content. An accidental change is
//! detected when the file is read; a deliberate one that recomputes the digest is not.

use std::path::Path;

use super::package::State;
use b2b_base::digest::sha256;

/// Returns a sealed file with this content.
pub fn seal(content: &[u8]) -> Vec<u8> {
    [sha256(content).as_bytes(), b"\n", content].concat()
}

/// Returns the content of a sealed file; `None` if it was changed or is not sealed.
pub fn unseal(file: &[u8]) -> Option<&[u8]> {
    let line = file.iter().position(|byte| *byte == b'\n')?;
    let (digest, content) = (&file[..line], &file[line + 1..]);
    (sha256(content).as_bytes() == digest).then_some(content)
}

/// Checks every sealed file (`*.json`) of a folder.
pub fn check(folder: &Path) -> State {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let sealed = entries.filter(|path| path.extension().is_some_and(|extension| extension == "json"));
    let (mut files, mut bytes, mut damaged) = (0, 0, Vec::new());
    for path in sealed {
        match std::fs::read(&path) {
            Ok(file) if unseal(&file).is_some() => {
                files += 1;
                bytes += file.len() as u64;
            }
            Ok(_) => damaged.push(format!("{}: it was changed", path.display())),
            // Another process has removed it.
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
            Err(error) => damaged.push(format!("{}: {error}", path.display())),
        }
    }
    State::of_files(files, bytes, damaged)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_changed_byte_breaks_the_seal() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(check(folder.path()), State::Absent);
        let file = seal(b"{\"score\": 1.00}");
        assert_eq!(unseal(&file), Some(&b"{\"score\": 1.00}"[..]));
        let path = folder.path().join("a.json");
        std::fs::write(&path, &file).unwrap();
        assert!(matches!(check(folder.path()), State::Whole { files: 1, .. }));
        for at in 0..file.len() {
            let mut changed = file.clone();
            changed[at] ^= 1;
            assert_eq!(unseal(&changed), None, "byte {at}");
        }
        std::fs::write(&path, &file[..file.len() - 1]).unwrap();
        assert!(matches!(check(folder.path()), State::Damaged(lines) if lines[0].contains("a.json")));
    }
}
