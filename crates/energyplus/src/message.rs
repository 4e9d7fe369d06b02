//! Messages of EnergyPlus.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Information.
    Info,
    /// Warning; the run continues.
    Warning,
    /// Severe error; the run may continue.
    Severe,
    /// Fatal error; the run ends.
    Fatal,
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Level::Info => "info",
            Level::Warning => "warning",
            Level::Severe => "severe",
            Level::Fatal => "fatal",
        })
    }
}

/// A message with its continuation lines.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Message {
    /// Severity.
    pub level: Level,
    /// Text, lines joined by newlines.
    pub text: String,
}

/// The messages of a run: the count per level, and the first texts. A run may repeat a message for months, so the
/// number of texts is bounded.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Messages {
    kept: Vec<Message>,
    counts: [usize; 4],
    /// Whether continuation lines belong to the last kept message.
    last_was_kept: bool,
    /// Last lines of standard output, for failures reported nowhere else.
    console: Vec<String>,
}

/// Number of texts kept per level.
const KEPT_PER_LEVEL: usize = 100;
/// Length of a message beyond which continuation lines are dropped, bytes.
const KEPT_BYTES: usize = 4000;
/// Length beyond which a line is cut, bytes: EnergyPlus repeats a wrong value in full.
const KEPT_LINE: usize = 400;
/// Number of last warnings shown before a fatal message.
const EXPLAINING: usize = 3;
/// Number of warnings about nodes without a setpoint shown before a fatal message.
const NODES: usize = 12;
/// Number of console lines kept.
const CONSOLE_LINES: usize = 20;

impl Messages {
    /// Returns the number of messages of a level.
    pub fn count(&self, level: Level) -> usize {
        self.counts[level as usize]
    }

    /// Returns the kept messages in order.
    pub fn iter(&self) -> impl Iterator<Item = &Message> {
        self.kept.iter()
    }

    /// Returns the kept messages of at least this level.
    pub fn at_least(&self, level: Level) -> impl Iterator<Item = &Message> {
        self.kept.iter().filter(move |m| m.level >= level)
    }

    /// Adds a line of the error callback. Level 0 continues the previous message.
    pub(crate) fn push(&mut self, level: i32, text: &str) {
        let level = match level {
            1 => Level::Info,
            2 => Level::Warning,
            3 => Level::Severe,
            4 => Level::Fatal,
            _ => return self.continue_last(text),
        };
        self.counts[level as usize] += 1;
        let is_kept = |number: usize| number <= KEPT_PER_LEVEL;
        self.last_was_kept =
            is_kept(self.count(level)) || is_about_setpoint(text) && is_kept(self.about_setpoints());
        if self.last_was_kept {
            self.kept.push(Message { level, text: cut(text) });
        }
    }

    /// Adds a line of standard output.
    pub(crate) fn push_console(&mut self, line: &str) {
        if self.console.len() == CONSOLE_LINES {
            self.console.remove(0);
        }
        self.console.push(cut(line));
    }

    /// Returns the positions of the warnings that explain the first fatal message: the last ones before it, and those
    /// about nodes without a setpoint.
    fn explaining(&self) -> Vec<usize> {
        let fatal = self.kept.iter().position(|message| message.level == Level::Fatal).unwrap_or(0);
        let is_warning = |i: &usize| self.kept[*i].level == Level::Warning;
        let last = (0..fatal).rev().filter(is_warning).take(EXPLAINING);
        let names_node = |i: &usize| is_warning(i) && is_about_setpoint(&self.kept[*i].text);
        last.chain((0..fatal).filter(names_node).take(NODES)).collect()
    }

    /// Returns the number of kept messages about nodes without a setpoint.
    fn about_setpoints(&self) -> usize {
        self.kept.iter().filter(|message| is_about_setpoint(&message.text)).count()
    }

    fn continue_last(&mut self, text: &str) {
        if let (true, Some(last)) = (self.last_was_kept, self.kept.last_mut())
            && last.text.len() < KEPT_BYTES
        {
            last.text.push('\n');
            last.text.push_str(&cut(text));
        }
    }
}

/// Returns whether a warning names a node without a setpoint, such as `Missing 'Humidity Ratio Setpoint' for node named
/// 'X'`. The fatal message that follows does not name the node.
fn is_about_setpoint(text: &str) -> bool {
    text.trim_start().starts_with("Missing '") && text.contains("' for node")
}

/// Returns a line without blanks at its ends, cut where it is too long.
fn cut(line: &str) -> String {
    let line = line.trim();
    let end = line.floor_char_boundary(KEPT_LINE);
    if end == line.len() { line.to_owned() } else { format!("{} …", &line[..end]) }
}

/// The same as [`fmt::Display`], so that the panic message of an `unwrap` is readable.
impl fmt::Debug for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}")
    }
}

/// Severe and fatal messages, each once, and the last warnings before a fatal one, which often explain it; if there are
/// none, the last lines of standard output.
impl fmt::Display for Messages {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut distinct: Vec<(&Message, usize)> = Vec::new();
        let explaining = self.explaining();
        let is_shown =
            |(i, message): &(usize, &Message)| message.level >= Level::Severe || explaining.contains(i);
        for (_, message) in self.kept.iter().enumerate().filter(is_shown) {
            match distinct.iter_mut().find(|(known, _)| *known == message) {
                Some((_, times)) => *times += 1,
                None => distinct.push((message, 1)),
            }
        }
        if distinct.is_empty() {
            return f.write_str(&self.console.join("\n"));
        }
        for (i, (Message { level, text }, times)) in distinct.into_iter().enumerate() {
            let start = if i > 0 { "\n" } else { "" };
            let repeated = if times > 1 { format!(" ({times} times)") } else { String::new() };
            write!(f, "{start}  {level}{repeated}: {}", text.replace('\n', "\n    "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn continuation_lines_join_their_message() {
        let mut messages = Messages::default();
        messages.push(3, " Zone is cold ");
        messages.push(0, "...at noon");
        let kept: Vec<_> = messages.iter().collect();
        assert_eq!(kept.len(), 1);
        assert_eq!(kept[0].text, "Zone is cold\n...at noon");
        assert_eq!(messages.count(Level::Severe), 1);
    }

    #[test]
    fn repeated_messages_are_written_once() {
        let mut messages = Messages::default();
        for zone in ["North", "South", "North"] {
            messages.push(3, zone);
            messages.push(0, "is cold");
        }
        messages.push(4, "ends");
        let text = "  severe (2 times): North\n    is cold\n  severe: South\n    is cold\n  fatal: ends";
        assert_eq!(messages.to_string(), text);
    }

    #[test]
    fn the_last_warnings_before_a_fatal_message_are_shown() {
        let mut messages = Messages::default();
        for node in ["A", "B", "C", "D"] {
            messages.push(2, node);
        }
        assert_eq!(messages.to_string(), "");
        messages.push(4, "no setpoint");
        messages.push(2, "E");
        assert_eq!(messages.to_string(), "  warning: B\n  warning: C\n  warning: D\n  fatal: no setpoint");
    }

    #[test]
    fn nodes_without_a_setpoint_are_shown_before_a_fatal_message_however_many_warnings_there_are() {
        let mut messages = Messages::default();
        (0..200).for_each(|_| messages.push(2, "iteration limit"));
        for node in 1..=4 {
            messages.push(2, &format!("Missing 'Humidity Ratio Setpoint' for node named '{node}'."));
        }
        messages.push(4, "At least one node does not have a setpoint attached");
        let text = messages.to_string();
        assert!((1..=4).all(|node| text.contains(&format!("named '{node}'"))), "{text}");
    }

    #[test]
    fn a_message_repeated_for_months_is_counted_but_kept_a_bounded_number_of_times() {
        let mut messages = Messages::default();
        for _ in 0..10_000 {
            messages.push(2, "iteration limit");
            messages.push(0, "...again");
        }
        assert_eq!(messages.count(Level::Warning), 10_000);
        assert_eq!(messages.iter().count(), KEPT_PER_LEVEL);
    }
}
