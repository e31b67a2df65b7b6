//! What a log still tells when its process was killed or its reader went away: on the wall clock and without CAN. What it
//! costs the loop, and what is lost where nothing else competes, is measured in `vcan_recording.rs`.

mod patient_robot;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant, SystemTime};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use uarm::dimensions::RunLog;
use uarm_io::realtime::let_others_go_first;

/// What a killed process may lose at most, beside what the machine kept its writer from running.
const LOSS_LIMIT: Duration = Duration::from_secs(1);

const SEED: u64 = 408;

/// A folder that is removed at the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("uarm-crash-{test}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left behind lies in a temporary folder.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn uarm(arguments: &[&str], log: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_uarm"));
    command.args(arguments).arg(log).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// How long this machine keeps a thread of the writer's niceness from running, at most: the writer itself is kept as long.
struct Starvation {
    longest_ns: Arc<AtomicU64>,
    over: Arc<AtomicBool>,
}

impl Starvation {
    fn watch() -> Self {
        const REST: Duration = Duration::from_millis(2);
        let (longest_ns, over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let watch = Self { longest_ns: Arc::clone(&longest_ns), over: Arc::clone(&over) };
        std::thread::spawn(move || {
            let_others_go_first();
            while !over.load(Ordering::Relaxed) {
                let start = Instant::now();
                std::thread::sleep(REST);
                let late = start.elapsed().saturating_sub(REST);
                longest_ns.fetch_max(u64::try_from(late.as_nanos()).unwrap(), Ordering::Relaxed);
            }
        });
        watch
    }

    fn longest(&self) -> Duration {
        Duration::from_nanos(self.longest_ns.load(Ordering::Relaxed))
    }
}

impl Drop for Starvation {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
    }
}

/// A run in real time that has begun to record.
fn start_recording(folder: &Folder, log: &Path) -> Child {
    let robot = patient_robot::write(&folder.0);
    let child = uarm(&["run", "--hold", "60s", "--robot", robot.to_str().unwrap(), "--log"], log).spawn().unwrap();
    let end = Instant::now() + Duration::from_secs(10);
    while !RunLog::<3, 2>::read(log).is_ok_and(|log| !log.cycles.is_empty()) {
        assert!(Instant::now() < end, "no cycle in {} after 10 s", log.display());
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

#[test]
fn a_killed_run_leaves_all_but_its_last_second() {
    const KILLS: usize = 3;
    const LONGEST: f64 = 1.5;
    let folder = Folder::new("killed");
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let starvation = Starvation::watch();
    for kill in 0..KILLS {
        let file = folder.file(&format!("{kill}.mcap"));
        let mut child = start_recording(&folder, &file);
        let after = Duration::from_secs_f64(random.random_range(0.0..LONGEST));
        std::thread::sleep(after);
        let killed = SystemTime::now();
        child.kill().unwrap();
        child.wait().unwrap();

        let log = RunLog::<3, 2>::read(&file).unwrap();
        let last = Duration::from_nanos(log.run.axis.at(log.cycles.last().unwrap().instants.done));
        let lost = killed.duration_since(SystemTime::UNIX_EPOCH).unwrap().saturating_sub(last);
        let starved = starvation.longest();
        println!(
            "seed {SEED}, kill {kill}: after {after:?}; {} cycles are left, {lost:?} lost; starved for up to {starved:?}",
            log.cycles.len()
        );
        assert!(log.end.is_none(), "the run ended before it was killed: {:?}", log.end);
        assert!(lost <= LOSS_LIMIT + starved, "{lost:?} lost, on a machine that starves for up to {starved:?}");
        assert_eq!((log.cycles[0].tick, log.gaps()), (0, 0));
        let show = uarm(&["show"], &file).output().unwrap();
        assert_eq!(show.status.code(), Some(3), "{}", text(&show));
    }
}

#[test]
fn a_reader_that_goes_away_costs_the_log_and_not_the_run() {
    let folder = Folder::new("closed");
    let pipe = folder.file("run.mcap");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let run = uarm(&["run", "--virtual-time", "--log"], &pipe).spawn().unwrap();
    // More than a run must have written before it begins, and less than all of it.
    let mut first = vec![0; 100_000];
    std::fs::File::open(&pipe).unwrap().read_exact(&mut first).unwrap();
    let output = run.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).contains("1167 cycles") && text(&output).contains("Broken pipe"), "{}", text(&output));
}
