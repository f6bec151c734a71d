//! Pieces of mesh files, kept in a folder from one compilation to the next: a mesh of 20,000 triangles takes half a second.
//!
//! The name of an entry is a hash of the file's bytes, the scale, the tolerance and the version of the algorithm, so that an
//! entry is never out of date. It holds the corners to the last bit. A file that is no entry, or is damaged, is replaced; a folder
//! that cannot be written is no error.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use files::Kind;
use nalgebra::Vector3;

use super::Pieces;
use crate::mesh;
use crate::surface::Surface;

/// Folder of the entries, beside a spec.
pub const PIECES_FOLDER: &str = ".hierarq_cache";

/// Number of triangles from which on the pieces of a mesh are kept: fewer are cut at once.
pub const FEWEST_KEPT: usize = 1000;

/// Version of the algorithm and of the entries. Whoever changes the pieces of any mesh raises it.
const VERSION: u64 = 2;

/// First bytes of an entry.
const MAGIC: &[u8] = b"hierarq pieces\n";

/// Largest entry \[bytes\].
const MOST_BYTES: u64 = 64 << 20;

const ENTRY: Kind = Kind { name: "an entry of the cache of pieces", begins: |bytes| bytes.starts_with(MAGIC) };

/// A mesh file whose pieces are wanted.
#[derive(Clone, Debug)]
pub struct MeshFile<'p> {
    /// The file.
    pub path: &'p Path,
    /// Metres of one unit of the file along each axis.
    pub scale: [f64; 3],
    /// Distance by which pieces may exceed the mesh \[m\].
    pub within: f64,
    /// Folder in which [`PIECES_FOLDER`] is; `None` to keep nothing.
    pub beside: Option<&'p Path>,
}

/// Pieces of a mesh file.
#[derive(Clone, Debug, PartialEq)]
pub struct FilePieces {
    /// The pieces.
    pub pieces: Pieces,
    /// An entry that was damaged or of somebody else; its pieces were computed again.
    pub damaged: Option<PathBuf>,
}

impl MeshFile<'_> {
    /// Reads the pieces if they are kept, and computes them otherwise.
    ///
    /// # Errors
    /// The reason why the file cannot be used.
    pub fn pieces(&self) -> Result<FilePieces, String> {
        let file = mesh::MeshBytes::read(self.path)?;
        let entry = self.beside.map(|folder| folder.join(PIECES_FOLDER).join(self.name(&file.bytes)));
        let mut damaged = None;
        if let Some(entry) = entry.as_ref().filter(|entry| entry.symlink_metadata().is_ok()) {
            match files::read(entry, MOST_BYTES).ok().and_then(|bytes| decoded(&bytes)) {
                Some(pieces) => return Ok(FilePieces { pieces, damaged: None }),
                None => damaged = Some(entry.clone()),
            }
        }
        let triangles = mesh::scaled(file.triangles()?, self.scale);
        let surface = Surface::new(&triangles).map_err(|e| e.to_string())?;
        let pieces = surface.pieces(self.within).map_err(|e| e.to_string())?;
        if let Some(entry) = entry.filter(|_| triangles.len() >= FEWEST_KEPT) {
            keep(&entry, &encoded(&pieces), damaged.is_some());
        }
        Ok(FilePieces { pieces, damaged })
    }

    /// Name of the entry.
    fn name(&self, bytes: &[u8]) -> String {
        // The same bytes are another mesh in a file of another kind.
        let kind = self.path.extension().map(|e| e.to_ascii_lowercase()).unwrap_or_default();
        let mut hash = Hash::new();
        hash.add(&VERSION.to_le_bytes());
        self.scale.iter().chain([&self.within]).for_each(|x| hash.add(&x.to_bits().to_le_bytes()));
        hash.add(kind.as_encoded_bytes());
        hash.add(bytes);
        let mut name = String::new();
        // Writing to a string does not fail.
        let _ = write!(name, "{:032x}.pieces", hash.0);
        name
    }
}

/// Writes an entry. A failure is no error: the pieces are computed again the next time.
fn keep(entry: &Path, bytes: &[u8], is_damaged: bool) {
    let Some(folder) = entry.parent() else { return };
    if std::fs::create_dir_all(folder).is_err() {
        return;
    }
    // One of another kind is in the way of the name of an entry: nobody else's files have such names.
    if is_damaged && files::remove(entry).is_err() {
        return;
    }
    if let Ok(mut draft) = files::Draft::new(entry)
        && std::io::Write::write_all(draft.file(), bytes).is_ok()
        && ENTRY.is_at(entry).unwrap_or(false)
    {
        let _ = draft.keep();
    }
}

/// The hash FNV-1a of Fowler, Noll and Vo, with 128 bits.
struct Hash(u128);

impl Hash {
    fn new() -> Hash {
        Hash(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(0x0100_0000_0000_0000_0000_013b);
        }
    }
}

/// Magic, hash of what follows, excess, number of pieces, and of each the number of its corners and their coordinates.
fn encoded(pieces: &Pieces) -> Vec<u8> {
    let mut body = pieces.excess.to_le_bytes().to_vec();
    body.extend((pieces.corners.len() as u64).to_le_bytes());
    for corners in &pieces.corners {
        body.extend((corners.len() as u64).to_le_bytes());
        body.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    let mut hash = Hash::new();
    hash.add(&body);
    [MAGIC, &hash.0.to_le_bytes(), &body].concat()
}

/// The pieces of an entry; `None` if it is none, or damaged.
fn decoded(bytes: &[u8]) -> Option<Pieces> {
    let (written, body) = bytes.strip_prefix(MAGIC)?.split_at_checked(16)?;
    let mut hash = Hash::new();
    hash.add(body);
    if written != hash.0.to_le_bytes() {
        return None;
    }
    let (words, rest) = body.as_chunks::<8>();
    let mut words = words.iter().filter(|_| rest.is_empty());
    let excess = f64::from_le_bytes(*words.next()?);
    let count = u64::from_le_bytes(*words.next()?);
    let mut corners = Vec::new();
    for _ in 0..count {
        let count = u64::from_le_bytes(*words.next()?);
        let mut piece = Vec::new();
        for _ in 0..count {
            let mut x = || Some(f64::from_le_bytes(*words.next()?));
            piece.push(Vector3::new(x()?, x()?, x()?));
        }
        corners.push(piece);
    }
    let is_sound = excess.is_finite()
        && !corners.is_empty()
        && corners.iter().all(|piece| !piece.is_empty() && piece.iter().flatten().all(|x| x.is_finite()));
    (is_sound && words.next().is_none()).then_some(Pieces { corners, excess })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_entry_is_read_to_the_last_bit_and_one_that_is_cut_or_changed_is_none() {
        let corners = vec![vec![Vector3::new(0.1, -0.0, 1e-300)], vec![Vector3::new(1.0, 2.0, 3.0); 5]];
        let pieces = Pieces { corners, excess: 0.1 + 0.2 };
        let bytes = encoded(&pieces);
        assert_eq!(decoded(&bytes), Some(pieces));
        for i in 0..bytes.len() {
            assert_eq!(decoded(&bytes[..i]), None);
            let mut changed = bytes.clone();
            changed[i] ^= 4;
            assert_eq!(decoded(&changed), None);
        }
        assert_eq!(decoded(&[bytes.as_slice(), &[0; 8]].concat()), None);
    }

    #[test]
    fn the_hash_is_the_published_one() {
        let of = |text: &str| {
            let mut hash = Hash::new();
            hash.add(text.as_bytes());
            hash.0
        };
        // Test vectors of its authors.
        assert_eq!(of(""), 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d);
        assert_eq!(of("a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
        assert_eq!(of("foobar"), 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18);
    }
}
