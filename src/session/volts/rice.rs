//! Rice codes as a stream of bits, the highest bit of a byte first.

/// A value whose quotient reaches this is written whole.
const ESCAPE: u32 = 24;

pub(super) struct BitWriter {
    bytes: Vec<u8>,
    pending: u64,
    count: u32,
}

impl BitWriter {
    /// Appends to bytes.
    pub(super) fn new(bytes: Vec<u8>) -> Self {
        Self {
            bytes,
            pending: 0,
            count: 0,
        }
    }

    /// Writes the lowest `count` bits of a value, 32 at most.
    fn put(&mut self, value: u32, count: u32) {
        self.pending = (self.pending << count) | u64::from(value);
        self.count += count;
        while self.count >= 8 {
            self.count -= 8;
            self.bytes.push((self.pending >> self.count) as u8);
        }
        self.pending &= (1 << self.count) - 1;
    }

    /// Writes a signed value: the quotient by 2^parameter as ones and a zero, then the remainder.
    pub(super) fn put_rice(&mut self, value: i32, parameter: u32) {
        let value = zigzag(value);
        let quotient = value >> parameter;
        if quotient >= ESCAPE {
            self.put((1 << ESCAPE) - 1, ESCAPE);
            self.put(value, 32);
        } else {
            self.put((1 << (quotient + 1)) - 2, quotient + 1);
            self.put(value & ((1 << parameter) - 1), parameter);
        }
    }

    /// The bytes; the last one is filled with zeros.
    pub(super) fn finish(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.put(0, 8 - self.count);
        }
        self.bytes
    }
}

pub(super) struct BitReader<'a> {
    bytes: &'a [u8],
    pending: u64,
    count: u32,
}

impl<'a> BitReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            pending: 0,
            count: 0,
        }
    }

    /// Reads `count` bits, 32 at most; `None` at the end of the bytes.
    fn get(&mut self, count: u32) -> Option<u32> {
        while self.count < count {
            let (byte, rest) = self.bytes.split_first()?;
            self.bytes = rest;
            self.pending = (self.pending << 8) | u64::from(*byte);
            self.count += 8;
        }
        self.count -= count;
        let value = self.pending >> self.count;
        self.pending &= (1 << self.count) - 1;
        Some(value as u32)
    }

    /// Reads what [`BitWriter::put_rice`] wrote.
    pub(super) fn get_rice(&mut self, parameter: u32) -> Option<i32> {
        let mut quotient = 0;
        while quotient < ESCAPE && self.get(1)? == 1 {
            quotient += 1;
        }
        let value = if quotient == ESCAPE {
            self.get(32)?
        } else {
            let high: u32 = quotient.checked_shl(parameter)?;
            high | self.get(parameter)?
        };
        Some(unzigzag(value))
    }
}

fn zigzag(value: i32) -> u32 {
    ((value << 1) ^ (value >> 31)) as u32
}

fn unzigzag(value: u32) -> i32 {
    ((value >> 1) as i32) ^ -((value & 1) as i32)
}
