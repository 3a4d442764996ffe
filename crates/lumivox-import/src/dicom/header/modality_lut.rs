//! Tables that make values of the modality of stored ones.

use crate::dicom::elements::{attributes as attr, data_set::DataSet, values::FieldFault};

/// A table from stored values to those of the modality (PS3.3 C.11.1.1).
#[derive(Debug, PartialEq)]
pub(crate) struct ModalityLut {
    /// The stored value of the first entry.
    first: i64,
    /// Never empty.
    entries: Vec<u16>,
}

impl ModalityLut {
    /// The table of a data set, if it has one.
    ///
    /// # Errors
    /// Where the table is not what its descriptor says.
    pub(crate) fn of(data: &DataSet, signed: bool) -> Result<Option<Self>, FieldFault> {
        let Some(item) = modality_lut(data) else { return Ok(None) };
        let Some([count, first, bits]) =
            item.words(attr::LUT_DESCRIPTOR).and_then(|words| <[u16; 3]>::try_from(words).ok())
        else {
            return Err(FieldFault::new(attr::LUT_DESCRIPTOR, "does not have three values"));
        };
        // PS3.3 C.11.1.1.1: 0 stands for 65536, and the first value mapped has the sign of the pixels.
        let count = if count == 0 { 1 << 16 } else { usize::from(count) };
        let first = if signed { i64::from(first as i16) } else { i64::from(first) };
        let entries = match item.bytes(attr::LUT_DATA) {
            // Some writers pack entries of 8 bits.
            Some(bytes) if bits <= 8 && bytes.len() < 2 * count && bytes.len() >= count => {
                bytes[..count].iter().map(|&b| b.into()).collect()
            }
            _ => item.words(attr::LUT_DATA).unwrap_or_default(),
        };
        if entries.len() < count {
            let problem = format!("has {} entries where its descriptor says {count}", entries.len());
            return Err(FieldFault::new(attr::LUT_DATA, problem));
        }
        Ok(Some(Self { first, entries: entries[..count].to_vec() }))
    }

    /// The value of a stored one; beyond the table the nearest entry counts.
    #[inline]
    pub(crate) fn get(&self, stored: i64) -> u16 {
        let index = (stored - self.first).clamp(0, self.entries.len() as i64 - 1);
        self.entries[index as usize]
    }

    /// The largest value of the table.
    pub(crate) fn largest(&self) -> u16 {
        self.entries.iter().copied().max().unwrap_or(0)
    }
}

/// The item of ModalityLUTSequence, unless nothing is in it: some writers leave an empty one behind, beside a rescale.
pub(crate) fn modality_lut(data: &DataSet) -> Option<&DataSet> {
    let has = |item: &DataSet, attribute| item.bytes(attribute).is_some_and(|bytes| !bytes.is_empty());
    let item = data.items(attr::MODALITY_LUT_SEQUENCE).first()?;
    (has(item, attr::LUT_DESCRIPTOR) || has(item, attr::LUT_DATA)).then_some(item)
}
