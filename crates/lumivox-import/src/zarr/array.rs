//! One array: its shape, its chunks, and slices out of them.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError},
};

use lumivox_core::CancelToken;
use serde_json::Value;

use super::{chunks::Compression, damaged, read_json, sample_type};
use crate::{error::ImportError, sample::SampleType, samples::Planes, sizes::at_most};

/// Bytes of the largest chunk, and of the chunks that a slice lies in.
const LARGEST_CHUNK: usize = 1 << 30;
const LARGEST_SLAB: usize = at_most(4 << 30);
/// Chunks of one volume that are looked for; each costs a look at the disk, be it there or not.
const MOST_CHUNKS: usize = 1 << 20;
/// A volume may always have so many voxels, and beyond it so many times those of the chunks that are there.
const ALWAYS: usize = 16 << 20;
const TIMES: usize = 64;
/// What chunks of nothing but zeros are packed to.
const LARGEST_RATIO: usize = 1 << 12;
/// Voxels of one volume.
const MOST_VOXELS: usize = at_most(1 << 33);

/// An array.
#[derive(Debug)]
pub(super) struct Array {
    folder: PathBuf,
    /// The file that describes it.
    pub(super) description: PathBuf,
    pub(super) shape: Vec<usize>,
    chunk: Vec<usize>,
    pub(super) sample: SampleType,
    big_endian: bool,
    compression: Compression,
    /// The sample where there is no chunk, little endian.
    fill: Vec<u8>,
    /// What lies before and between the numbers of a chunk's name.
    prefix: &'static str,
    separator: char,
}

/// How the samples of a chunk are written, and how chunks are named; see [`Array`].
struct Coding {
    sample: SampleType,
    big_endian: bool,
    compression: Compression,
    prefix: &'static str,
    separator: char,
}

impl Array {
    /// Reads the description of the array in a folder.
    pub(super) fn open(folder: &Path) -> Result<Self, ImportError> {
        let [three, two] = ["zarr.json", ".zarray"].map(|name| folder.join(name));
        if crate::files::is_file(&three) {
            let json = read_json(&three)?;
            return Self::of_three(folder, three, &json);
        }
        if crate::files::is_file(&two) {
            let json = read_json(&two)?;
            return Self::of_two(folder, two, &json);
        }
        Err(ImportError::Unsupported {
            path: folder.to_owned(),
            what: "a folder of Zarr in which neither an image nor an array is described".to_owned(),
            remedy: "Open the folder of one image in it".to_owned(),
        })
    }

    fn of_two(folder: &Path, description: PathBuf, json: &Value) -> Result<Self, ImportError> {
        let bad = |what: &str| damaged(&description, what);
        let unsupported = |what: String| unsupported(&description, what);
        let (sample, big_endian) = json["dtype"]
            .as_str()
            .and_then(sample_type)
            .ok_or_else(|| unsupported("an array of what are no real numbers".to_owned()))?;
        if json["order"].as_str().unwrap_or("C") != "C"
            && json["shape"].as_array().is_some_and(|shape| shape.len() > 1)
        {
            return Err(unsupported("an array whose chunks are in Fortran's order".to_owned()));
        }
        if json["filters"].as_array().is_some_and(|filters| !filters.is_empty()) {
            return Err(unsupported("an array with filters".to_owned()));
        }
        let compression = match json["compressor"]["id"].as_str() {
            None => Compression::None,
            Some(name) => Compression::of_name(name)
                .ok_or_else(|| unsupported(format!("an array that is compressed as '{}'", short(name))))?,
        };
        let separator = match json["dimension_separator"].as_str().unwrap_or(".") {
            "." => '.',
            "/" => '/',
            _ => return Err(bad("has a dimension_separator that is neither . nor /")),
        };
        let coding = Coding { sample, big_endian, compression, prefix: "", separator };
        Self::new(folder, description, json, &json["chunks"], coding)
    }

    fn of_three(folder: &Path, description: PathBuf, json: &Value) -> Result<Self, ImportError> {
        let bad = |what: &str| damaged(&description, what);
        let unsupported = |what: String| unsupported(&description, what);
        if json["node_type"] != "array" {
            return Err(unsupported("a group of Zarr without an image".to_owned()));
        }
        let (sample, _) = json["data_type"]
            .as_str()
            .and_then(sample_type)
            .ok_or_else(|| unsupported("an array of what are no real numbers".to_owned()))?;
        let (mut compression, mut big_endian) = (Compression::None, false);
        for codec in json["codecs"].as_array().into_iter().flatten() {
            let name = codec["name"].as_str().unwrap_or_default();
            match (name, Compression::of_name(name)) {
                ("bytes", _) => big_endian = codec["configuration"]["endian"] == "big",
                ("endian", _) => big_endian = codec["configuration"]["endian"] == "big",
                ("sharding_indexed", _) => return Err(unsupported("a sharded array".to_owned())),
                (_, Some(found)) if compression == Compression::None => compression = found,
                _ => return Err(unsupported(format!("an array whose chunks go through '{}'", short(name)))),
            }
        }
        let encoding = &json["chunk_key_encoding"];
        let is_plain = encoding["name"] == "v2";
        let separator = encoding["configuration"]["separator"].as_str();
        let separator = match separator.unwrap_or(if is_plain { "." } else { "/" }) {
            "." => '.',
            "/" => '/',
            _ => return Err(bad("has names of chunks that are parted by neither . nor /")),
        };
        let prefix = if is_plain { "" } else { "c" };
        let coding = Coding { sample, big_endian, compression, prefix, separator };
        Self::new(folder, description, json, &json["chunk_grid"]["configuration"]["chunk_shape"], coding)
    }

    /// What all versions say alike; `chunk` is where this one says how large chunks are.
    fn new(
        folder: &Path,
        description: PathBuf,
        json: &Value,
        chunk: &Value,
        coding: Coding,
    ) -> Result<Self, ImportError> {
        let shape = sizes(&json["shape"]).ok_or_else(|| damaged(&description, "has no shape"))?;
        let chunk = sizes(chunk).ok_or_else(|| damaged(&description, "has no size of chunks"))?;
        let Coding { sample, big_endian, compression, prefix, separator } = coding;
        let fill = fill(&json["fill_value"], sample);
        let folder = folder.to_owned();
        Self { folder, description, shape, chunk, sample, big_endian, compression, fill, prefix, separator }
            .checked()
    }

    fn checked(self) -> Result<Self, ImportError> {
        let is_array =
            !self.shape.is_empty() && self.shape.len() == self.chunk.len() && self.shape.len() <= 5;
        let chunk = self.chunk.iter().try_fold(self.sample.bytes(), |bytes, side| bytes.checked_mul(*side));
        if !is_array || chunk.is_none_or(|bytes| bytes > LARGEST_CHUNK) {
            return Err(damaged(
                &self.description,
                "has a shape and a size of chunks that do not fit together",
            ));
        }
        Ok(self)
    }

    /// Refuses volumes that cost more than any scan does, before memory and time are taken for them.
    pub(super) fn check(&self, dims: [usize; 3], volumes: usize) -> Result<(), ImportError> {
        let voxels = dims.iter().try_fold(1usize, |voxels, side| voxels.checked_mul(*side));
        let sides = self.shape.iter().zip(&self.chunk).map(|(side, chunk)| side.div_ceil(*chunk));
        let chunks = sides.clone().try_fold(1usize, |chunks, side| chunks.checked_mul(side));
        let of_volume = chunks.map(|chunks| chunks / volumes.max(1));
        let slab = [dims[0], dims[1], self.depth_of_chunk(dims[2])]
            .iter()
            .try_fold(self.sample.bytes(), |bytes, side| bytes.checked_mul(*side));
        let is_possible = voxels.is_some_and(|voxels| (1..=MOST_VOXELS).contains(&voxels))
            && volumes.checked_mul(voxels.unwrap_or(0)).is_some()
            && of_volume.is_some_and(|chunks| chunks <= MOST_CHUNKS)
            && slab.is_some_and(|bytes| bytes <= LARGEST_SLAB);
        if is_possible && self.is_written(voxels.unwrap_or(0)) {
            return Ok(());
        }
        let [x, y, z] = dims;
        Err(ImportError::Unsupported {
            path: self.folder.clone(),
            what: format!(
                "an image of {x} x {y} x {z} voxels, more than can be read at once, or of which hardly a chunk is there"
            ),
            remedy: "Open the folder of a coarser level, or export a part".to_owned(),
        })
    }

    /// Whether so many chunks are there that a volume of `voxels` is believed: what was never written costs memory, too.
    fn is_written(&self, voxels: usize) -> bool {
        let counts: Vec<usize> =
            self.shape.iter().zip(&self.chunk).map(|(side, chunk)| side.div_ceil(*chunk)).collect();
        let of_chunk: usize = self.chunk.iter().product();
        let mut believed = ALWAYS;
        let mut index = vec![0; counts.len()];
        for _ in 0..MOST_CHUNKS {
            if believed >= voxels {
                return true;
            }
            if let Ok(metadata) = crate::files::metadata(self.path_of(&index)) {
                let there = (metadata.length() as usize).saturating_mul(LARGEST_RATIO) / self.sample.bytes();
                believed = believed.saturating_add(of_chunk.min(there).saturating_mul(TIMES));
            }
            // The next one, the last axis first.
            let mut axis = counts.len();
            loop {
                let Some(before) = axis.checked_sub(1) else { return believed >= voxels };
                axis = before;
                index[axis] += 1;
                if index[axis] < counts[axis] {
                    break;
                }
                index[axis] = 0;
            }
        }
        believed >= voxels
    }

    fn path_of(&self, index: &[usize]) -> PathBuf {
        let mut name = self.prefix.to_owned();
        for number in index {
            if !name.is_empty() {
                name.push(self.separator);
            }
            name.push_str(&number.to_string());
        }
        self.folder.join(name)
    }

    fn depth_of_chunk(&self, depth: usize) -> usize {
        let before = self.chunk.len().checked_sub(3);
        before.map_or(1, |axis| self.chunk[axis]).min(depth.max(1))
    }

    /// The bytes of a chunk, little endian; `None` where there is none.
    fn chunk(&self, index: &[usize]) -> Result<Option<Vec<u8>>, ImportError> {
        let path = self.path_of(index);
        // Neither a pipe nor a device is a chunk.
        match crate::files::metadata(&path) {
            Ok(metadata) if metadata.is_file() => {
                if metadata.length() > 2 * LARGEST_CHUNK as u64 {
                    return Err(damaged(&path, "is too long for a chunk"));
                }
            }
            Ok(_) => return Err(damaged(&path, "is no plain file")),
            Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(fault) => return Err(ImportError::Io { path, source: fault }),
        }
        let file = crate::files::read(&path).map_err(ImportError::io(&path))?;
        let wanted = self.chunk.iter().product::<usize>() * self.sample.bytes();
        // No decoder is known to panic; if one does, it costs the chunk and not the program.
        let decode = std::panic::AssertUnwindSafe(|| self.compression.decode(file, wanted));
        let decoded =
            std::panic::catch_unwind(decode).unwrap_or_else(|_| Err("made its decoder give up".to_owned()));
        let mut bytes = decoded.map_err(|problem| damaged(&path, &problem))?;
        if self.big_endian {
            bytes.chunks_exact_mut(self.sample.bytes()).for_each(<[u8]>::reverse);
        }
        Ok(Some(bytes))
    }
}

fn unsupported(path: &Path, what: String) -> ImportError {
    ImportError::Unsupported {
        path: path.to_owned(),
        what,
        remedy: "Save it anew without that, or as NRRD or OME-TIFF".to_owned(),
    }
}

/// A name of a stranger's as a message can quote it.
fn short(name: &str) -> String {
    name.chars().filter(|c| c.is_ascii_alphanumeric() || "._-".contains(*c)).take(40).collect()
}

fn sizes(value: &Value) -> Option<Vec<usize>> {
    let size = |size: &Value| usize::try_from(size.as_u64()?).ok().filter(|size| *size > 0);
    value.as_array()?.iter().map(size).collect()
}

/// The sample where nothing was written; 0 for what is none.
fn fill(value: &Value, sample: SampleType) -> Vec<u8> {
    let float = match value {
        Value::String(text) if text == "NaN" => f64::NAN,
        other => other.as_f64().unwrap_or(f64::from(u8::from(other == &Value::Bool(true)))),
    };
    let integer = value.as_i64().unwrap_or(float as i64);
    let unsigned = value.as_u64().unwrap_or(integer as u64);
    match sample {
        SampleType::F32 => (float as f32).to_le_bytes().to_vec(),
        SampleType::F64 => float.to_le_bytes().to_vec(),
        // The low bytes are those of narrower numbers.
        other => unsigned.to_le_bytes()[..other.bytes()].to_vec(),
    }
}

/// The slices of one channel.
pub(super) struct Volume {
    array: Arc<Array>,
    /// Which axes of the array moments and channels are, if there are any.
    moments: Option<usize>,
    channels: Option<(usize, usize)>,
    depth: Option<usize>,
    dims: [usize; 3],
    /// The slices that one row of chunks holds, as they were read last: which they are, and their samples.
    slab: Mutex<Option<(usize, Vec<u8>)>>,
}

impl Volume {
    /// Of an array whose axes are `letters`, of which the last are `y` and `x`.
    pub(super) fn new(array: Arc<Array>, letters: &[char], channel: usize, dims: [usize; 3]) -> Self {
        let place = |wanted: char| letters.iter().position(|letter| *letter == wanted);
        Self {
            array,
            moments: place('t'),
            channels: place('c').map(|axis| (axis, channel)),
            depth: place('z'),
            dims,
            slab: Mutex::new(None),
        }
    }

    /// Slices of moment `moment` in chunk `row` along z.
    fn read_slab(&self, moment: usize, row: usize, cancel: &CancelToken) -> Result<Vec<u8>, ImportError> {
        let Self { array, dims: [columns, rows, depth], .. } = self;
        let bytes = array.sample.bytes();
        let (of_y, of_x) = (array.shape.len() - 2, array.shape.len() - 1);
        let thick = self.depth.map_or(1, |axis| array.chunk[axis]);
        let slices = thick.min(depth - row * thick);
        let len = columns * rows * slices * bytes;
        let mut slab = Vec::new();
        slab.try_reserve_exact(len)
            .map_err(|_| damaged(&array.description, "promises more than memory has"))?;
        slab.extend(array.fill.iter().copied().cycle().take(len));
        // The place within chunks of what is no axis of space.
        let mut index = vec![0; array.shape.len()];
        let mut within = vec![0; array.shape.len()];
        for (axis, at) in self.moments.map(|axis| (axis, moment)).into_iter().chain(self.channels) {
            index[axis] = at / array.chunk[axis];
            within[axis] = at % array.chunk[axis];
        }
        if let Some(axis) = self.depth {
            index[axis] = row;
        }
        let stride = |axis: usize| array.chunk[axis + 1..].iter().product::<usize>();
        let base: usize =
            (0..of_y).filter(|axis| Some(*axis) != self.depth).map(|axis| within[axis] * stride(axis)).sum();
        for y in 0..rows.div_ceil(array.chunk[of_y]) {
            for x in 0..columns.div_ceil(array.chunk[of_x]) {
                cancel.check()?;
                (index[of_y], index[of_x]) = (y, x);
                let Some(chunk) = array.chunk(&index)? else { continue };
                let (first_row, first_column) = (y * array.chunk[of_y], x * array.chunk[of_x]);
                let wide = array.chunk[of_x].min(columns - first_column);
                let high = array.chunk[of_y].min(rows - first_row);
                for slice in 0..slices {
                    for line in 0..high {
                        let from = base
                            + self.depth.map_or(0, |axis| slice * stride(axis))
                            + line * array.chunk[of_x];
                        let to = (slice * rows + first_row + line) * columns + first_column;
                        slab[to * bytes..][..wide * bytes]
                            .copy_from_slice(&chunk[from * bytes..][..wide * bytes]);
                    }
                }
            }
        }
        Ok(slab)
    }
}

impl Planes for Volume {
    fn plane(&self, index: usize, cancel: &CancelToken) -> Result<Vec<u8>, ImportError> {
        let [columns, rows, depth] = self.dims;
        let (moment, slice) = (index / depth, index % depth);
        let thick = self.depth.map_or(1, |axis| self.array.chunk[axis]);
        let row = slice / thick;
        let key = moment * depth.div_ceil(thick) + row;
        let mut last = self.slab.lock().unwrap_or_else(PoisonError::into_inner);
        let slab = match last.take() {
            Some((own, slab)) if own == key => slab,
            _ => self.read_slab(moment, row, cancel)?,
        };
        let len = columns * rows * self.array.sample.bytes();
        let plane = slab[(slice - row * thick) * len..][..len].to_vec();
        *last = Some((key, slab));
        Ok(plane)
    }
}
