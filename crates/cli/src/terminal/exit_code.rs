//! Exit codes.

/// The outcome of a command, with its exit code.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub enum ExitCode {
    /// The command succeeded.
    Success = 0,
    /// The command failed, or a check found a problem.
    Failure = 1,
    /// The arguments are invalid.
    Usage = 2,
    /// The command was interrupted: 128 plus SIGINT, by the convention of shells.
    Interrupted = 130,
}

impl ExitCode {
    /// Returns success if `passed`, else failure.
    pub(crate) fn of(passed: bool) -> Self {
        if passed { Self::Success } else { Self::Failure }
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}
