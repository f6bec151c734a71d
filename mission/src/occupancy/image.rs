//! Images of occupancy maps: PGM, and PNG of any colour type and depth.

use std::io::Cursor;

use super::grid::MAX_CELLS;
use super::{Fault, pgm};

/// The largest file of an image, in bytes.
pub const MAX_IMAGE_BYTES: u64 = 64 << 20;

/// Brightness of a pixel, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Mean of its colours: 0 is black.
    pub shade: f64,
    /// Opacity, if the image has one.
    pub alpha: Option<f64>,
}

/// An image.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Samples of a pixel: colours, and then alpha.
    channels: usize,
    /// Largest sample.
    most: f64,
    /// Samples, row by row from the top.
    samples: Vec<u16>,
}

impl Image {
    /// Reads a file.
    ///
    /// # Errors
    /// It is no image of a known form, broken, or too large.
    pub fn read(bytes: &[u8]) -> Result<Image, Fault> {
        match bytes {
            [b'P', b'2' | b'5', ..] => pgm::read(bytes),
            [0x89, b'P', b'N', b'G', ..] => read_png(bytes),
            [] => Err(Fault::of_image("it is empty", "save the image again, as PGM or PNG")),
            _ => Err(Fault::of_image("it is neither a PGM (P2 or P5) nor a PNG", "convert it to PGM or PNG")),
        }
    }

    pub(super) fn of_gray(width: usize, height: usize, most: f64, samples: Vec<u16>) -> Image {
        Image { width, height, channels: 1, most, samples }
    }

    /// Returns a pixel, from the upper left.
    pub fn pixel(&self, x: usize, y: usize) -> Pixel {
        let first = (y * self.width + x) * self.channels;
        let samples = &self.samples[first..first + self.channels];
        let has_alpha = self.channels.is_multiple_of(2);
        let (colours, alpha) = if has_alpha { samples.split_at(self.channels - 1) } else { (samples, &[][..]) };
        let sum: u32 = colours.iter().map(|sample| u32::from(*sample)).sum();
        Pixel {
            shade: f64::from(sum) / colours.len() as f64 / self.most,
            alpha: alpha.first().map(|alpha| f64::from(*alpha) / self.most),
        }
    }
}

/// Refuses an image that is empty or too large, before anything is allocated for it.
pub(super) fn check_size(width: usize, height: usize) -> Result<(), Fault> {
    match width.checked_mul(height) {
        Some(0) => Err(Fault::of_image("it has no pixel", "save the image again, as PGM or PNG")),
        Some(count) if count <= MAX_CELLS => Ok(()),
        _ => {
            let text = format!("it has {width} by {height} pixels, more than the {MAX_CELLS} that a map may have");
            Err(Fault::of_image(text, "crop it, or save the map with a larger `resolution`"))
        }
    }
}

fn read_png(bytes: &[u8]) -> Result<Image, Fault> {
    let broken = |e: png::DecodingError| {
        Fault::of_image(format!("it is a broken PNG: {e}"), "save the image again, as PGM or PNG")
    };
    // Eight bytes for each of the most pixels, and as much for the decoder.
    let limits = png::Limits { bytes: 16 * MAX_CELLS };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    check_size(width, height)?;
    let (colour, depth) = reader.output_color_type();
    let size = reader.output_buffer_size().filter(|size| *size <= 8 * MAX_CELLS);
    let size = size.ok_or_else(|| broken(png::DecodingError::LimitsExceeded))?;
    let mut data = vec![0; size];
    reader.next_frame(&mut data).map_err(broken)?;
    let wide = depth == png::BitDepth::Sixteen;
    let samples = match wide {
        true => data.chunks_exact(2).map(|two| u16::from_be_bytes([two[0], two[1]])).collect(),
        false => data.iter().map(|byte| u16::from(*byte)).collect(),
    };
    Ok(Image { width, height, channels: colour.samples(), most: if wide { 65_535.0 } else { 255.0 }, samples })
}
