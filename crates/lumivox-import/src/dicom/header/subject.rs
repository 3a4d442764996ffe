//! What an image is of, as its header says in coded words and free texts: a [`Subject`], which holds no text.

use lumivox_core::Subject;

use crate::dicom::elements::{attributes as attr, data_set::DataSet};

/// What the header says; the body part that was coded goes before what descriptions, protocol and filter say.
pub(crate) fn subject(data: &DataSet) -> Subject {
    let texts = [
        attr::BODY_PART_EXAMINED,
        attr::SERIES_DESCRIPTION,
        attr::PROTOCOL_NAME,
        attr::STUDY_DESCRIPTION,
        attr::CONVOLUTION_KERNEL,
    ]
    .map(|attribute| data.text(attribute).unwrap_or_default());
    let mut subject = Subject::of_texts(texts.iter().map(String::as_str));
    // Some scanners write that there was none.
    let agent = data.text(attr::CONTRAST_BOLUS_AGENT).unwrap_or_default().trim().to_lowercase();
    if !["", "none", "no", "n", "0"].contains(&agent.as_str()) {
        subject.contrast = Some(true);
    }
    subject
}
