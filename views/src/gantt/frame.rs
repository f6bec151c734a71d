//! Common parts of maps: conversion of metres to pixels, labels of points, the scale bar.

use std::fmt::Write;

use mission::map::Moving;

use crate::xml::escaped;

use super::{columns, px, shortened};

const SIDE: f64 = 560.0;
const MARGIN: f64 = 46.0;
const CHARACTER: f64 = 6.6;
/// Maximum number of characters of a name that is not shortened.
pub(super) const LONGEST: usize = 18;

/// Conversion of metres to pixels.
pub(super) struct Frame {
    pub left: f64,
    pub top: f64,
    pub scale: f64,
    pub width: f64,
    pub height: f64,
}

impl Frame {
    /// Creates a frame that contains these points (m), with at most `most` pixels per metre.
    pub fn of(points: impl Iterator<Item = [f64; 2]>, most: f64) -> Frame {
        let finite = points.filter(|p| p.iter().all(|x| x.abs() < 1e9));
        let none = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let [x0, y0, x1, y1] = finite.fold(none, |b, [x, y]| [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]);
        let [x0, y0, x1, y1] = if x0.is_finite() { [x0, y0, x1, y1] } else { [0.0, 0.0, 1.0, 1.0] };
        let scale = (SIDE / (x1 - x0).max(y1 - y0).max(SIDE / most)).min(most);
        let (width, height) = (2.0 * MARGIN + scale * (x1 - x0), 2.0 * MARGIN + scale * (y1 - y0));
        // Space for the text below, and for the longest name beside a point at the border.
        let wide = width.max(420.0);
        Frame {
            left: 0.5 * (wide - width) + MARGIN - scale * x0,
            top: MARGIN + scale * y1,
            scale,
            width: wide,
            height: height + 28.0,
        }
    }

    /// Converts a position (m) into the picture (px).
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let clamp = |v: f64, most: f64| if v.is_finite() { v.clamp(0.0, most) } else { 0.0 };
        [clamp(self.left + self.scale * x, self.width), clamp(self.top - self.scale * y, self.height)]
    }

    /// Draws the scale bar, to the left of the text below.
    pub fn bar(&self, out: &mut String) -> std::fmt::Result {
        let rough = 90.0 / self.scale;
        let power = 10f64.powi(rough.log10().floor() as i32);
        let length = [5.0, 2.0, 1.0].into_iter().map(|of| of * power).find(|length| *length <= rough).unwrap_or(power);
        let (y, width) = (self.words(), self.scale * length);
        writeln!(out, "<path class=\"scale\" d=\"M10 {} v5 h{} v-5\"/>", px(y - 5.0), px(width))?;
        let length = runtime::text::number(length);
        writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">{length} m</text>", px(16.0 + width), px(y + 2.0))
    }

    /// Returns the vertical position of the text below (px).
    pub fn words(&self) -> f64 {
        self.height - 12.0
    }

    /// Draws those who move, with their positions (m), people as their signs are. For updates by a page, the group has `data-x`, `data-y` (px)
    /// of the origin and `data-scale` (px/m).
    pub fn moving<'n>(&self, all: impl Iterator<Item = (&'n Moving, [f64; 2])>, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "<g class=\"robots\" data-x=\"{}\" data-y=\"{}\" data-scale=\"{:.4}\">",
            px(self.left),
            px(self.top),
            self.scale
        )?;
        for (who, position) in all {
            let [x, y] = self.at(position);
            let name = escaped(&shortened(&who.label, LONGEST));
            let mark = match who.is_person {
                true => "<circle class=\"human\" r=\"6\"/>",
                false => "<path class=\"robot\" d=\"M0 -8 L8 0 L0 8 L-8 0 z\"/>",
            };
            writeln!(
                out,
                "<g transform=\"translate({} {})\">{mark}\
                 <text class=\"small middle\" y=\"-11\">{name}</text></g>",
                px(x),
                px(y)
            )?;
        }
        writeln!(out, "</g>")
    }
}

/// Labels of points, placed without overlap if a side is free.
pub(super) struct Names<'f> {
    taken: Vec<[f64; 4]>,
    frame: &'f Frame,
}

impl<'f> Names<'f> {
    /// Creates an empty set of labels.
    pub fn new(frame: &'f Frame) -> Names<'f> {
        Names { taken: Vec::new(), frame }
    }

    /// Keeps this point (px) free of labels.
    pub fn keep_clear(&mut self, [x, y]: [f64; 2]) {
        self.taken.push([x - 7.0, y - 7.0, x + 7.0, y + 7.0]);
    }

    /// Writes a label beside a point (px).
    pub fn write(&mut self, [x, y]: [f64; 2], name: &str, out: &mut String) -> std::fmt::Result {
        let name = shortened(name, LONGEST);
        let width = CHARACTER * columns(&name) as f64;
        let boxed = |left: f64, base: f64| [left, base - 10.0, left + width, base + 3.0];
        let sides = [
            (x + 10.0, y + 4.0),
            (x - 10.0 - width, y + 4.0),
            (x - 0.5 * width, y - 12.0),
            (x - 0.5 * width, y + 21.0),
        ];
        let free = |b: &[f64; 4]| {
            let inside = b[0] >= 0.0 && b[2] <= self.frame.width && b[1] >= 0.0;
            let apart = |t: &[f64; 4]| b[2] <= t[0] || t[2] <= b[0] || b[3] <= t[1] || t[3] <= b[1];
            inside && self.taken.iter().all(apart)
        };
        let (left, base) = sides.into_iter().find(|(left, base)| free(&boxed(*left, *base))).unwrap_or(sides[0]);
        self.taken.push(boxed(left, base));
        writeln!(out, "<text class=\"small name\" x=\"{}\" y=\"{}\">{}</text>", px(left), px(base), escaped(&name))
    }
}
