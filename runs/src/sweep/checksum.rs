//! Checksum of a sweep's file, over every byte except its own, so that the Parquet reader never gets a damaged file.
//!
//! It is stored in the metadata after a mark, which also distinguishes sweeps from other Parquet files.

use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom, Write};

use twox_hash::xxhash3_128::Hasher;

/// Text before the checksum.
const MARK: &str = "hierarq sweep, XXH3-128 ";

/// Number of hexadecimal digits of a checksum.
const DIGITS: usize = 32;

/// Number of bytes after the metadata of a Parquet file: their length, and the magic number.
const END: usize = 8;

/// Maximum size of the metadata (bytes).
const MOST: u64 = 256 << 20;

/// Placeholder in the metadata, until the checksum is known.
pub fn blank() -> String {
    format!("{MARK}{}", "0".repeat(DIGITS))
}

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Seal {
    /// The file is not a Parquet file.
    Foreign,
    /// The file is a Parquet file, but not one of a sweep.
    Unmarked,
    /// The file is one of a sweep, but has changed since it was written.
    Broken,
    /// The file has not changed since it was written.
    Whole,
}

/// Metadata of a file and all bytes after it, with a blank checksum; its offset, the offset of the checksum in it, and
/// the stored checksum.
struct Tail {
    bytes: Vec<u8>,
    from: u64,
    digits: usize,
    said: Vec<u8>,
}

impl Tail {
    fn read(file: &mut File) -> Result<std::result::Result<Tail, Seal>> {
        let length = file.metadata()?.len();
        let mut end = [0; END];
        if length < END as u64 {
            return Ok(Err(Seal::Foreign));
        }
        file.seek(SeekFrom::End(-(END as i64)))?;
        file.read_exact(&mut end)?;
        let [a, b, c, d, word @ ..] = end;
        let size = u64::from(u32::from_le_bytes([a, b, c, d])) + END as u64;
        if word != *b"PAR1" || size > length || size > MOST {
            return Ok(Err(Seal::Foreign));
        }
        let from = length - size;
        file.seek(SeekFrom::Start(from))?;
        let mut bytes = Vec::new();
        file.take(size).read_to_end(&mut bytes)?;
        // The last mark counts, because names of params and expectations precede it.
        let mark = bytes.windows(MARK.len()).rposition(|part| part == MARK.as_bytes());
        let Some(digits) = mark.map(|at| at + MARK.len()).filter(|at| at + DIGITS <= bytes.len()) else {
            return Ok(Err(Seal::Unmarked));
        };
        let said = bytes[digits..digits + DIGITS].to_vec();
        bytes[digits..digits + DIGITS].fill(b'0');
        Ok(Ok(Tail { bytes, from, digits, said }))
    }

    /// Computes the checksum of the file.
    fn sum(&self, file: &mut File) -> Result<String> {
        let mut hasher = Hasher::new();
        file.seek(SeekFrom::Start(0))?;
        let mut rest = file.take(self.from);
        let mut buffer = vec![0; 1 << 16];
        loop {
            match rest.read(&mut buffer)? {
                0 => break,
                n => hasher.write(&buffer[..n]),
            }
        }
        hasher.write(&self.bytes);
        Ok(format!("{:0DIGITS$x}", hasher.finish_128()))
    }
}

/// Writes the checksum into a file that has a [`blank`] one.
///
/// # Errors
/// The file cannot be read or written.
pub fn seal(file: &mut File) -> Result<()> {
    let tail = Tail::read(file)?.map_err(|_| std::io::Error::other("the file has no place for its checksum"))?;
    let sum = tail.sum(file)?;
    file.seek(SeekFrom::Start(tail.from + tail.digits as u64))?;
    file.write_all(sum.as_bytes())
}

/// Checks that a file has not changed since it was written.
///
/// # Errors
/// The file cannot be read.
pub fn check(file: &mut File) -> Result<Seal> {
    let tail = match Tail::read(file)? {
        Ok(tail) => tail,
        Err(seal) => return Ok(seal),
    };
    let whole = tail.sum(file)?.as_bytes() == tail.said;
    file.seek(SeekFrom::Start(0))?;
    Ok(if whole { Seal::Whole } else { Seal::Broken })
}
