//! A reconstruction as bytes: for recordings, which bring their own so that replay needs no solver.
//!
//! Little-endian: method and solver (a byte each), sign (f32), grid (origin and pixel in mm as f64, columns and rows as u32),
//! coverage (f32 a pixel), number of unknowns (u32) and their pixels (u32 each), then the matrix: channels (u32) and rows (f32), or what L1
//! needs (see `l1`).

use super::kernel::RowMatrix;
use super::l1::L1Model;
use super::{Reconstruction, Solver};
use crate::types::{ByteReader, Method, PixelGrid};

/// No grid has more pixels along a side.
const MOST_ALONG: usize = 1 << 12;
const ONE_STEP: u8 = 0;
const L1: u8 = 1;

impl Reconstruction {
    /// Appends all of it.
    pub fn to_bytes(&self, bytes: &mut Vec<u8>) {
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

    /// One from what [`Self::to_bytes`] gave; none if the bytes are of something else.
    #[must_use]
    pub fn from_bytes(bytes: &mut ByteReader<'_>) -> Option<Self> {
        let method = *Method::ALL.get(usize::from(bytes.u8()?))?;
        let kind = bytes.u8()?;
        let sign = bytes.f32()?;
        let origin_mm = [bytes.f64()?, bytes.f64()?];
        let pixel_mm = bytes.f64()?;
        let (columns, rows) = (bytes.u32()? as usize, bytes.u32()? as usize);
        let numbers = [origin_mm[0], origin_mm[1], pixel_mm];
        let sound = numbers.iter().all(|value| value.is_finite())
            && pixel_mm > 0.0
            && sign.abs() == 1.0
            && columns <= MOST_ALONG
            && rows <= MOST_ALONG;
        if !sound {
            return None;
        }
        let grid = PixelGrid {
            origin_mm,
            pixel_mm,
            columns,
            rows,
        };
        let coverage = bytes.f32s(grid.len())?;
        let unknowns = bytes.count()?;
        let active: Vec<usize> = bytes
            .u32s(unknowns)?
            .into_iter()
            .map(|p| p as usize)
            .collect();
        if active.iter().any(|pixel| *pixel >= grid.len()) {
            return None;
        }
        let solver = match kind {
            ONE_STEP => Solver::OneStep(RowMatrix::from_bytes(bytes, unknowns)?),
            L1 => Solver::L1(L1Model::from_bytes(bytes, unknowns)?),
            _ => return None,
        };
        Some(Self {
            method,
            grid,
            coverage,
            active,
            solver,
            sign,
        })
    }
}
