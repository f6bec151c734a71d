//! Writer of CDR, the encoding of ROS 2 messages: little endian, each number aligned to its size, counted from the end of the
//! header of four bytes (OMG DDS-XTypes 1.3, 7.4.1, version 1 of the encoding).

/// Header: plain CDR, little endian, no options.
pub const HEADER: [u8; 4] = [0, 1, 0, 0];

/// A message under construction. Its storage is kept from message to message.
#[derive(Debug, Default)]
pub struct Cdr {
    bytes: Vec<u8>,
}

macro_rules! numbers {
    ($($name:ident: $number:ty),*) => {
        $(
            /// Appends a number.
            pub fn $name(&mut self, x: $number) {
                self.align(size_of::<$number>());
                self.bytes.extend_from_slice(&x.to_le_bytes());
            }
        )*
    };
}

impl Cdr {
    numbers!(u8: u8, i32: i32, u32: u32, f32: f32, f64: f64);

    /// Begins a message.
    pub fn begin(&mut self) {
        self.bytes.clear();
        self.bytes.extend_from_slice(&HEADER);
    }

    /// The message.
    pub fn message(&self) -> &[u8] {
        &self.bytes
    }

    fn align(&mut self, size: usize) {
        let after_header = self.bytes.len() - HEADER.len();
        self.bytes.resize(self.bytes.len() + after_header.next_multiple_of(size) - after_header, 0);
    }

    /// Appends the length of a sequence, whose elements follow.
    pub fn count(&mut self, n: usize) {
        self.u32(u32::try_from(n).unwrap_or(u32::MAX));
    }

    /// Appends a truth value.
    pub fn bool(&mut self, x: bool) {
        self.u8(u8::from(x));
    }

    /// Appends a text.
    pub fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    /// Appends a sequence of texts.
    pub fn texts<T: AsRef<str>>(&mut self, texts: &[T]) {
        self.count(texts.len());
        texts.iter().for_each(|text| self.text(text.as_ref()));
    }

    /// Appends a sequence of numbers.
    pub fn f64s(&mut self, numbers: &[f64]) {
        self.count(numbers.len());
        numbers.iter().for_each(|x| self.f64(*x));
    }
}
