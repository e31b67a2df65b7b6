//! Lists the objects of an EDS or DCF file, and what in it cannot be read.

use std::process::ExitCode;
use uarm_eds::Dictionary;

/// A dictionary to show without a file.
const SAMPLE: &[u8] = b"[1000]\nParameterName=Device type\nDataType=0x0007\nAccessType=const\nDefaultValue=0x20192\n";

fn main() -> ExitCode {
    let dictionary = match std::env::args().nth(1) {
        Some(file) => match std::fs::read(&file) {
            Ok(bytes) => Dictionary::parse(&file, &bytes),
            Err(error) => {
                eprintln!("{file}: {error}");
                return ExitCode::FAILURE;
            }
        },
        None => Dictionary::parse("sample", SAMPLE),
    };
    match dictionary {
        Ok(dictionary) => {
            for object in dictionary.objects() {
                let (index, subindex) = (object.address.index, object.address.subindex);
                println!("{index:04X}:{subindex:02X} {} {:?} {:?}", object.name, object.access, object.value(1));
            }
            for problem in dictionary.problems() {
                eprintln!("{problem}");
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
