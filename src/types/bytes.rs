//! Numbers out of bytes, little-endian: for formats that may be damaged or hostile, so nothing is trusted and nothing is
//! reserved that is not there.

/// What is left to read.
#[derive(Clone, Copy, Debug)]
pub struct ByteReader<'a>(&'a [u8]);

impl<'a> ByteReader<'a> {
    /// A reader of all of these.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// What is left.
    #[must_use]
    pub fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// So many bytes.
    pub fn bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    /// An array of bytes.
    pub fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*taken)
    }

    /// One byte.
    pub fn u8(&mut self) -> Option<u8> {
        self.array().map(u8::from_le_bytes)
    }

    /// A number of two bytes.
    pub fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    /// A number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    /// A number of eight bytes.
    pub fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// A count of four bytes, for what takes at least a byte each: never above what is left.
    pub fn count(&mut self) -> Option<usize> {
        let count = self.u32()? as usize;
        (count <= self.0.len()).then_some(count)
    }

    /// A float of four bytes.
    pub fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    /// A float of eight bytes.
    pub fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// So many floats of four bytes.
    pub fn f32s(&mut self, count: usize) -> Option<Vec<f32>> {
        let (values, _) = self.bytes(count.checked_mul(4)?)?.as_chunks::<4>();
        Some(values.iter().map(|v| f32::from_le_bytes(*v)).collect())
    }

    /// So many floats of eight bytes.
    pub fn f64s(&mut self, count: usize) -> Option<Vec<f64>> {
        let (values, _) = self.bytes(count.checked_mul(8)?)?.as_chunks::<8>();
        Some(values.iter().map(|v| f64::from_le_bytes(*v)).collect())
    }

    /// So many numbers of four bytes.
    pub fn u32s(&mut self, count: usize) -> Option<Vec<u32>> {
        let (values, _) = self.bytes(count.checked_mul(4)?)?.as_chunks::<4>();
        Some(values.iter().map(|v| u32::from_le_bytes(*v)).collect())
    }

    /// A text: its length in four bytes, and it in UTF-8.
    pub fn text(&mut self) -> Option<&'a str> {
        let count = self.count()?;
        std::str::from_utf8(self.bytes(count)?).ok()
    }
}
