//! A reconstruction as bytes, for recordings: a replay needs no solver.
//!
//! Little-endian: method and solver (one byte each); sign (f32); grid (origin and pixel in mm as f64, columns and rows as
//! u32); coverage (f32 per pixel); number of unknowns (u32) and their pixels (u32 each); then the matrix (channels as u32,
//! rows as f32) or the model of L1 (see `l1`).
//!
//! Sign and grid follow from the pad, so the stored ones are only compared with it.

use super::kernel::RowMatrix;
use super::l1::L1Model;
use super::linearised::pixel_grid;
use super::reconstruction::{Reconstruction, Solver};
use crate::pad::Pad;
use crate::types::{ByteReader, Method, PixelGrid};

const ONE_STEP: u8 = 0;
const L1: u8 = 1;

impl Reconstruction {
    /// Appends the reconstruction to `bytes`.
    pub(crate) fn to_bytes(&self, bytes: &mut Vec<u8>) {
        let method = Method::ALL.iter().position(|m| *m == self.method);
        bytes.push(method.unwrap_or(0) as u8);
        bytes.push(match self.solver {
            Solver::OneStep(_) => ONE_STEP,
            Solver::L1(_) => L1,
        });
        bytes.extend_from_slice(&self.sign.to_le_bytes());
        let [x, y] = self.grid.origin_mm;
        for value in [x, y, self.grid.pixel_mm] {
            bytes.extend_from_slice(&value.to_le_bytes());
        }
        let mut count = |value: usize| bytes.extend_from_slice(&(value as u32).to_le_bytes());
        count(self.grid.columns);
        count(self.grid.rows);
        for share in &self.coverage {
            bytes.extend_from_slice(&share.to_le_bytes());
        }
        bytes.extend_from_slice(&(self.active.len() as u32).to_le_bytes());
        for pixel in &self.active {
            bytes.extend_from_slice(&(*pixel as u32).to_le_bytes());
        }
        match &self.solver {
            Solver::OneStep(matrix) => matrix.to_bytes(bytes),
            Solver::L1(model) => model.to_bytes(bytes),
        }
    }

    /// Reads a reconstruction of a pad; `None` if the bytes are anything else, or values are out of range.
    #[must_use]
    pub(crate) fn from_bytes(bytes: &mut ByteReader<'_>, pad: &Pad) -> Option<Self> {
        let method = *Method::ALL.get(usize::from(bytes.u8()?))?;
        let solver = bytes.u8()?;
        let sign = bytes.f32()?;
        let grid = PixelGrid {
            origin_mm: [bytes.f64()?, bytes.f64()?],
            pixel_mm: bytes.f64()?,
            columns: bytes.u32()? as usize,
            rows: bytes.u32()? as usize,
        };
        if sign != pad.touch_sign.factor() || grid != pixel_grid(pad) {
            return None;
        }
        let coverage = bytes.f32s(grid.len())?;
        let unknowns = bytes.count()?;
        let active: Vec<usize> = bytes
            .u32s(unknowns)?
            .into_iter()
            .map(|p| p as usize)
            .collect();
        let is_valid = coverage.iter().all(|share| (0.0..=1.0).contains(share))
            && active.is_sorted_by(|a, b| a < b)
            && active.last().is_some_and(|pixel| *pixel < grid.len());
        if !is_valid {
            return None;
        }
        let solver = match solver {
            ONE_STEP => Solver::OneStep(RowMatrix::from_bytes(bytes, unknowns)?),
            L1 => Solver::L1(L1Model::from_bytes(bytes, unknowns)?),
            _ => return None,
        };
        let reconstruction = Self {
            method,
            grid,
            coverage,
            active,
            solver,
            sign,
        };
        (reconstruction.channels() == pad.channels()).then_some(reconstruction)
    }
}
