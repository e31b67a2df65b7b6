//! A dictionary of a drive is read without a panic, whatever its bytes; and each of its objects can be asked for its value.
#![no_main]

use libfuzzer_sys::fuzz_target;
use uarm_eds::Dictionary;

fuzz_target!(|bytes: &[u8]| {
    let Ok(dictionary) = Dictionary::parse("fuzzed.eds", bytes) else { return };
    for object in dictionary.objects() {
        for node in [0, 127] {
            let _ = object.limits(node);
            let _ = object.value(node).and_then(|value| value.to_wire(object.kind));
        }
    }
});
