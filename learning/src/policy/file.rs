//! Files of policies: safetensors with one array for the weights `[input, output]` and one for the biases of each layer,
//! `layer0.weight`, `layer0.bias` and so on; and a text of JSON with the world, the sizes of the network, and the training.

use super::{Policy, PolicyError, Training};
use crate::grid::{Action, World};
use crate::network::{Activation, Network, Shape, ShapeError};
use crate::tensor_file::{FloatArray, TensorFile, TensorFileError};
use serde::{Deserialize, Serialize};

const FORMAT: &str = "policy";
const VERSION: u32 = 1;

/// Kind and version of a file, which are read before anything else.
#[derive(Serialize, Deserialize)]
struct Kind {
    format: String,
    version: u32,
}

/// Text of the file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    format: String,
    version: u32,
    world: World,
    hidden: Vec<usize>,
    activation: String,
    training: Training,
}

/// Reason why a file is not a policy.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum PolicyFileError {
    /// The container, or an array in it.
    #[error(transparent)]
    File(#[from] TensorFileError),
    /// The text cannot be read.
    #[error("the metadata of the file cannot be read: {0}")]
    Text(String),
    /// A file of Hierarq that is not a policy.
    #[error("the file is a {0} and not a policy")]
    Format(String),
    /// A later version.
    #[error("the file has version {0} of the format; this program reads version {VERSION}")]
    Version(u32),
    /// An unknown function of the hidden units.
    #[error("the network uses `{0}`; `relu` and `tanh` are known")]
    Activation(String),
    /// Impossible sizes.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// An array that no layer has.
    #[error("the file holds an array `{0}`, which the network has no use for")]
    Unused(String),
    /// A network that does not fit the world.
    #[error(transparent)]
    Policy(#[from] PolicyError),
}

impl Policy {
    /// The policy as a file. The same policy gives the same bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let shape = self.network.shape();
        let header = Header {
            format: FORMAT.to_string(),
            version: VERSION,
            world: self.world.clone(),
            hidden: shape.hidden().to_vec(),
            activation: shape.activation().name().to_string(),
            training: self.training,
        };
        let text = serde_json::to_string(&header).expect("numbers and texts are JSON");
        let mut file = TensorFile { text, ..TensorFile::default() };
        for (layer, size) in shape.layer_sizes().enumerate() {
            let weights =
                FloatArray { shape: vec![size.inputs, size.outputs], data: self.network.weights(layer).to_vec() };
            let biases = FloatArray { shape: vec![size.outputs], data: self.network.biases(layer).to_vec() };
            file.floats.insert(format!("layer{layer}.weight"), weights);
            file.floats.insert(format!("layer{layer}.bias"), biases);
        }
        file.to_bytes()
    }

    /// Reads a file. Sizes are checked before memory is taken; what a file needs is bounded by its length.
    pub fn from_bytes(file: &[u8]) -> Result<Policy, PolicyFileError> {
        let mut file = TensorFile::from_bytes(file)?;
        let text = |e: serde_json::Error| PolicyFileError::Text(e.to_string());
        let kind: Kind = serde_json::from_str(&file.text).map_err(text)?;
        if kind.format != FORMAT {
            return Err(PolicyFileError::Format(kind.format));
        }
        if kind.version != VERSION {
            return Err(PolicyFileError::Version(kind.version));
        }
        let header: Header = serde_json::from_str(&file.text).map_err(text)?;
        let activation = Activation::from_name(&header.activation);
        let activation = activation.ok_or(PolicyFileError::Activation(header.activation))?;
        let shape = Shape::new(header.world.inputs(), &header.hidden, Action::COUNT, activation)?;
        let mut parameters = Vec::new();
        for (layer, size) in shape.layer_sizes().enumerate() {
            parameters.extend(file.take(&format!("layer{layer}.weight"), &[size.inputs, size.outputs])?);
            parameters.extend(file.take(&format!("layer{layer}.bias"), &[size.outputs])?);
        }
        if let Some(name) = file.floats.keys().chain(file.bytes.keys()).next() {
            return Err(PolicyFileError::Unused(name.clone()));
        }
        let network = Network::from_parameters(shape, parameters).expect("each layer has its weights and biases");
        Ok(Policy::new(header.world, network, header.training)?)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::policy;
    use super::*;
    use proptest::prelude::*;

    fn changed(change: impl Fn(&mut TensorFile)) -> String {
        let mut file = TensorFile::from_bytes(&policy().to_bytes()).unwrap();
        change(&mut file);
        Policy::from_bytes(&file.to_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn policies_are_read_as_they_were_written() {
        let policy = policy();
        assert_eq!(Policy::from_bytes(&policy.to_bytes()).unwrap(), policy);
        assert_eq!(policy.to_bytes(), policy.to_bytes());
    }

    #[test]
    fn files_that_do_not_fit_are_refused() {
        let replaced = |from: &'static str, to: &'static str| {
            changed(|file| {
                assert!(file.text.contains(from), "{}", file.text);
                file.text = file.text.replace(from, to);
            })
        };
        assert!(changed(|file| file.text.clear()).starts_with("the metadata of the file cannot be read"));
        assert_eq!(replaced(r#""policy""#, r#""checkpoint""#), "the file is a checkpoint and not a policy");
        assert_eq!(
            replaced(r#""version":1"#, r#""version":7"#),
            "the file has version 7 of the format; this program reads version 1"
        );
        assert_eq!(replaced("relu", "gelu"), "the network uses `gelu`; `relu` and `tanh` are known");
        assert_eq!(
            replaced(r#""hidden":[7]"#, r#""hidden":[99999999]"#),
            "a hidden layer has 99999999 units; 1 to 1024 are possible"
        );
        assert_eq!(
            replaced(r#""hidden":[7]"#, r#""hidden":[8]"#),
            "`layer0.weight` has the shape [60, 7]; [60, 8] is expected"
        );
        let size = replaced(r#""columns":3"#, r#""columns":60000"#);
        assert!(size.contains("a grid of 60000 columns and 2 rows"), "{size}");
        let exit = replaced(r#""exits":[2]"#, r#""exits":[]"#);
        assert!(exit.contains("there is no exit"), "{exit}");
        assert_eq!(changed(|file| drop(file.floats.remove("layer1.bias"))), "there is no array `layer1.bias`");
        assert_eq!(
            changed(|file| file.floats.get_mut("layer1.bias").unwrap().data[0] = f32::INFINITY),
            "`layer1.bias` holds a number that is not finite"
        );
        assert_eq!(
            changed(|file| drop(file.bytes.insert("more".to_string(), vec![0]))),
            "the file holds an array `more`, which the network has no use for"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
        /// Damaged files give an error or another policy, and no panic.
        #[test]
        fn damaged_files_do_not_panic(at in 0_usize..1600, byte in any::<u8>(), cut in 0_usize..1600) {
            let mut file = policy().to_bytes();
            let length = file.len();
            file[at % length] = byte;
            let _ = Policy::from_bytes(&file);
            file.truncate(cut % length);
            prop_assert!(Policy::from_bytes(&file).is_err());
        }
    }
}
