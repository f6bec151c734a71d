//! Files of the format safetensors: named arrays of `f32` or bytes, and one text of JSON that says what they are. The text
//! is the only entry of the file's metadata, because the order of several would differ from run to run.

use safetensors::{Dtype, SafeTensors, tensor::TensorView};
use std::collections::BTreeMap;

/// Key of the text in the metadata.
const KEY: &str = "hierarq";

/// Content of a file.
#[derive(Clone, PartialEq, Debug, Default)]
pub(crate) struct TensorFile {
    /// JSON about the arrays.
    pub text: String,
    /// Arrays of numbers.
    pub floats: BTreeMap<String, FloatArray>,
    /// Arrays of bytes.
    pub bytes: BTreeMap<String, Vec<u8>>,
}

/// Numbers with their shape.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct FloatArray {
    /// Lengths of the dimensions; their product is the length of `data`.
    pub shape: Vec<usize>,
    /// The numbers, the last dimension first.
    pub data: Vec<f32>,
}

/// Reason why bytes are not such a file.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum TensorFileError {
    /// The container is damaged.
    #[error("not a safetensors file: {0}")]
    Container(String),
    /// A safetensors file of something else.
    #[error("the file holds no metadata of Hierarq: it was written by another program")]
    Foreign,
    /// An array of other numbers.
    #[error("`{name}` holds numbers of type {found}; {expected} is expected")]
    Type {
        /// Name of the array.
        name: String,
        /// Type in the file.
        found: String,
        /// Types that can be read.
        expected: &'static str,
    },
    /// An array that is needed and absent.
    #[error("there is no array `{0}`")]
    Missing(String),
    /// An array of another shape.
    #[error("`{name}` has the shape {found:?}; {expected:?} is expected")]
    Shape {
        /// Name of the array.
        name: String,
        /// Shape in the file.
        found: Vec<usize>,
        /// Shape that is needed.
        expected: Vec<usize>,
    },
    /// A number that is not finite.
    #[error("`{0}` holds a number that is not finite")]
    NotFinite(String),
}

impl TensorFile {
    /// The file as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let encoded = |array: &FloatArray| array.data.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let floats: Vec<_> = self.floats.iter().map(|(n, a)| (n, Dtype::F32, a.shape.clone(), encoded(a))).collect();
        let bytes = self.bytes.iter().map(|(name, data)| (name, Dtype::U8, vec![data.len()], data.clone()));
        let arrays: Vec<_> = floats.into_iter().chain(bytes).collect();
        let views = arrays.iter().map(|(name, dtype, shape, data)| {
            (
                name.as_str(),
                TensorView::new(*dtype, shape.clone(), data).expect("the shape of each array is its length"),
            )
        });
        let metadata = [(KEY.to_string(), self.text.clone())].into_iter().collect();
        safetensors::serialize(views, Some(metadata)).expect("the header is far below its bound of 100 MB")
    }

    /// Reads a file. Memory is bounded by a small multiple of its length.
    pub fn from_bytes(file: &[u8]) -> Result<TensorFile, TensorFileError> {
        let container = |e: safetensors::SafeTensorError| TensorFileError::Container(e.to_string());
        let (_, header) = SafeTensors::read_metadata(file).map_err(container)?;
        let text = header.metadata().as_ref().and_then(|metadata| metadata.get(KEY));
        let mut read = TensorFile { text: text.ok_or(TensorFileError::Foreign)?.clone(), ..TensorFile::default() };
        for (name, view) in SafeTensors::deserialize(file).map_err(container)?.iter() {
            match view.dtype() {
                Dtype::F32 => {
                    let data = view.data().as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
                    read.floats.insert(name.to_string(), FloatArray { shape: view.shape().to_vec(), data });
                }
                Dtype::U8 => {
                    read.bytes.insert(name.to_string(), view.data().to_vec());
                }
                other => {
                    let found = format!("{other:?}");
                    return Err(TensorFileError::Type { name: name.to_string(), found, expected: "F32 or U8" });
                }
            }
        }
        Ok(read)
    }

    /// Takes out an array of this shape whose numbers are finite.
    pub fn take(&mut self, name: &str, shape: &[usize]) -> Result<Vec<f32>, TensorFileError> {
        let array = self.floats.remove(name).ok_or_else(|| TensorFileError::Missing(name.to_string()))?;
        if array.shape != shape {
            let name = name.to_string();
            return Err(TensorFileError::Shape { name, found: array.shape, expected: shape.to_vec() });
        }
        if array.data.iter().any(|x| !x.is_finite()) {
            return Err(TensorFileError::NotFinite(name.to_string()));
        }
        Ok(array.data)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> TensorFile {
        let mut file = TensorFile { text: "{}".to_string(), ..TensorFile::default() };
        file.floats.insert("b".to_string(), FloatArray { shape: vec![2, 1], data: vec![1.5, -2.0] });
        file.floats.insert("a".to_string(), FloatArray { shape: vec![1], data: vec![f32::NAN] });
        file.bytes.insert("c".to_string(), vec![1, 2, 3]);
        file
    }

    #[test]
    fn files_are_read_as_they_were_written() {
        let mut read = TensorFile::from_bytes(&file().to_bytes()).unwrap();
        assert_eq!(read.to_bytes(), file().to_bytes());
        assert_eq!(read.bytes["c"], [1, 2, 3]);
        assert_eq!(read.take("a", &[1]).unwrap_err().to_string(), "`a` holds a number that is not finite");
        assert_eq!(read.take("b", &[2, 1]).unwrap(), [1.5, -2.0]);
        assert_eq!(read.take("b", &[2, 1]).unwrap_err(), TensorFileError::Missing("b".to_string()));
    }

    #[test]
    fn foreign_and_damaged_files_are_refused() {
        let error = |file: &[u8]| TensorFile::from_bytes(file).unwrap_err().to_string();
        assert!(error(b"").starts_with("not a safetensors file"), "{}", error(b""));
        assert!(error(&[0xff; 40]).starts_with("not a safetensors file"));
        let data = [0_u8; 8];
        let view = || [("x", TensorView::new(Dtype::F64, vec![1], &data).unwrap())];
        let foreign = safetensors::serialize(view(), None).unwrap();
        assert_eq!(error(&foreign), "the file holds no metadata of Hierarq: it was written by another program");
        let metadata = [(KEY.to_string(), String::new())].into_iter().collect();
        let doubles = safetensors::serialize(view(), Some(metadata)).unwrap();
        assert_eq!(error(&doubles), "`x` holds numbers of type F64; F32 or U8 is expected");
    }
}
