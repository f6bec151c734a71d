//! Portable graymaps (PGM): plain (P2) and binary (P5), of one or two bytes a sample.

use super::Fault;
use super::image::{Image, check_size};

/// Reader of the header and of plain samples: numbers between white space and comments.
struct Words<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl Words<'_> {
    fn number(&mut self) -> Option<usize> {
        loop {
            match self.bytes.get(self.at)? {
                b'#' => {
                    let rest = &self.bytes[self.at..];
                    self.at += rest.iter().position(|b| *b == b'\n' || *b == b'\r')?;
                }
                b if b.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let rest = &self.bytes[self.at..];
        let count = rest.iter().take_while(|b| b.is_ascii_digit()).count();
        self.at += count;
        // More digits than any size or sample has are no number of a graymap.
        if count == 0 || count > 9 { None } else { std::str::from_utf8(&rest[..count]).ok()?.parse().ok() }
    }
}

/// Reads a graymap that begins with `P2` or `P5`.
pub(super) fn read(bytes: &[u8]) -> Result<Image, Fault> {
    let broken = |text: String| Fault::of_image(text, "save the image again, as PGM or PNG");
    let mut words = Words { bytes, at: 2 };
    let header = [words.number(), words.number(), words.number()];
    let [Some(width), Some(height), Some(most)] = header else {
        return Err(broken("its header of width, height and largest value is broken".into()));
    };
    check_size(width, height)?;
    if !(1..=65_535).contains(&most) {
        return Err(broken(format!("its largest value is {most}, and those of a PGM are 1 to 65535")));
    }
    let count = width * height;
    let wide = most > 255;
    let fewer = |found: usize| broken(format!("it ends after {found} of {count} pixels"));
    let mut samples = Vec::with_capacity(count);
    if bytes.starts_with(b"P2") {
        for index in 0..count {
            samples.push(words.number().ok_or_else(|| fewer(index))?);
        }
    } else {
        // One byte of white space ends the header.
        let data = bytes.get(words.at + 1..).unwrap_or_default();
        let size = if wide { 2 } else { 1 };
        if data.len() < count * size {
            return Err(fewer(data.len() / size));
        }
        let sample = |b: &[u8]| b.iter().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
        samples.extend(data.chunks_exact(size).take(count).map(sample));
    }
    if let Some(index) = samples.iter().position(|sample| *sample > most) {
        let text = format!(
            "pixel ({}, {}) is {}, above its largest value {most}",
            index % width,
            index / width,
            samples[index]
        );
        return Err(broken(text));
    }
    let shades = samples.iter().map(|sample| *sample as u16).collect();
    Ok(Image::of_gray(width, height, most as f64, shades))
}
