//! Where what a header says of one frame may stand.

use crate::dicom::elements::{attributes::Attribute, data_set::DataSet};

/// A frame's own functional groups, those shared by all frames, its detector of nuclear medicine, and the data set: the
/// first that has an attribute says it.
pub(crate) struct FrameScope<'a> {
    pub(crate) own: Option<&'a DataSet>,
    pub(crate) shared: Option<&'a DataSet>,
    pub(crate) detector: Option<&'a DataSet>,
    pub(crate) data: &'a DataSet,
}

impl<'a> FrameScope<'a> {
    /// The macro `sequence` of this frame, or the data set, where `attribute` is.
    pub(crate) fn find(&self, sequence: Attribute, attribute: Attribute) -> &'a DataSet {
        [self.own, self.shared]
            .into_iter()
            .flatten()
            .filter_map(|group| group.items(sequence).first())
            .chain(self.detector)
            .find(|item| item.bytes(attribute).is_some())
            .unwrap_or(self.data)
    }
}
