//! Logs with damaged length fields: what is whole is shown, in bounded memory.

mod support;

use std::path::PathBuf;
use std::process::{Command, Output};

use mcap::records::op;
use serde_json::Value;
use support::{standard_output, text};

/// Address space of the reading process, KiB: 1 GiB.
const MEMORY_KIB: u32 = 1024 * 1024;
/// A chunk has at most a quarter of a second, 84 cycles.
const CYCLES_OF_A_CHUNK: u64 = 84;

/// A folder of one test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = support::scratch(&format!("damaged-{name}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// The log of the paper's task, 1167 cycles.
fn recorded(folder: &std::path::Path) -> Vec<u8> {
    let log = folder.join("run.mcap");
    standard_output(&["run", "--virtual-time", "--log", log.to_str().unwrap()]);
    std::fs::read(log).unwrap()
}

/// Runs `uarm` with little memory.
fn bounded(arguments: &[&str]) -> Output {
    let script = format!("ulimit -v {MEMORY_KIB} && exec \"$0\" \"$@\"");
    Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_uarm")]).args(arguments).output().unwrap()
}

/// A length in a file: where it stands, how many bytes it has, and in what kind of record.
struct Length {
    at: usize,
    bytes: usize,
    opcode: u8,
}

/// The first lengths of each kind of record: its own, and those of its strings, maps and data.
fn lengths(file: &[u8]) -> Vec<Length> {
    let mut lengths = Vec::new();
    let mut records_of_kind = [0; 256];
    let mut at = 8;
    while at + 9 < file.len() {
        let opcode = file[at];
        let length = usize::try_from(u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap())).unwrap();
        records_of_kind[usize::from(opcode)] += 1;
        // In the middle of the file, as well as at its beginning.
        if [1, 3].contains(&records_of_kind[usize::from(opcode)]) {
            let body = at + 9;
            let mut push = |at, bytes| lengths.push(Length { at, bytes, opcode });
            push(at + 1, 8);
            match opcode {
                op::CHUNK => {
                    push(body + 16, 8);
                    push(body + 28, 4);
                    push(body + 36, 8);
                }
                op::HEADER | op::METADATA => push(body, 4),
                op::SCHEMA | op::MESSAGE_INDEX => push(body + 2, 4),
                op::CHANNEL => push(body + 4, 4),
                op::CHUNK_INDEX => push(body + 32, 4),
                op::ATTACHMENT | op::METADATA_INDEX => push(body + 16, 4),
                op::ATTACHMENT_INDEX => push(body + 40, 4),
                op::STATISTICS => push(body + 42, 4),
                _ => {}
            }
        }
        at += 9 + length;
    }
    lengths
}

#[test]
fn a_damaged_length_costs_its_own_record_and_no_memory() {
    let folder = folder("lengths");
    let whole = recorded(&folder);
    let lengths = lengths(&whole);
    let kinds: std::collections::BTreeSet<_> = lengths.iter().map(|length| length.opcode).collect();
    assert!(kinds.len() >= 13, "{kinds:?}");
    let path = folder.join("damaged.mcap");
    for Length { at, bytes, opcode } in lengths {
        // 3.5 GB, and 50 MB that could be.
        for value in [3_478_540_441_u64, 50_000_000] {
            let mut damaged = whole.clone();
            damaged[at..at + bytes].copy_from_slice(&value.to_le_bytes()[..bytes]);
            std::fs::write(&path, &damaged).unwrap();
            let output = bounded(&["show", path.to_str().unwrap(), "--json"]);
            let case = format!("record {opcode:02X}h, {bytes} bytes at {at}: {value}");
            // Without the description of the run nothing can be told.
            if opcode == op::METADATA && output.status.code() == Some(1) {
                assert!(text(&output).contains("not a run log"), "{case}: {}", text(&output));
                continue;
            }
            assert_eq!(output.status.code(), Some(3), "{case}: {}", text(&output));
            let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
            let cycles = summary["contents"]["cycles"].as_u64().unwrap();
            let lost = if opcode == op::CHUNK { CYCLES_OF_A_CHUNK } else { 0 };
            assert!(cycles >= 1167 - lost, "{case}: {cycles} cycles");
        }
    }
}

#[test]
fn each_command_that_reads_a_log_goes_on_in_bounded_memory() {
    let folder = folder("commands");
    let mut damaged = recorded(&folder);
    // The last record but three has a string: the index of the metadata, in the summary.
    let length = lengths(&damaged).into_iter().rfind(|length| length.opcode == op::METADATA_INDEX).unwrap();
    damaged[length.at..length.at + length.bytes].fill(0xCF);
    let path = folder.join("damaged.mcap");
    std::fs::write(&path, damaged).unwrap();
    let path = path.to_str().unwrap();
    for (arguments, code, part) in [
        (&["show", path][..], 3, "metadata index: name claims 3486502863 bytes"),
        (&["replay", path], 3, "metadata index: name claims"),
        (&["monitor", "--once", path], 3, "completed"),
        (&["train", path, "--controller", "nonlinear"], 1, "metadata index: name claims"),
    ] {
        let output = bounded(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", text(&output));
        assert!(text(&output).contains(part), "{arguments:?}: {}", text(&output));
    }
}

/// Nothing is said of what the log does not hold.
#[test]
fn a_log_without_cycles_has_no_index_and_no_verdict() {
    let folder = folder("no-cycles");
    let whole = recorded(&folder);
    let mut damaged = whole.clone();
    // Bytes of each chunk's records.
    let mut at = 8;
    while at + 9 < damaged.len() {
        let length = usize::try_from(u64::from_le_bytes(damaged[at + 1..at + 9].try_into().unwrap())).unwrap();
        if damaged[at] == op::CHUNK {
            damaged[at + 9 + length - 20] ^= 0xFF;
        }
        at += 9 + length;
    }
    let path = folder.join("damaged.mcap");
    std::fs::write(&path, damaged).unwrap();
    let output = bounded(&["show", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let told = text(&output);
    for part in ["L2", "paper", "verdict", "deadlines missed", "error at the end", "peak torque"] {
        assert!(!told.contains(part), "{part}: {told}");
    }
    assert!(told.contains("no cycle") && told.contains("1167 of 1167 cycles are not in the log"), "{told}");
    let output = bounded(&["show", path.to_str().unwrap(), "--json"]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&summary["report"]["indices"], &summary["report"]["timing_verdict"]), (&Value::Null, &Value::Null));
}

#[test]
fn a_run_that_was_cut_is_not_compared_with_the_papers() {
    let folder = folder("cut");
    let whole = recorded(&folder);
    let path = folder.join("cut.mcap");
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let output = bounded(&["show", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(3));
    let told = text(&output);
    assert!(told.contains(" s of 3 s: not comparable"), "{told}");
    assert!(!told.contains(" paper ") && !told.contains(" ratio "), "{told}");
}

/// As other tools pack logs anew.
#[test]
fn chunks_packed_with_lz4_and_unpacked_ones_are_read() {
    let folder = folder("packed");
    let whole = recorded(&folder);
    let plain = repacked(&whole, |records| (String::new(), records.to_vec()));
    let lz4 = repacked(&whole, |records| ("lz4".to_owned(), lz4_frame(records)));
    let path = folder.join("packed.mcap");
    let run = standard_output(&["show", folder.join("run.mcap").to_str().unwrap(), "--csv", "-"]);
    for file in [plain, lz4] {
        std::fs::write(&path, file).unwrap();
        assert!(standard_output(&["show", path.to_str().unwrap(), "--csv", "-"]) == run);
    }
}

/// An LZ4 frame of stored blocks, as its specification has them: the format's writer is not under test.
fn lz4_frame(data: &[u8]) -> Vec<u8> {
    const BLOCK: usize = 64 * 1024;
    let mut frame = vec![0x04, 0x22, 0x4D, 0x18, 0x60, 0x40, 0x82];
    for block in data.chunks(BLOCK) {
        frame.extend((u32::try_from(block.len()).unwrap() | 1 << 31).to_le_bytes());
        frame.extend(block);
    }
    frame.extend([0; 4]);
    frame
}

/// A file with its chunks packed in another way, without summary and checksums.
fn repacked(file: &[u8], pack: impl Fn(&[u8]) -> (String, Vec<u8>)) -> Vec<u8> {
    let mut repacked = file[..8].to_vec();
    let mut at = 8;
    while at + 9 < file.len() {
        let length = usize::try_from(u64::from_le_bytes(file[at + 1..at + 9].try_into().unwrap())).unwrap();
        let (opcode, body) = (file[at], &file[at + 9..at + 9 + length]);
        at += 9 + length;
        let body = match opcode {
            op::CHUNK => {
                let mcap::records::Record::Chunk { header, data } = mcap::parse_record(opcode, body).unwrap() else {
                    panic!()
                };
                let records = zstd::decode_all(&*data).unwrap();
                let (compression, packed) = pack(&records);
                let name = u32::try_from(compression.len()).unwrap();
                [
                    &body[..24],
                    &header.uncompressed_crc.to_le_bytes(),
                    &name.to_le_bytes(),
                    compression.as_bytes(),
                    &u64::try_from(packed.len()).unwrap().to_le_bytes(),
                    &packed,
                ]
                .concat()
            }
            op::DATA_END => vec![0; 4],
            op::FOOTER => vec![0; 20],
            op::HEADER | op::ATTACHMENT | op::METADATA => body.to_vec(),
            _ => continue,
        };
        repacked.push(opcode);
        repacked.extend(u64::try_from(body.len()).unwrap().to_le_bytes());
        repacked.extend(body);
    }
    repacked.extend(&file[..8]);
    repacked
}

#[test]
fn what_is_no_log_is_named_and_takes_neither_memory_nor_time() {
    let folder = folder("none");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (pipe, huge, words) = (path("pipe"), path("huge.mcap"), path("words"));
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // Zeros without end, as far as a reader can see; a file system keeps none of them.
    std::fs::File::create(&huge).unwrap().set_len(1 << 40).unwrap();
    std::fs::write(&words, b"hello, \xff these are words").unwrap();
    for (file, reason) in [
        ("/dev/zero", "is a device, expected a file"),
        (&pipe, "is a pipe, expected a file"),
        ("/", "is a folder, expected a file"),
    ] {
        for command in [&["show"][..], &["replay", "--controller", "nonlinear"], &["train"], &["monitor", "--once"]] {
            let output = bounded(&[command, &[file]].concat());
            assert_eq!(output.status.code(), Some(1), "{command:?} {file}: {}", text(&output));
            assert!(text(&output).contains(&format!("{file}: ")), "{command:?} {file}: {}", text(&output));
            assert!(text(&output).contains(reason), "{command:?} {file}: {}", text(&output));
        }
    }
    for file in [&huge, &words] {
        for command in [&["show"][..], &["replay", "--controller", "nonlinear"], &["train"], &["monitor", "--once"]] {
            let output = bounded(&[command, &[file]].concat());
            assert_eq!(output.status.code(), Some(1), "{command:?} {file}: {}", text(&output));
            assert!(text(&output).contains(file.as_str()), "{command:?} {file}: {}", text(&output));
        }
    }
    let output = bounded(&["run", "--virtual-time", "--log", "none", "--robot", "/dev/zero"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output).contains("/dev/zero: cannot be read: is a device, expected a file"), "{}", text(&output));
}
