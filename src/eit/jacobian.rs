//! The Jacobian by the adjoint method: a pair of fields gives the change of a reading for a change of conductivity in any
//! triangle.
//!
//! dV / dsigma_e = - t * integral over e of grad u_drive . grad u_measure, with u_measure the field of a unit
//! current through the measuring pair (Geselowitz 1971; Polydorides and Lionheart 2002, eq. 10).
//!
//! Products of gradients are first summed per pair of electrodes and then combined to channels, so the inner loop does not
//! depend on the protocol.

use faer::Mat;

use super::forward::{Fields, ForwardModel, combine};
use crate::pad::Protocol;
use crate::types::PixelGrid;

/// Sums over elements of weight x grad u_k . grad u_l, for all pairs of fields.
#[derive(Clone)]
struct Sensitivity {
    fields: usize,
    sums: Vec<f64>,
}

impl Sensitivity {
    fn new(fields: usize) -> Self {
        Self {
            fields,
            sums: vec![0.0; fields * fields],
        }
    }

    fn add(&mut self, weight: f64, x: &[f64], y: &[f64]) {
        for (row, (gx, gy)) in self.sums.chunks_exact_mut(self.fields).zip(x.iter().zip(y)) {
            let (gx, gy) = (gx * weight, gy * weight);
            for (sum, (hx, hy)) in row.iter_mut().zip(x.iter().zip(y)) {
                *sum += gx * hx + gy * hy;
            }
        }
    }

    /// Change of each channel's reading per unit rise of conductivity, V/A per S/m.
    fn channels<'a>(&'a self, protocol: &'a Protocol) -> impl Iterator<Item = f64> + 'a {
        pair_sums(protocol, self.fields, |k, l| self.sums[k * self.fields + l])
    }
}

/// Change of each channel's reading, from sums over pairs of fields of grad u_k . dsigma grad u_l.
pub(super) fn pair_sums(
    protocol: &Protocol,
    fields: usize,
    sums: impl Fn(usize, usize) -> f64,
) -> impl Iterator<Item = f64> {
    let term = move |k: usize, l: usize| {
        // The last electrode is ground: its field is zero.
        if k == fields || l == fields {
            0.0
        } else {
            sums(k, l)
        }
    };
    protocol
        .channels
        .iter()
        .map(move |channel| -combine(channel, &term))
}

/// Channels x the listed triangles, V/A per S/m.
#[must_use]
pub fn element_jacobian(
    model: &ForwardModel,
    fields: &Fields,
    protocol: &Protocol,
    triangles: &[usize],
) -> Mat<f64> {
    let mut jacobian = Mat::zeros(protocol.channels.len(), triangles.len());
    let mut gradients = [vec![0.0; fields.len()], vec![0.0; fields.len()]];
    let mut sensitivity = Sensitivity::new(fields.len());
    for (index, triangle) in triangles.iter().enumerate() {
        let [x, y] = &mut gradients;
        model.gradients(fields, *triangle, x, y);
        sensitivity.sums.fill(0.0);
        sensitivity.add(model.weight(*triangle), x, y);
        for (entry, value) in jacobian
            .col_mut(index)
            .iter_mut()
            .zip(sensitivity.channels(protocol))
        {
            *entry = value;
        }
    }
    jacobian
}

/// Channels x cells: change of a reading per relative change of a cell's conductivity, V/A. Each triangle has its cell and its
/// conductivity, S/m.
pub(super) fn cell_jacobian(
    model: &ForwardModel,
    fields: &Fields,
    protocol: &Protocol,
    of_triangle: &[(usize, f64)],
    cells: usize,
) -> Mat<f64> {
    let mut sensitivities = vec![Sensitivity::new(fields.len()); cells];
    let mut gradients = [vec![0.0; fields.len()], vec![0.0; fields.len()]];
    for (triangle, (cell, siemens)) in of_triangle.iter().enumerate() {
        let [x, y] = &mut gradients;
        model.gradients(fields, triangle, x, y);
        sensitivities[*cell].add(siemens * model.weight(triangle), x, y);
    }
    let mut jacobian = Mat::zeros(protocol.channels.len(), cells);
    for (cell, sensitivity) in sensitivities.iter().enumerate() {
        let column = jacobian.col_mut(cell).iter_mut();
        for (entry, value) in column.zip(sensitivity.channels(protocol)) {
            *entry = value;
        }
    }
    jacobian
}

/// A Jacobian over the pixels of a grid that hold conductor.
#[derive(Clone, Debug)]
pub struct PixelJacobian {
    /// Pixels that hold conductor, ascending.
    pub active: Vec<usize>,
    /// Share of each pixel of the grid that is conductor, 0 to 1.
    pub coverage: Vec<f64>,
    /// Channels x active pixels, V/A per S/m in the conductor of the pixel.
    pub matrix: Mat<f64>,
}

/// The Jacobian for the conductivity of each pixel's conductor. Each quarter of a triangle counts for the pixel that
/// contains it.
#[must_use]
pub fn pixel_jacobian(
    model: &ForwardModel,
    fields: &Fields,
    protocol: &Protocol,
    grid: &PixelGrid,
) -> PixelJacobian {
    const NONE: usize = usize::MAX;
    let mesh = model.mesh();
    let pixel_area = grid.pixel_mm * grid.pixel_mm;
    let mut coverage = vec![0.0; grid.len()];
    let quarters: Vec<[usize; 4]> = (0..mesh.triangles.len())
        .map(|triangle| {
            let share = mesh.area_mm2(triangle) / pixel_area / 4.0;
            mesh.quarter_points_mm(triangle)
                .map(|point| match grid.index_at(point) {
                    Some(pixel) => {
                        coverage[pixel] += share;
                        pixel
                    }
                    None => NONE,
                })
        })
        .collect();
    let active: Vec<usize> = (0..grid.len()).filter(|p| coverage[*p] > 0.0).collect();
    let mut column_of = vec![NONE; grid.len()];
    for (column, pixel) in active.iter().enumerate() {
        column_of[*pixel] = column;
    }
    let mut sensitivities: Vec<Sensitivity> = active
        .iter()
        .map(|_| Sensitivity::new(fields.len()))
        .collect();
    let mut gradients = [vec![0.0; fields.len()], vec![0.0; fields.len()]];
    for (triangle, pixels) in quarters.iter().enumerate() {
        let [x, y] = &mut gradients;
        model.gradients(fields, triangle, x, y);
        for (index, pixel) in pixels.iter().enumerate() {
            if *pixel == NONE || pixels[..index].contains(pixel) {
                continue;
            }
            let share = pixels.iter().filter(|other| *other == pixel).count() as f64 / 4.0;
            sensitivities[column_of[*pixel]].add(share * model.weight(triangle), x, y);
        }
    }
    let mut matrix = Mat::zeros(protocol.channels.len(), active.len());
    for (column, sensitivity) in sensitivities.iter().enumerate() {
        for (entry, value) in matrix
            .col_mut(column)
            .iter_mut()
            .zip(sensitivity.channels(protocol))
        {
            *entry = value;
        }
    }
    PixelJacobian {
        active,
        coverage: coverage.into_iter().map(|share| share.min(1.0)).collect(),
        matrix,
    }
}
