//! Structure sets of radiotherapy (PS3.3 C.8.8.5 and C.8.8.6): contours in the patient, by region of interest.

use lumivox_core::glam::DVec3;

use crate::{
    colors,
    dicom::{
        elements::{attributes as attr, charset::Charset, data_set::DataSet},
        header::names::PatientNames,
    },
};

/// A region of interest.
#[derive(Clone, Debug)]
pub(crate) struct Structure {
    /// ROINumber.
    pub(crate) number: i64,
    /// Empty where none may be told.
    pub(crate) name: String,
    /// Linear, sRGB primaries.
    pub(crate) color: Option<[f64; 3]>,
    /// Closed contours in a plane each, by corners in the patient's mm.
    pub(crate) contours: Vec<Vec<DVec3>>,
    /// Contours of another kind, such as points and open lines: they enclose nothing.
    pub(crate) open: usize,
}

/// Whether a data set is a structure set.
pub(crate) fn is_structure_set(data: &DataSet) -> bool {
    data.text(attr::SOP_CLASS_UID).as_deref() == Some("1.2.840.10008.5.1.4.1.1.481.3")
}

/// The structures of a data set, in the order of their contours.
pub(crate) fn structures(data: &DataSet) -> Vec<Structure> {
    let names = PatientNames::of(data);
    let number = |item: &DataSet, attribute| item.integer_text(attribute).ok().flatten();
    let name = |wanted: i64| {
        let rois = data.items(attr::STRUCTURE_SET_ROI_SEQUENCE).iter();
        let mut own = rois.filter(|item| number(item, attr::ROI_NUMBER) == Some(wanted));
        let text = own.next().and_then(|item| Charset::of(item, data).text(item, attr::ROI_NAME));
        // No longer than it may be, and of one piece: a damaged one may reach into what is said of the patient.
        let text = text.filter(|text| text.chars().count() <= 64 && !text.contains('\0'));
        names.without(&text.unwrap_or_default())
    };
    let structure = |item: &DataSet| {
        let number = number(item, attr::REFERENCED_ROI_NUMBER)?;
        let code = item.decimals::<3>(attr::ROI_DISPLAY_COLOR).ok().flatten();
        let (mut contours, mut open) = (Vec::new(), 0);
        for contour in item.items(attr::CONTOUR_SEQUENCE) {
            let kind = contour.text(attr::CONTOUR_GEOMETRIC_TYPE).unwrap_or_default();
            let numbers = contour.decimal_list(attr::CONTOUR_DATA).ok().flatten().unwrap_or_default();
            let corners: Vec<DVec3> = numbers.chunks_exact(3).map(|p| DVec3::new(p[0], p[1], p[2])).collect();
            // Those that are to be combined by XOR are: an odd number of them is around what is inside.
            let is_closed = matches!(kind.trim(), "CLOSED_PLANAR" | "CLOSEDPLANAR_XOR");
            if is_closed && corners.len() >= 3 {
                contours.push(corners);
            } else {
                open += 1;
            }
        }
        let color = code.map(|code| colors::from_bytes(code.map(|c| c.clamp(0.0, 255.0))));
        Some(Structure { number, name: name(number), color, contours, open })
    };
    data.items(attr::ROI_CONTOUR_SEQUENCE).iter().filter_map(structure).collect()
}
