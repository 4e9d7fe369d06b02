//! Exit codes.

/// How a command ended, with its exit code.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(u8)]
pub enum ExitCode {
    /// It did what was asked.
    Success = 0,
    /// It could not, or a check found something wrong.
    Failure = 1,
    /// The arguments are wrong.
    Usage = 2,
    /// It was interrupted: 128 plus SIGINT, by the convention of shells.
    Interrupted = 130,
}

impl ExitCode {
    /// Returns success if `passed`.
    pub(crate) fn of(passed: bool) -> Self {
        if passed { Self::Success } else { Self::Failure }
    }

    /// Returns how a process of this program ended.
    #[cfg(target_os = "linux")]
    pub(crate) fn of_process(code: i32) -> Self {
        let all = [Self::Success, Self::Usage, Self::Interrupted];
        all.into_iter().find(|each| *each as i32 == code).unwrap_or(Self::Failure)
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}
