//! A folder to export to, and readers that are not ours.

use std::{
    fs,
    io::{Cursor, Read, Seek, SeekFrom, Write},
    path::PathBuf,
    sync::Mutex,
};

use orograph_core::{Context, Host, OutputStream, prelude::*};
use zune_png::{PngDecoder, zune_core::result::DecodingResult};

/// A host with a folder to write to and a record of what it was told.
pub(crate) struct Folder {
    folder: tempfile::TempDir,
    told: Mutex<Vec<String>>,
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), told: Mutex::default() }
    }

    pub(crate) fn job(&self) -> Job<'_> {
        Job::new(self, Context::default())
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.folder.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// The files in the folder.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The last remark that begins so.
    pub(crate) fn told(&self, start: &str) -> String {
        let told = self.told.lock().unwrap();
        told.iter().rev().find(|remark| remark.starts_with(start)).unwrap().clone()
    }
}

impl Host for Folder {
    fn cancelled(&self) -> bool {
        false
    }
    fn progress(&self, _: f64) {}
    fn warn(&self, message: &str) {
        self.told.lock().unwrap().push(message.into());
    }
    fn memory_limit(&self) -> u64 {
        1 << 28
    }
    fn input_path(&self, path: &str) -> Result<PathBuf> {
        Err(Error::reading(path, "nothing is read here"))
    }
    fn create(&self, path: &str) -> Result<Box<dyn OutputStream>> {
        Ok(Box::new(Pending { path: self.folder.path().join(path), bytes: Cursor::default() }))
    }
}

/// A file that appears when it is finished.
struct Pending {
    path: PathBuf,
    bytes: Cursor<Vec<u8>>,
}

impl Write for Pending {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.bytes.write(bytes)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Pending {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.bytes.seek(to)
    }
}

impl OutputStream for Pending {
    fn finish(self: Box<Self>) -> Result<()> {
        fs::create_dir_all(self.path.parent().unwrap()).unwrap();
        fs::write(&self.path, self.bytes.get_ref()).unwrap();
        Ok(())
    }
}

/// Width, height and samples of a PNG picture.
pub(crate) fn png(bytes: &[u8]) -> ((usize, usize), DecodingResult) {
    let mut decoder = PngDecoder::new(Cursor::new(bytes));
    let samples = decoder.decode().unwrap();
    (decoder.dimensions().unwrap(), samples)
}

/// Width and samples of an OpenEXR picture as the *OpenEXR File Layout* describes it: one part in scan lines, one
/// channel of 32-bit floats, zip-packed 16 lines at a time.
pub(crate) fn exr_channel(bytes: &[u8]) -> (usize, Vec<f32>) {
    let int = |at: usize| i32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!((int(0), int(4)), (20_000_630, 2), "magic number, version 2 without flags");
    let mut at = 8;
    let (mut width, mut lines) = (0, 0);
    loop {
        let word = |at: &mut usize| {
            let start = *at;
            *at = start + bytes[start..].iter().position(|&byte| byte == 0).unwrap() + 1;
            String::from_utf8(bytes[start..*at - 1].to_vec()).unwrap()
        };
        let name = word(&mut at);
        if name.is_empty() {
            break;
        }
        let _kind = word(&mut at);
        let (size, value) = (int(at) as usize, at + 4);
        match name.as_str() {
            // A name, its end, and the type: 2 is 32-bit floating point.
            "channels" => assert_eq!((&bytes[value..value + 2], int(value + 2)), (&b"Y\0"[..], 2)),
            // 3 is zip, 16 lines at a time.
            "compression" => assert_eq!(bytes[value], 3),
            "dataWindow" => {
                assert_eq!((int(value), int(value + 4)), (0, 0));
                (width, lines) = (int(value + 8) as usize + 1, int(value + 12) as usize + 1);
            }
            _ => {}
        }
        at = value + size;
    }
    let mut samples = Vec::new();
    for block in 0..lines.div_ceil(16) {
        let offset = i64::from(int(at + block * 8)) as usize;
        assert_eq!(int(offset) as usize, block * 16, "blocks tell their first line");
        let packed = &bytes[offset + 8..][..int(offset + 4) as usize];
        let wanted = width * (lines - block * 16).min(16) * 4;
        let mut plain = packed.to_vec();
        // What does not shrink is left as it is.
        if packed.len() < wanted {
            let mut unpacked = Vec::new();
            flate2::read::ZlibDecoder::new(packed).read_to_end(&mut unpacked).unwrap();
            // Each byte was told by its difference from the one before, and even ones stand before odd ones.
            for i in 1..unpacked.len() {
                unpacked[i] = unpacked[i].wrapping_add(unpacked[i - 1]).wrapping_sub(128);
            }
            let half = unpacked.len().div_ceil(2);
            plain = (0..unpacked.len())
                .map(|i| unpacked[if i % 2 == 0 { i / 2 } else { half + i / 2 }])
                .collect();
        }
        assert_eq!(plain.len(), wanted);
        samples.extend(plain.as_chunks::<4>().0.iter().map(|&quad| f32::from_le_bytes(quad)));
    }
    (width, samples)
}
