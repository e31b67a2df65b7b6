//! Where the thread runs, and how deeply processors may sleep.

use crate::finding::{Finding, Verdict};
use core::fmt;
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use std::fs::{File, OpenOptions};
use std::io::{self, Write as _};

/// A processor by the number that Linux gives it, 0 to [`Processor::LAST`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Processor(usize);

/// A number beyond the last processor that Linux can name.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
#[error("{found} is not the number of a processor: expected 0 to {last}", last = Processor::LAST)]
pub struct ProcessorError {
    found: usize,
}

impl Processor {
    /// The largest number that the system call's set of processors holds.
    pub const LAST: usize = CpuSet::MAX_CPU - 1;

    /// The processor with this number, whether the machine has it or not.
    ///
    /// # Errors
    /// If the number is beyond [`Processor::LAST`].
    pub const fn new(number: usize) -> Result<Self, ProcessorError> {
        if number <= Self::LAST { Ok(Self(number)) } else { Err(ProcessorError { found: number }) }
    }

    /// The number that Linux gives the processor.
    pub const fn number(self) -> usize {
        self.0
    }
}

impl fmt::Display for Processor {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.0, formatter)
    }
}

impl core::str::FromStr for Processor {
    type Err = Box<dyn std::error::Error + Send + Sync>;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self::new(text.parse()?)?)
    }
}

/// The thread bound to one processor; given back when dropped.
#[derive(Debug)]
pub(super) struct Binding {
    before: CpuSet,
}

impl Binding {
    pub(super) fn to(processor: Processor) -> (Option<Self>, Finding) {
        let finding = |found: String| Finding::good(format!("thread on processor {processor}"), found, "bound");
        let mut wanted = CpuSet::new();
        wanted.set(processor.number());
        let bound =
            sched_getaffinity(None).and_then(|before| sched_setaffinity(None, &wanted).map(|()| Self { before }));
        match bound {
            Ok(binding) => (Some(binding), finding("bound".to_owned())),
            Err(errno) => {
                let advice =
                    "choose one of `cat /sys/devices/system/cpu/online`, and one that a container or `taskset` allows";
                (None, finding(format!("not bound: {errno}")).but(Verdict::Bad, advice))
            }
        }
    }
}

impl Drop for Binding {
    fn drop(&mut self) {
        // Best effort: the thread ends soon, and no one could act on a failure here.
        let _ = sched_setaffinity(None, &self.before);
    }
}

/// Processors kept awake: the kernel honours the wish as long as the file is open.
#[derive(Debug)]
pub(super) struct Awake {
    _request: File,
}

impl Awake {
    const DEVICE: &str = "/dev/cpu_dma_latency";
    /// The longest wake-up of a sleeping processor that is acceptable, microseconds, as the device takes it.
    const LATENCY: i32 = 0;

    pub(super) fn hold() -> (Option<Self>, Finding) {
        let finding = |found: String| Finding::good("deep sleep kept off", found, "0 µs by /dev/cpu_dma_latency");
        match Self::request() {
            Ok(request) => (Some(Self { _request: request }), finding("0 µs".to_owned())),
            Err(error) => {
                let advice = "run as root, or give your group the device: a udev rule `KERNEL==\"cpu_dma_latency\", GROUP=\"realtime\", MODE=\"0660\"`";
                (None, finding(format!("not held: {error}")).but(Verdict::Warning, advice))
            }
        }
    }

    fn request() -> io::Result<File> {
        let mut file = OpenOptions::new().write(true).open(Self::DEVICE)?;
        file.write_all(&Self::LATENCY.to_ne_bytes())?;
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_binding_holds_until_dropped() {
        std::thread::spawn(|| {
            let before = sched_getaffinity(None).unwrap();
            let allowed = (0..=Processor::LAST).find(|&number| before.is_set(number)).unwrap();
            let (binding, finding) = Binding::to(Processor::new(allowed).unwrap());
            assert_eq!(finding.verdict, Verdict::Good, "{finding}");
            let during = sched_getaffinity(None).unwrap();
            assert!(during.is_set(allowed) && during.count() == 1);
            drop(binding);
            assert_eq!(sched_getaffinity(None).unwrap(), before);
        })
        .join()
        .unwrap();
    }

    #[test]
    fn numbers_beyond_the_set_are_refused() {
        assert!(Processor::new(Processor::LAST + 1).unwrap_err().to_string().contains("1024"));
        assert_eq!("3".parse::<Processor>().unwrap().number(), 3);
        assert!("1024".parse::<Processor>().is_err() && "x".parse::<Processor>().is_err());
    }
}
