//! MATLAB 5 files as they are and, so that a checksum does not keep the fuzzer out, with all variables in one compressed
//! element.
#![no_main]

use std::io::Write;
use std::sync::LazyLock;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use libfuzzer_sys::fuzz_target;
use terra_data::{ImportKind, Rover, import};
use terra_fuzz::{Scratch, check_import, rovers, run};

static ROVERS: LazyLock<[Rover; 2]> = LazyLock::new(rovers);
static FILE: LazyLock<Scratch> = LazyLock::new(|| Scratch::new("log.mat"));

/// Bytes of a file's header.
const HEADER: usize = 128;
/// Kind of a compressed element, in the order of bytes that this machine has.
const COMPRESSED: u32 = 15;

fn compressed(data: &[u8]) -> Option<Vec<u8>> {
    let (header, variables) = data.split_at_checked(HEADER)?;
    let mut deflate = ZlibEncoder::new(vec![], Compression::fast());
    deflate.write_all(variables).ok()?;
    let body = deflate.finish().ok()?;
    let length = u32::try_from(body.len()).ok()?;
    let tag = [COMPRESSED.to_le_bytes(), length.to_le_bytes()].concat();
    Some([header, &tag, &body].concat())
}

fuzz_target!(|data: &[u8]| run(|| {
    check_import(&import(ImportKind::Mat, FILE.with(data)), &ROVERS[0]);
    if let Some(bytes) = compressed(data) {
        check_import(&import(ImportKind::Mat, FILE.with(&bytes)), &ROVERS[0]);
    }
}));
