//! A sparse symmetric system whose unknowns are numbered in the order of elimination.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::eit::ForwardError;

/// Cost of a factorisation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Size {
    /// Unknowns.
    pub unknowns: usize,
    /// Memory of matrix and factor, bytes.
    pub bytes: f64,
    /// Multiplications and additions.
    pub flops: f64,
}

/// Why a system cannot be factorised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum SystemError {
    /// A pivot vanished.
    #[error("the system is singular")]
    Singular,
    /// Too little memory, or more entries than an index can count.
    #[error("the system is too large for the memory of this machine")]
    TooLarge,
}

impl From<SystemError> for ForwardError {
    fn from(error: SystemError) -> Self {
        match error {
            SystemError::Singular => Self::Disconnected,
            SystemError::TooLarge => Self::TooLarge,
        }
    }
}

/// The sparsity pattern of a system and its symbolic factorisation.
#[derive(Debug)]
pub(super) struct System {
    starts: Vec<usize>,
    rows: Vec<usize>,
    symbolic: SymbolicCholesky<usize>,
}

/// A factorised system.
pub(super) struct Factor<'a> {
    symbolic: &'a SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl System {
    /// A system of `unknowns`; each group couples all of its members.
    pub(super) fn new<'a>(
        unknowns: usize,
        groups: impl Iterator<Item = &'a [u32]>,
    ) -> Result<Self, SystemError> {
        let mut columns: Vec<Vec<u32>> = (0..unknowns).map(|column| vec![column as u32]).collect();
        for group in groups {
            for column in group {
                let below = &mut columns[*column as usize];
                // Neighbours repeat: duplicates are removed before the list grows.
                if below.len() + group.len() > below.capacity() {
                    below.sort_unstable();
                    below.dedup();
                }
                below.extend(group.iter().filter(|row| *row > column));
            }
        }
        let mut starts = vec![0];
        let mut rows = Vec::new();
        for mut column in columns {
            column.sort_unstable();
            column.dedup();
            rows.extend(column.iter().map(|row| *row as usize));
            starts.push(rows.len());
        }
        let pattern =
            SymbolicSparseColMatRef::new_checked(unknowns, unknowns, &starts, None, &rows);
        // The unknowns are in order already, but faer takes a lower triangle only with an order.
        let identity: Vec<usize> = (0..unknowns).collect();
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Custom(PermRef::new_checked(&identity, &identity, unknowns)),
            CholeskySymbolicParams::default(),
        )
        .map_err(|_| SystemError::TooLarge)?;
        Ok(Self {
            starts,
            rows,
            symbolic,
        })
    }

    /// Number of entries of the lower triangle.
    pub(super) fn entries(&self) -> usize {
        self.rows.len()
    }

    /// Index of the entry of two unknowns, in either order.
    ///
    /// # Panics
    /// If no group holds both.
    pub(super) fn entry(&self, a: u32, b: u32) -> u32 {
        let (row, column) = (a.max(b) as usize, a.min(b) as usize);
        let rows = &self.rows[self.starts[column]..self.starts[column + 1]];
        let place = rows.binary_search(&row).expect("a coupled pair");
        (self.starts[column] + place) as u32
    }

    /// Cost of its factorisation.
    pub(super) fn size(&self) -> Size {
        let flops = match self.symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(symbolic) => {
                let starts = symbolic.col_ptr();
                starts
                    .windows(2)
                    .map(|pair| ((pair[1] - pair[0]) as f64).powi(2))
                    .sum()
            }
            SymbolicCholeskyRaw::Supernodal(symbolic) => (0..symbolic.n_supernodes())
                .map(|index| {
                    let width = symbolic.supernode_end()[index] - symbolic.supernode_begin()[index];
                    let height = width + symbolic.supernode(index).pattern().len();
                    (0..width)
                        .map(|done| ((height - done) as f64).powi(2))
                        .sum::<f64>()
                })
                .sum(),
        };
        Size {
            unknowns: self.symbolic.nrows(),
            bytes: 8.0 * (self.symbolic.len_val() as f64 + 3.0 * self.rows.len() as f64),
            flops,
        }
    }

    /// Factorises the system with these entries.
    pub(super) fn factorise(&self, values: &[f64]) -> Result<Factor<'_>, SystemError> {
        let unknowns = self.symbolic.nrows();
        let pattern = SymbolicSparseColMatRef::new_checked(
            unknowns,
            unknowns,
            &self.starts,
            None,
            &self.rows,
        );
        let matrix = SparseColMatRef::new(pattern, values);
        let mut factor = vec![0.0; self.symbolic.len_val()];
        let scratch = self
            .symbolic
            .factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| SystemError::TooLarge)?;
        self.symbolic
            .factorize_numeric_ldlt(
                &mut factor,
                matrix,
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|_| SystemError::Singular)?;
        Ok(Factor {
            symbolic: &self.symbolic,
            values: factor,
        })
    }
}

impl Factor<'_> {
    /// Solves for several right-hand sides, in place.
    pub(super) fn solve_in_place(&self, sides: MatMut<'_, f64>) -> Result<(), SystemError> {
        let scratch = self
            .symbolic
            .solve_in_place_scratch::<f64>(sides.ncols(), Par::Seq);
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| SystemError::TooLarge)?;
        LdltRef::new(self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            sides,
            Par::Seq,
            MemStack::new(&mut memory),
        );
        Ok(())
    }
}
